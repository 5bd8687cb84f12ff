# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Whether what was built here runs on a machine."""

from collections.abc import Mapping
from collections.abc import Sequence
import re

from colcon_yamllaunch.common.errors import UserError

_WAY_OUT = 'build there instead, by `sync: build`'


def check_system(
    here: Mapping[str, str], there: Mapping[str, str], pythons: Sequence[str]
) -> None:
    """
    Check that what was built here runs there.

    :param here: What this machine is like, see `install_there.system`
    :param there: What that one is like
    :param pythons: The versions of Python that modules are installed for
    :raises UserError: when it does not
    """
    for key, verb in (('architecture', 'is'), ('system', 'runs')):
        if here[key] != there[key]:
            raise UserError(
                f'it {verb} {there[key] or "unknown"}, and what is built here '
                f'is for {here[key]}: {_WAY_OUT}'
            )
    if _numbers(there['glibc']) < _numbers(here['glibc']):
        raise UserError(
            f'its C library is glibc {there["glibc"] or "of no version"}, and '
            f'what is built here is for {here["glibc"]}: {_WAY_OUT}'
        )
    if pythons and there['python'] not in pythons:
        raise UserError(
            f'its python3 is {there["python"] or "missing"}, and modules are '
            f'built here for {" and ".join(pythons)}: {_WAY_OUT}'
        )


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(map(int, re.findall(r'\d+', version)))
