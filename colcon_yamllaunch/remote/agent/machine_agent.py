# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What the connection to a machine runs there.

Before the launch it answers requests, one after another. Then it passes on
what goes between the launcher and the engine of the part, which is a process
of its own and outlives a lost connection; it understands none of that. When
its input ends, the launcher is gone, and so is what it has been asked to do.

Messages are lines of JSON, as in the control protocol. A request is
`{"request": NAME, "id": NUMBER, …}`; the answer is `{"reply": NUMBER,
"result": {…}}` or `{"reply": NUMBER, "error": TEXT}`, and before it any number
of `{"line": TEXT}`. `hello`, `stream`, `start` and `resume` are done here;
`MODULE.FUNCTION` is a function of a module of `remote/sync`, which takes the
`arguments` and a function that sends a line. `{"beat": 0}` is a sign of life.
Input and output of the program of `stream` are `{"stream": {"bytes":
NUMBER}}`, followed by so many bytes; none stand for the end.
"""

from collections.abc import Mapping
from contextlib import suppress
from functools import cache, partial
import importlib
import os
from pathlib import Path
import pwd
import select
import shutil
import signal
import sys
import time
from typing import Any, TYPE_CHECKING

from colcon_yamllaunch.common.adoption import end_with_parent
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.escalation import Timeouts
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.engine.launch_scan import (
    LAUNCH_ID_VARIABLE,
    new_identity,
)
from colcon_yamllaunch.engine.loop import accept_signals
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.remote.agent import launcher_channel
from colcon_yamllaunch.remote.agent.launcher_channel import (
    LauncherChannel,
    LauncherGoneError,
)
from colcon_yamllaunch.remote.agent.part_sockets import (
    PartSockets,
    stop_orphans,
    stop_orphans_in_fork,
)

if TYPE_CHECKING:
    from subprocess import Popen

#: Days after which a program that was not used is removed.
UNUSED_DAYS = 30
#: Seconds that the file of `setup:` may take.
_SETUP_TIMEOUT = 50.0
#: Seconds that a shell may take to say what its PATH is.
_SHELL_TIMEOUT = 3.0
#: The modules of `remote/sync` whose functions the launcher may call.
MODULES = ('build', 'inspection', 'manifest')
# for a build, which ends its compilers
_TIMEOUTS = Timeouts(3.0, 3.0)
_REPLIED = 0
_READ = 256 * 1024
#: Bytes that may wait for a program that does not read.
_MAXIMUM_BACKLOG = 4 * 1024 * 1024
#: How a program that is no longer needed is stopped.
_PROGRAM_TIMEOUTS = Timeouts(1.0, 1.0)


def main(temporary: str) -> None:
    """
    Do what the launcher asks for.

    :param temporary: The folder of our modules if it is to be removed at the
      end, or an empty text
    """
    with suppress(OSError):
        os.setsid()
    accept_signals()
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGPIPE):
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _hang_up)
    # so that a launcher that takes nothing shows
    os.set_blocking(1, False)
    _complete_environment()
    launcher = LauncherChannel(temporary)
    try:
        while True:
            _answer(launcher, launcher.next_message(partial(_idle, launcher)))
    except (LauncherGoneError, ProtocolError, OSError):
        # the launcher is gone, or the part has ended
        return
    finally:
        launcher.remove_program()


def _hang_up(_number: int, _frame: object) -> None:
    """
    Close the connection, which the next read from the launcher notices.

    An exception could interrupt the code that stops processes.
    """
    launcher_channel.redirect_to_null(0, 1)


def _idle(launcher: LauncherChannel) -> None:
    """Import modules and clean up while no request waits."""
    from colcon_yamllaunch.remote.agent import part  # noqa: F401

    _stop_other_orphans()
    if not launcher.program:
        remove_unused_programs(Path(__file__).parents[3])


def remove_unused_programs(used: Path) -> None:
    """
    Remove programs beside one that have not been used for long.

    :param used: The folder of the one that is used now
    """
    with suppress(OSError):
        os.utime(used)
        oldest = time.time() - UNUSED_DAYS * 86_400
        for folder in used.parent.iterdir():
            if folder.lstat().st_mtime < oldest:
                shutil.rmtree(folder, ignore_errors=True)


def _answer(launcher: LauncherChannel, content: Mapping[str, Any]) -> None:
    name = content.get('request')
    if isinstance(name, str):
        reply = launcher_channel.reply_of(
            content, partial(_result_of, launcher, name, content)
        )
        # a function has replied by itself
        if reply.get('result', {}) is not None:
            launcher_channel.send(reply)


def _result_of(
    launcher: LauncherChannel, name: str, content: Mapping[str, Any]
) -> Any:
    if name == 'hello':
        begin = time.time()
        _set_up(launcher, content.get('setup'))
        facts = _hello(content)
        # the launcher computes from that how far our clock is ahead
        clock = time.time()
        return {**facts, 'clock': clock, 'took': clock - begin}
    if name == 'stream':
        return run_program(launcher, content)
    if name in ('start', 'resume'):
        from colcon_yamllaunch.remote.agent import part_link

        if name == 'start':
            _stop_other_orphans()
        part_link.relay(launcher, content)
        raise LauncherGoneError
    call_function(launcher, name, content)
    return None


def _hello(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the properties of the machine; see `MachineFacts`."""
    wanted = [os.path.expanduser(w) for w in content['workspaces']]
    found = next(filter(os.path.isdir, wanted), None)
    workspace = found or (wanted[-1] if wanted else None)
    return {
        # Slurm has names of its own
        'host': os.environ.get('SLURMD_NODENAME') or os.uname().nodename,
        'home': os.path.expanduser('~'),
        'workspace': workspace,
        'has_workspace': found is not None,
    }


def _set_up(launcher: LauncherChannel, setup: str | None) -> None:
    """
    Source a file for all that is done from now on.

    :raises UserError: when it cannot be sourced
    """
    if setup is None:
        return
    from concurrent.futures import ThreadPoolExecutor

    from colcon_yamllaunch.workspace.environment.sourcing import source

    path = Path.home() / os.path.expanduser(setup)
    if not path.is_file():
        raise UserError(f"there is no file {path}; 'setup:' names it")
    with ThreadPoolExecutor() as pool:
        sourced = pool.submit(source, path, dict(os.environ), _SETUP_TIMEOUT)
        while not sourced.done():
            launcher.poll({}, 0.02)
    variables = sourced.result().variables
    os.environ.clear()
    os.environ.update(variables)


def _complete_environment() -> None:
    """Set the variables of a login, as Slurm sets none."""
    with suppress(KeyError):
        user = pwd.getpwuid(os.getuid())
        os.environ.setdefault('HOME', user.pw_dir)
        os.environ.setdefault('SHELL', user.pw_shell or '/bin/sh')
        for name in ('USER', 'LOGNAME'):
            os.environ.setdefault(name, user.pw_name)
    if 'PATH' not in os.environ:
        from colcon_yamllaunch.remote.sync.inspection import login_shell_line

        os.environ['PATH'] = os.defpath
        line = login_shell_line('printenv PATH', _SHELL_TIMEOUT)
        os.environ['PATH'] = line if '/' in line else os.defpath


@cache
def _stop_other_orphans() -> None:
    """End parts whose engine and guard were killed, in another process."""
    try:
        sockets = PartSockets(os.environ)
        identities = list(sockets.orphaned())
    except (OSError, UserError):
        # starting a part reports it
        return
    if identities and not os.fork():
        with suppress(BaseException):
            os.setsid()
            launcher_channel.redirect_to_null(0, 1, 2)
            for identity in identities:
                stop_orphans(identity)
                sockets.remove(identity)
        os._exit(0)


def call_function(
    launcher: LauncherChannel, name: str, content: Mapping[str, Any]
) -> None:
    """
    Call a function in a process of its own, which answers by itself.

    So it can be ended, with all that it started, when the launcher is gone.

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
            for number in (signal.SIGPIPE, signal.SIGHUP, signal.SIGTERM):
                signal.signal(number, signal.SIG_DFL)
            signal.signal(signal.SIGINT, signal.default_int_handler)
            os.environ[LAUNCH_ID_VARIABLE] = f'{identity}.0'
            end_with_parent(signal.SIGINT)
            code = _call(function, content, its)
            if os.getppid() != agent:
                # killed, and nobody else ends what was started
                stop_orphans_in_fork(identity, 0, _TIMEOUTS)
        finally:
            os._exit(code)
    os.close(its)
    lines = bytearray()
    try:
        while data := launcher.read(ours):
            # heartbeats go between two messages
            lines += data
            end = lines.rfind(b'\n') + 1
            launcher_channel.write(bytes(lines[:end]))
            del lines[:end]
    except LauncherGoneError:
        stop_orphans_in_fork(identity, pid, _TIMEOUTS)
        raise
    finally:
        os.close(ours)
    _, status = os.waitpid(pid, 0)
    if status != _REPLIED:
        raise UserError(f'{name} broke off: {Outcome.from_status(status)}')


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
    """Call `function`, send the reply and return the exit code."""
    launcher_channel.redirect_to_null(0)
    # what it starts is not to write between our messages
    os.dup2(2, 1)

    def say(line: str) -> None:
        launcher_channel.send({'line': line}, connection)

    arguments = dict(content.get('arguments') or {})
    try:
        reply = launcher_channel.reply_of(
            content, lambda: function(arguments, say)
        )
    except KeyboardInterrupt:
        return 1
    launcher_channel.send(reply, connection)
    return _REPLIED


def run_program(
    launcher: LauncherChannel, content: Mapping[str, Any]
) -> dict[str, Any]:
    """
    Run a program, and relay its standard streams to the launcher.

    :raises LauncherGoneError: when the launcher is gone, and it is ended
    :raises UserError: when it cannot be started
    """
    import subprocess

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
        _pass_on(launcher, process)
        code = process.wait()
    except LauncherGoneError:
        stop_orphans_in_fork(identity, process.pid, _PROGRAM_TIMEOUTS)
        raise
    return {'code': code if code >= 0 else 128 - code}


def _pass_on(launcher: LauncherChannel, process: 'Popen[bytes]') -> None:
    """Relay the streams of a process until they end."""
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
        listens = len(waiting) < _MAXIMUM_BACKLOG
        ready = launcher.poll(masks, listens=listens)
        for message in launcher.new_messages():
            if 'stream' in message and not at_end:
                data = message['stream']['data']
                waiting += data
                at_end = not data
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
