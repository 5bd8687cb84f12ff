# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The relay between the launcher and the control socket of a part."""

from collections.abc import Mapping
import math
import os
import select
import time
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.engine.launch_scan import launcher_of
from colcon_yamllaunch.remote.agent import launcher_channel
from colcon_yamllaunch.remote.agent.launcher_channel import (
    LauncherChannel,
    LauncherGoneError,
)
from colcon_yamllaunch.remote.agent.part_sockets import (
    boot_of_machine,
    PartSockets,
    stop_orphans,
)

_READ = 256 * 1024
#: Bytes that may wait in each direction.
_MAXIMUM_BACKLOG = 1024 * 1024
#: Seconds that the launcher gets to take the last of it.
_LAST_TIMEOUT = 5.0
_INTERVAL = 0.5
_KILLED = 'its launcher there was killed, and its processes were stopped'
#: Seconds that the launcher may take to start its other parts.
_FIRST_TIMEOUT = 60.0


def relay(launcher: LauncherChannel, content: Mapping[str, Any]) -> None:
    """
    Start the engine of a part, or connect with one that runs, and relay.

    Return when either end is gone.

    :param content: The request `start`, with a `plan` and `settings`, or
      `resume`, with the `identity` of the part and the `boot` of the machine
    :raises LauncherGoneError: when the launcher is gone
    :raises UserError: when it cannot be started, or is gone; nothing of it is
      left then
    """
    sockets = PartSockets(os.environ)
    if content['request'] == 'start':
        from colcon_yamllaunch.remote.agent.part import start_engine

        identity = start_engine(launcher, sockets, content)
    elif content['boot'] == boot_of_machine():
        identity = str(content['identity'])
    else:
        raise UserError('the machine was started anew meanwhile')
    try:
        engine = sockets.connect(identity)
    except OSError as error:
        if _is_alive(identity):
            raise UserError(
                f'its socket cannot be used: {error.strerror}'
            ) from error
        was_killed = sockets.has_socket(identity)
        _clear(sockets, identity)
        raise UserError(
            _KILLED if was_killed else 'it has ended there'
        ) from error
    result = {'identity': identity, 'boot': boot_of_machine()}
    launcher_channel.send({'reply': content.get('id'), 'result': result})
    with engine:
        # it may start its other parts first
        launcher.silence = _FIRST_TIMEOUT
        while 'relay' not in launcher.next_message():
            continue
        launcher_channel.send({'relay': True})
        pass_on(engine.fileno())
    # else it has another connection, or wants none
    if not _is_alive(identity) and sockets.has_socket(identity):
        _clear(sockets, identity)
        launcher_channel.send({'killed': _KILLED})


def _clear(sockets: PartSockets, identity: str) -> None:
    """End what is left of a part whose engine is gone."""
    stop_orphans(identity)
    sockets.remove(identity)


def _is_alive(identity: str) -> bool:
    launcher = launcher_of(identity)
    return launcher is not None and launcher[1]


def pass_on(engine: int) -> None:
    """
    Copy data in both directions until the engine closes its end.

    :raises LauncherGoneError: when the launcher is gone
    """
    for descriptor in (0, 1, engine):
        os.set_blocking(descriptor, False)
    # to the engine, and to the launcher
    down, up = bytearray(), bytearray()
    at_end = False
    deadline = math.inf
    # what nobody takes any more, as in a network that is gone, is given up
    while (not at_end or up) and time.monotonic() < deadline:
        poll = select.poll()
        masks: dict[int, int] = {}
        if len(down) < _MAXIMUM_BACKLOG:
            masks[0] = select.POLLIN
        if up:
            masks[1] = select.POLLOUT
        if not at_end:
            mask = select.POLLIN if len(up) < _MAXIMUM_BACKLOG else 0
            masks[engine] = mask | (select.POLLOUT if down else 0)
        for descriptor, mask in masks.items():
            poll.register(descriptor, mask)
        if at_end and deadline == math.inf:
            deadline = time.monotonic() + _LAST_TIMEOUT
        for descriptor, found in poll.poll(
            _INTERVAL * 1000 if at_end else None
        ):
            if descriptor == 0:
                if not _read(0, down):
                    # its last words, such as that all is to be stopped
                    os.set_blocking(engine, True)
                    _write(engine, down)
                    raise LauncherGoneError
            elif descriptor == 1:
                if not _write(1, up):
                    raise LauncherGoneError
            else:
                if found & (select.POLLIN | select.POLLHUP | select.POLLERR):
                    at_end = not _read(engine, up)
                if found & select.POLLOUT and not at_end:
                    _write(engine, down)


def _read(descriptor: int, data: bytearray) -> bool:
    """Read more, and return whether it is open."""
    try:
        more = os.read(descriptor, _READ)
    except BlockingIOError:
        return True
    except OSError:
        return False
    data += more
    return bool(more)


def _write(descriptor: int, data: bytearray) -> bool:
    """Write what can be written, and return whether it is open."""
    try:
        del data[: os.write(descriptor, data)]
    except BlockingIOError:
        return True
    except OSError:
        return False
    return True
