# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A program that the launcher speaks with through the connection."""

from collections.abc import Mapping
from contextlib import suppress
import os
import select
import subprocess
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.escalation import Timeouts
from colcon_yamllaunch.engine.launch_scan import LAUNCH_ID_VARIABLE
from colcon_yamllaunch.engine.launch_scan import new_identity
from colcon_yamllaunch.remote.agent import launcher_channel
from colcon_yamllaunch.remote.agent.launcher_channel import LauncherChannel
from colcon_yamllaunch.remote.connection import frames

_READ = 256 * 1024
#: Bytes that may wait for a program that does not read.
_WAITING = 4 * 1024 * 1024
_TIMEOUTS = Timeouts(1.0, 1.0)


def run_program(
    launcher: LauncherChannel, content: Mapping[str, Any]
) -> dict[str, Any]:
    """
    Run a program whose standard streams are the launcher's.

    :raises LauncherGoneError: when the launcher is gone, and it is ended
    :raises UserError: when it cannot be started
    """
    argv = [str(word) for word in content['argv']]
    identity = new_identity()
    variables = {**os.environ, LAUNCH_ID_VARIABLE: f'{identity}.0'}
    try:
        process = subprocess.Popen(
            argv,
            cwd=os.path.expanduser('~'),
            env=variables,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
    except OSError as error:
        raise UserError(f'{argv[0]}: {error.strerror}') from error
    try:
        if not _pass_on(launcher, process):
            _end(process, identity)
        code = process.wait()
    except launcher_channel.LauncherGoneError:
        _end(process, identity)
        raise
    return {'code': code if code >= 0 else 128 - code}


def _end(process: 'subprocess.Popen[bytes]', identity: str) -> None:
    from colcon_yamllaunch.remote.agent.left_processes import end_in_any_case

    end_in_any_case(identity, process.pid, _TIMEOUTS)


def _pass_on(
    launcher: LauncherChannel, process: 'subprocess.Popen[bytes]'
) -> bool:
    """Pass on its streams until they end; return False to end it before."""
    assert process.stdin and process.stdout and process.stderr
    stdin = process.stdin.fileno()
    os.set_blocking(stdin, False)
    readers = {process.stdout.fileno(): True, process.stderr.fileno(): False}
    waiting = bytearray()
    at_end = False
    while readers:
        masks = dict.fromkeys(readers, select.POLLIN)
        if waiting:
            masks[stdin] = select.POLLOUT
        # else the launcher waits meanwhile
        listens = len(waiting) < _WAITING
        ready = launcher.poll(masks, listens=listens)
        for frame in launcher.taken_frames():
            if frame.kind == frames.STREAM and not at_end:
                waiting += frame.body
                at_end = not frame.body
            elif frame.kind == frames.CONTROL and 'end' in frame.content():
                return False
        if waiting and stdin in ready:
            try:
                del waiting[: os.write(stdin, waiting)]
            except BlockingIOError:
                pass
            except OSError:
                # it reads no more
                waiting.clear()
                at_end = True
        if at_end and not waiting and not process.stdin.closed:
            with suppress(OSError):
                process.stdin.close()
        for descriptor in ready & readers.keys():
            data = os.read(descriptor, _READ)
            if not data:
                del readers[descriptor]
            elif readers[descriptor]:
                launcher_channel.write(frames.encode(frames.STREAM, data))
            else:
                for line in data.decode(errors='replace').splitlines():
                    launcher_channel.send({'line': line})
    return True
