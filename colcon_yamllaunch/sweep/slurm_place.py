# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What `--on slurm:…` says: options of sbatch."""

import re

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass

_KIND = 'slurm'
_NAME = re.compile(r'[a-z][a-z-]*')
#: What the sweep itself decides.
_OURS = frozenset(
    (
        *('array', 'chdir', 'dependency', 'error', 'export', 'hold', 'input'),
        *('output', 'parsable', 'requeue', 'no-requeue', 'test-only', 'wait'),
        *('wrap', 'job-name'),
    )
)


@dataclass(frozen=True, slots=True)
class SlurmPlace:
    """
    Slurm, and how it is asked.

    :param options: Options of `sbatch`, as `--partition=cpu`
    """

    options: tuple[str, ...] = ()


def read_place(option: str, text: str) -> SlurmPlace:
    """
    Read what the user wrote, `slurm:partition=cpu,time=10`.

    A comma in brackets is part of a value, as in `nodelist=n[1,3]`.

    :raises UserError: when it is not that
    """
    kind, _, rest = text.partition(':')
    if kind != _KIND:
        raise UserError(
            f'{option} is written {_KIND}:OPTION=VALUE,… with options of '
            f"sbatch, such as {_KIND}:partition=cpu,time=10, not '{text}'"
        )
    words = [word for word in re.split(r',(?![^\[]*\])', rest) if word]
    return SlurmPlace(tuple(_sbatch_option(option, word) for word in words))


def _sbatch_option(option: str, word: str) -> str:
    name, is_given, value = word.partition('=')
    name = name.strip().removeprefix('--')
    if not _NAME.fullmatch(name):
        raise UserError(
            f"{option}: '{word}' is no option of sbatch",
            'they are written name=value, as in partition=cpu; a comma '
            'separates them',
        )
    if name in _OURS:
        raise UserError(
            f"{option}: '{name}' is for the sweep to say, not for its user"
        )
    return f'--{name}={value}' if is_given else f'--{name}'
