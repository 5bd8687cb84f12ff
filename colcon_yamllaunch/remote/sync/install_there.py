# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a machine is like, for what was built elsewhere. Runs there."""

from collections.abc import Callable
from collections.abc import Mapping
from contextlib import suppress
import os
from pathlib import Path
import platform
import shutil
import subprocess
from typing import Any

from colcon_yamllaunch.remote.sync.sources_there import prepared_root

Say = Callable[[str], None]

_PYTHON_TIMEOUT = 10.0
_RELEASE = Path('/etc/os-release')


def look(arguments: Mapping[str, Any], say: Say) -> dict[str, Any]:
    """
    Look whether what was built elsewhere can run here.

    The arguments are `workspace`, the root of it; `interpreters` and
    `underlays`, paths. Return the `root`; which of the interpreters and
    underlays are `missing`; and what :func:`system` returns, as `system`.
    """
    root = prepared_root(str(arguments['workspace']), say)
    missing = [
        path for path in arguments['interpreters'] if not os.path.exists(path)
    ]
    missing += [
        path
        for path in arguments['underlays']
        if not Path(path, 'local_setup.bash').is_file()
    ]
    return {'root': root, 'missing': missing, 'system': system()}


def system() -> dict[str, str]:
    """Tell what programs and modules depend on that were built."""
    values = {}
    with suppress(OSError):
        for line in _RELEASE.read_text(errors='replace').splitlines():
            name, _, value = line.partition('=')
            values[name] = value.strip('"\'')
    return {
        'system': ' '.join(
            (values.get('ID', ''), values.get('VERSION_ID', ''))
        ).strip(),
        'architecture': platform.machine(),
        'glibc': platform.libc_ver()[1],
        'python': _python(),
    }


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
