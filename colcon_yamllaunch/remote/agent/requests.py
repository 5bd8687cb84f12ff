# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Functions that the launcher calls by name, and programs that it speaks with.

Each runs in its own process, so that it and all that it started can be ended
when the launcher is gone.
"""

from collections.abc import Mapping
from contextlib import suppress
import importlib
import os
import select
import signal
import subprocess
import sys
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.escalation import Timeouts
from colcon_yamllaunch.common.prctl import end_with_parent
from colcon_yamllaunch.engine.launch_scan import LAUNCH_ID_VARIABLE
from colcon_yamllaunch.engine.launch_scan import new_identity
from colcon_yamllaunch.remote.agent import launcher_channel
from colcon_yamllaunch.remote.agent.launcher_channel import LauncherChannel

#: The modules of `remote/sync` whose functions the launcher may call.
MODULES = ('build', 'inspection', 'manifest')
# for a build, which ends its compilers
_TIMEOUTS = Timeouts(3.0, 3.0)
_REPLIED = 0
_READ = 256 * 1024
#: Bytes that may wait for a program that does not read.
_WAITING = 4 * 1024 * 1024
#: How a program that is no longer needed is stopped.
_PROGRAM_TIMEOUTS = Timeouts(1.0, 1.0)


def answer(
    launcher: LauncherChannel, name: str, content: Mapping[str, Any]
) -> None:
    """
    Call a function; it answers by itself.

    :raises LauncherGoneError: when the launcher is gone, and all is ended
    :raises UserError: when there is no such function, or it broke off
    """
    function = _function(name)
    identity = new_identity()
    ours, its = os.pipe()
    agent = os.getpid()
    sys.stdout.flush()
    pid = os.fork()
    if not pid:
        code = 1
        try:
            os.close(ours)
            os.setsid()
            for number in (
                signal.SIGINT,
                signal.SIGPIPE,
                signal.SIGHUP,
                signal.SIGTERM,
            ):
                signal.signal(number, signal.SIG_DFL)
            signal.signal(signal.SIGINT, signal.default_int_handler)
            os.environ[LAUNCH_ID_VARIABLE] = f'{identity}.0'
            end_with_parent(signal.SIGINT)
            code = _call(function, content, its)
            if os.getppid() != agent:
                # killed, and nobody else ends what was started
                _end(identity, 0)
        finally:
            os._exit(code)
    os.close(its)
    lines = bytearray()
    try:
        while data := _read(launcher, ours):
            # heartbeats go between two messages
            lines += data
            end = lines.rfind(b'\n') + 1
            launcher_channel.write(bytes(lines[:end]))
            del lines[:end]
    except launcher_channel.LauncherGoneError:
        _end(identity, pid)
        raise
    finally:
        os.close(ours)
    _, status = os.waitpid(pid, 0)
    if status != _REPLIED:
        raise UserError(f'{name} broke off: {_ending(status)}')


def _read(launcher: LauncherChannel, descriptor: int) -> bytes:
    while not launcher.poll({descriptor: select.POLLIN}):
        continue
    return os.read(descriptor, _READ)


def _end(identity: str, pid: int, timeouts: Timeouts = _TIMEOUTS) -> None:
    from colcon_yamllaunch.remote.agent.part_place import end_in_any_case

    end_in_any_case(identity, pid, timeouts)


def _function(name: str) -> Any:
    module_name, _, function_name = name.partition('.')
    if module_name in MODULES and not function_name.startswith('_'):
        module = importlib.import_module(
            f'colcon_yamllaunch.remote.sync.{module_name}'
        )
        function = getattr(module, function_name, None)
        if callable(function):
            return function
    raise UserError(f"there is no request '{name}'")


def _call(function: Any, content: Mapping[str, Any], connection: int) -> int:
    """Call it, and answer by a pipe; return the exit code."""
    null = os.open(os.devnull, os.O_RDONLY)
    os.dup2(null, 0)
    # what it starts is not to write between our messages
    os.dup2(2, 1)
    say = launcher_channel.say_through(connection)
    arguments = dict(content.get('arguments') or {})
    try:
        reply = launcher_channel.reply_of(
            content, lambda: function(arguments, say)
        )
    except KeyboardInterrupt:
        return 1
    launcher_channel.send(reply, connection)
    return _REPLIED


def _ending(status: int) -> str:
    code = os.waitstatus_to_exitcode(status)
    return signal.Signals(-code).name if code < 0 else f'exit code {code}'


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
            _end(identity, process.pid, _PROGRAM_TIMEOUTS)
        code = process.wait()
    except launcher_channel.LauncherGoneError:
        _end(identity, process.pid, _PROGRAM_TIMEOUTS)
        raise
    return {'code': code if code >= 0 else 128 - code}


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
        for message in launcher.new_messages():
            match message:
                case {'stream': {'data': bytes(data)}} if not at_end:
                    waiting += data
                    at_end = not data
                case {'end': _}:
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
                launcher_channel.write(launcher_channel.stream_message(data))
            else:
                for line in data.decode(errors='replace').splitlines():
                    launcher_channel.send({'line': line})
    return True
