# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The lock of the workspace, while code is sent and built. Runs on the machine.

Each request is answered by a process of its own, and a lock ends with the
process that holds it. So a further process holds it from the first request to
the last, or until the process ends that answers them.
"""

from collections.abc import Callable
from collections.abc import Mapping
from contextlib import suppress
import json
import os
from pathlib import Path
import signal
import sys
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.process_scan import read_process
from colcon_yamllaunch.workspace.building.build_lock import LOCK_NAME
from colcon_yamllaunch.workspace.building.build_lock import WorkspaceLock

Say = Callable[[str], None]

#: How often the holder checks whether the agent still runs (seconds).
_INTERVAL = 0.1


def hold(root: str, arguments: Mapping[str, Any], say: Say) -> list[int]:
    """
    Wait for the lock, and start a process that holds it.

    The arguments are the `build_base`; the `title`, the command; and the
    `launcher`, its boot id and process id. If the workspace is that of the
    launcher itself, the launcher holds the lock already. Return the argument
    of :func:`release`.

    :raises UserError: when there can be no lock
    """
    base = Path(root, str(arguments['build_base']))
    if _is_launchers(base, arguments['launcher']):
        return []
    agent = os.getppid()
    reading, writing = os.pipe()
    sys.stdout.flush()
    pid = os.fork()
    if not pid:
        try:
            os.setsid()
            _close_all_but(writing)
            _hold(base, str(arguments['title']), agent, writing)
        finally:
            os._exit(0)
    os.close(writing)
    with open(reading) as file:
        for kind, text in map(json.loads, file):
            if kind == 'taken':
                return [pid, _birth(pid)]
            if kind == 'error':
                raise UserError(text)
            say(text)
    raise UserError('the lock of the workspace there cannot be taken')


def boot_id() -> str:
    """Return the identity of this boot of the machine; empty if unknown."""
    try:
        return Path('/proc/sys/kernel/random/boot_id').read_text().strip()
    except OSError:
        return ''


def release(arguments: Mapping[str, Any], say: Say) -> dict[str, Any]:  # noqa: ARG001
    """End the process that :func:`hold` has started, the `holder`."""
    if arguments['holder']:
        pid, birth = arguments['holder']
        if _birth(pid) == birth:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGTERM)
    return {}


def _hold(base: Path, title: str, agent: int, asker: int) -> None:
    """
    Take the lock, and hold it until SIGTERM or the end of the agent.

    :param asker: A descriptor that the asker reads messages from
    """

    def send(kind: str, text: str = '') -> None:
        with suppress(BrokenPipeError):
            os.write(asker, json.dumps([kind, text]).encode() + b'\n')

    def end(*_: object) -> None:
        raise SystemExit

    def check(*_: object) -> None:
        if read_process(agent) is None:
            raise SystemExit

    signal.signal(signal.SIGTERM, end)
    # it also interrupts waiting for the lock
    signal.signal(signal.SIGALRM, check)
    signal.setitimer(signal.ITIMER_REAL, _INTERVAL, _INTERVAL)
    with suppress(SystemExit), WorkspaceLock(title) as lock:
        try:
            lock.take(base, lambda line: send('line', line))
        except UserError as e:
            send('error', str(e))
            return
        send('taken')
        os.close(asker)
        while True:
            signal.pause()


def _close_all_but(descriptor: int) -> None:
    # the agent waits for the end of all that write to the request's pipe
    for name in os.listdir('/proc/self/fd'):
        if int(name) > 2 and int(name) != descriptor:
            with suppress(OSError):
                os.close(int(name))
    null = os.open(os.devnull, os.O_RDWR)
    for standard in (0, 1, 2):
        os.dup2(null, standard)


def _is_launchers(base: Path, launcher: tuple[str, int]) -> bool:
    boot, pid = launcher
    with suppress(OSError, ValueError):
        holder = (base / LOCK_NAME).read_bytes().partition(b'\t')[0]
        return int(holder) == pid and boot_id() == boot
    return False


def _birth(pid: int) -> int:
    process = read_process(pid)
    return -1 if process is None else process.birth
