# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The lock of the workspace there, while code is brought and built.

Each request is answered by a process of its own, and a lock ends with the
process that has it. So one that does nothing else holds it from the first
request to the last, or until the process is gone that asks for them.
"""

from collections.abc import Callable
from collections.abc import Mapping
from contextlib import suppress
import os
from pathlib import Path
import signal
import sys
import time
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.process_scan import read_process
from colcon_yamllaunch.workspace.building.build_lock import LOCK_NAME
from colcon_yamllaunch.workspace.building.build_lock import WorkspaceLock

Say = Callable[[str], None]

_BOOT_ID = Path('/proc/sys/kernel/random/boot_id')
#: How often it is looked whether who asked is there still (seconds).
_INTERVAL = 0.1
#: How the lines of the holder begin.
_LINE, _TAKEN, _FAILED = b'l', b't', b'f'


def hold(root: str, arguments: Mapping[str, Any], say: Say) -> list[int]:
    """
    Take the lock, waiting for who has it, and leave it to a process.

    The arguments are the `build_base`; the `title`, the command; and the
    `launcher`, its boot id and process id: where the workspace there is that
    of the launcher itself, it has the lock, and waits for us. Return what
    :func:`release` takes.

    :raises UserError: when there cannot be one
    """
    base = Path(root, str(arguments['build_base']))
    if _is_launchers(base, arguments['launcher']):
        return []
    asking = os.getppid()
    reading, writing = os.pipe()
    sys.stdout.flush()
    pid = os.fork()
    if not pid:
        code = 1
        try:
            _close_all_but(writing)
            os.setsid()
            _hold(base, str(arguments['title']), asking, writing)
            code = 0
        finally:
            os._exit(code)
    os.close(writing)
    with open(reading, 'rb') as file:
        for line in file:
            kind, text = line[:1], line[1:].decode(errors='replace').rstrip()
            if kind == _TAKEN:
                return [pid, _birth(pid)]
            if kind == _FAILED:
                raise UserError(text)
            say(text)
    raise UserError('the lock of the workspace there cannot be taken')


def release(arguments: Mapping[str, Any], say: Say) -> dict[str, Any]:  # noqa: ARG001
    """Let the lock go that :func:`hold` has taken, its `holder`."""
    if arguments['holder']:
        pid, birth = arguments['holder']
        if _birth(pid) == birth:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGTERM)
    return {}


def _hold(base: Path, title: str, asking: int, told: int) -> None:
    def tell(kind: bytes, text: str = '') -> None:
        line = text.replace('\n', ' ').encode(errors='replace')
        with suppress(BrokenPipeError):
            os.write(told, kind + line + b'\n')

    def end(*_: object) -> None:
        raise SystemExit

    def look(*_: object) -> None:
        if not _is_there(asking):
            raise SystemExit

    signal.signal(signal.SIGTERM, end)
    # who waits here for somebody else waits for nobody when that is gone
    signal.signal(signal.SIGALRM, look)
    signal.setitimer(signal.ITIMER_REAL, _INTERVAL, _INTERVAL)
    lock = WorkspaceLock(title)
    with suppress(SystemExit), lock:
        try:
            lock.take(base, lambda line: tell(_LINE, line))
        except UserError as e:
            tell(_FAILED, str(e))
            return
        tell(_TAKEN)
        os.close(told)
        while True:
            time.sleep(_INTERVAL)


def _close_all_but(kept: int) -> None:
    # who waits for the end of the request would wait for ours
    for name in os.listdir('/proc/self/fd'):
        if int(name) > 2 and int(name) != kept:
            with suppress(OSError):
                os.close(int(name))
    null = os.open(os.devnull, os.O_RDWR)
    for standard in (0, 1, 2):
        os.dup2(null, standard)


def _is_there(asking: int) -> bool:
    """Tell whether the process is there that asks for us."""
    return read_process(asking) is not None


def _is_launchers(base: Path, launcher: tuple[str, int]) -> bool:
    boot, pid = launcher
    with suppress(OSError, ValueError):
        holder = (base / LOCK_NAME).read_bytes().partition(b'\t')[0]
        return int(holder) == pid and _BOOT_ID.read_text().strip() == boot
    return False


def _birth(pid: int) -> int:
    process = read_process(pid)
    return -1 if process is None else process.birth
