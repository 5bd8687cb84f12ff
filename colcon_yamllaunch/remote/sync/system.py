# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a machine is like, and whether what was built elsewhere runs on it."""

from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import suppress
import os
from pathlib import Path
import platform
import re
import shutil
import subprocess

from colcon_yamllaunch.common.errors import UserError

_PYTHON_TIMEOUT = 10.0
_RELEASES = (Path('/etc/os-release'), Path('/usr/lib/os-release'))
_WAY_OUT = 'build there instead, by `sync: build`'


def system() -> dict[str, str]:
    """Return what programs and modules depend on that were built here."""
    return {
        'system': system_name(),
        'architecture': platform.machine(),
        'glibc': platform.libc_ver()[1],
        'python': _python(),
    }


def system_name() -> str:
    """Return the name and version of the system, as os-release(5) has them."""
    values: dict[str, str] = {}
    for path in _RELEASES:
        with suppress(OSError):
            for line in path.read_text(errors='replace').splitlines():
                name, _, value = line.partition('=')
                values[name] = value.strip('"\'')
            break
    found = (values.get('ID', os.uname().sysname), values.get('VERSION_ID'))
    return ' '.join(filter(None, found))


def login_shell_line(command: str, timeout: float) -> str:
    """
    Return the last line that a command prints in the user's login shell.

    It is empty if the command fails.

    :param timeout: How long the shell may take, in seconds
    """
    shell = os.environ.get('SHELL') or '/bin/sh'
    with suppress(OSError, subprocess.SubprocessError):
        printed = subprocess.run(
            [shell, '-lc', command],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=timeout,
        ).stdout
        return (os.fsdecode(printed).splitlines() or [''])[-1]
    return ''


def _python() -> str:
    """Return the version of the Python that programs get, as `3.12`."""
    python = shutil.which('python3')
    if python is None:
        return ''
    program = 'import sys; print("%d.%d" % sys.version_info[:2])'
    with suppress(OSError, subprocess.SubprocessError):
        return subprocess.run(
            [python, '-I', '-S', '-c', program],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=_PYTHON_TIMEOUT,
            text=True,
        ).stdout.strip()
    return ''


def check_system(
    here: Mapping[str, str], there: Mapping[str, str], pythons: Sequence[str]
) -> None:
    """
    Check that what was built here runs there.

    :param here: What :func:`system` returns here
    :param there: What it returns there
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
