# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The processes of a build, found by a variable that they inherit.

When a launch is killed while it builds, its make and its compilers go on, and
would write into the folders of the next build.
"""

from collections.abc import Callable
from contextlib import suppress
import os
from pathlib import Path
import signal
import time

#: The variable that the processes of a build have; its value is the process
#: id of the launch, a colon, and the build folder.
MARK = 'COLCON_LAUNCH_BUILD'
#: How long they have after SIGTERM, and after SIGKILL (seconds).
PATIENCE = 2.0
#: Between two looks whether they have ended (seconds).
_INTERVAL = 0.02


def mark(build_base: Path) -> dict[str, str]:
    """Return the variable for what this process builds."""
    return {MARK: f'{os.getpid()}:{build_base}'}


def own_processes() -> list[int]:
    """Find the running processes of what this process builds."""
    return _marked(f'{os.getpid()}:', '')


def end_own_processes() -> None:
    """End the processes of what this process builds, and wait for that."""
    _end(own_processes)


def end_orphan_builds(
    build_base: Path, announce: Callable[[str], None]
) -> None:
    """
    End the processes of earlier builds in a workspace, and wait for that.

    To be called while no other launch builds there.

    :param announce: Is called with one line if there are some
    """

    def find() -> list[int]:
        return _marked('', f':{build_base}')

    found = find()
    if found:
        announce(
            'ending what is left of a build that was killed: process '
            + ', '.join(map(str, found))
        )
        _end(find)


def _end(find: Callable[[], list[int]]) -> None:
    for number in signal.SIGTERM, signal.SIGKILL:
        deadline = time.monotonic() + PATIENCE
        asked: set[int] = set()
        # also those that are started in the meantime
        while (found := find()) and time.monotonic() < deadline:
            for pid in set(found) - asked:
                send(pid, number)
            asked.update(found)
            time.sleep(_INTERVAL)


def send(pid: int, number: int) -> None:
    """Send a signal, unless the process has ended or is not ours."""
    with suppress(ProcessLookupError, PermissionError):
        os.kill(pid, number)


def _marked(start: str, end: str) -> list[int]:
    """Find the processes whose mark starts and ends so."""
    name = f'{MARK}='.encode()
    beginning, ending = name + os.fsencode(start), os.fsencode(end)
    found = []
    for process in Path('/proc').glob('[0-9]*'):
        # that of others cannot be read, that of a zombie is empty
        with suppress(OSError):
            variables = (process / 'environ').read_bytes().split(b'\0')
            if any(
                v.startswith(beginning) and v.endswith(ending)
                for v in variables
            ):
                found.append(int(process.name))
    return sorted(found)
