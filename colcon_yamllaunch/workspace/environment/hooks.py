# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What the environment hooks of an installed package do.

They are described in dsv files, one `operation;argument;…` a line. The rules
are those of colcon's and ament's prefix scripts (colcon-core,
shell/template/prefix_util.py.em; ament_package, _local_setup_util.py).
"""

import os
import re

_SET = ('set', 'set-if-unset')
_IF_EXISTS = 'prepend-non-duplicate-if-exists'
_EXTEND = ('append-non-duplicate', 'prepend-non-duplicate', _IF_EXISTS)
#: How package.sh names its hooks (colcon-core, shell/template/package.sh.em).
_SH_HOOK = re.compile(
    r'^_colcon_package_sh_source_script "\$COLCON_CURRENT_PREFIX/([^"\n]+)"',
    re.M,
)


class DamagedHooksError(Exception):
    """A description of hooks that sourcing trips over or falls short with."""

    def __init__(self, path: str, reason: str) -> None:
        super().__init__(f'{path} is damaged: {reason}')


def extended_variables(prefix: str, name: str) -> list[tuple[str, str]]:
    """
    Return the variables that sourcing a package extends, with the paths.

    :param prefix: The prefix that it is installed in
    :raises DamagedHooksError: when a description of its hooks is damaged
    """
    extended: list[tuple[str, str]] = []
    path = os.path.join(prefix, 'share', name, 'package.dsv')
    if os.path.exists(path):
        _read((path,), prefix, extended)
        _check_complete(path)
    return extended


def _read(
    chain: tuple[str, ...], prefix: str, extended: list[tuple[str, str]]
) -> None:
    path = chain[-1]
    if path in chain[:-1]:
        raise DamagedHooksError(path, 'it names itself')
    bases: dict[str, None] = {}
    for number, line in enumerate(_text(path).splitlines(), 1):
        if not line.strip() or line.startswith('#'):
            continue
        operation, separator, remainder = line.partition(';')
        try:
            if not separator:
                raise ValueError('there is no semicolon')
            if operation == 'source':
                bases[_base(remainder)] = None
            else:
                extended += _extended(operation, remainder, prefix)
        except ValueError as e:
            raise DamagedHooksError(path, f'line {number}: {e}') from e
    for base in bases:
        base = os.path.join(prefix, base)
        description = f'{base}.dsv'
        if os.path.exists(description):
            _check_not_empty(description, base)
            _read((*chain, description), prefix, extended)


def _base(hook: str) -> str:
    base, extension = os.path.splitext(hook)
    if not extension:
        raise ValueError(f"'{hook}' has no extension")
    return base


def _extended(
    operation: str, remainder: str, prefix: str
) -> list[tuple[str, str]]:
    name, *values = remainder.split(';')
    if operation in _SET:
        if not values:
            raise ValueError(f'{name} is given no value')
        return []
    if operation not in _EXTEND:
        raise ValueError(f"there is no operation '{operation}'")
    if not values:
        raise ValueError(f'{name} is given no path')
    paths = [os.path.join(prefix, v) if v else prefix for v in values]
    if operation == _IF_EXISTS:
        paths = list(filter(os.path.exists, paths))
    return [(name, path) for path in paths]


def _check_not_empty(description: str, base: str) -> None:
    # both are written together, so a write was cut off
    if os.path.getsize(description) == 0 and os.path.exists(f'{base}.sh'):
        raise DamagedHooksError(description, 'it is empty')


def _check_complete(path: str) -> None:
    script = f'{path.removesuffix(".dsv")}.sh'
    if not os.path.exists(script):
        return
    described = set(_text(path).splitlines())
    for hook in _SH_HOOK.findall(_text(script)):
        if f'source;{hook}' not in described:
            raise DamagedHooksError(path, f'it lacks {hook}')


def _text(path: str) -> str:
    try:
        with open(path, encoding='utf-8', errors='surrogateescape') as file:
            return file.read()
    except OSError as e:
        raise DamagedHooksError(path, e.strerror or str(e)) from e
