# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The system of a machine, and whether code from elsewhere runs on it."""

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
    """Return the properties that compiled programs and modules depend on."""
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
    built_on: Mapping[str, str],
    pythons: Sequence[str],
    underlays: Sequence[str],
) -> None:
    """
    Check that code that was built elsewhere runs here.

    :param built_on: The result of :func:`system` where it was built
    :param pythons: The versions of Python that modules are installed for
    :param underlays: The prefixes that it was built on top of
    :raises UserError: when it does not
    """
    ours = system()
    for key, verb in (('architecture', 'is'), ('system', 'runs')):
        if built_on[key] != ours[key]:
            raise UserError(
                f'it {verb} {ours[key] or "unknown"}, and what is built here '
                f'is for {built_on[key]}: {_WAY_OUT}'
            )
    if _numbers(ours['glibc']) < _numbers(built_on['glibc']):
        raise UserError(
            f'its C library is glibc {ours["glibc"] or "of no version"}, and '
            f'what is built here is for {built_on["glibc"]}: {_WAY_OUT}'
        )
    if pythons and ours['python'] not in pythons:
        raise UserError(
            f'its python3 is {ours["python"] or "missing"}, and modules are '
            f'built here for {" and ".join(pythons)}: {_WAY_OUT}'
        )
    for underlay in underlays:
        if not Path(underlay, 'local_setup.bash').is_file():
            raise UserError(
                f'what is built here needs {underlay}, which is not there: '
                'install it there, or build there by `sync: build`'
            )


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(map(int, re.findall(r'\d+', version)))
