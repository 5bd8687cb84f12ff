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
from functools import cache
from functools import partial
import os
from pathlib import Path
import pwd
import shutil
import signal
import time
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.engine.loop import accept_signals
from colcon_yamllaunch.remote.agent.launcher_channel import ANSWERED
from colcon_yamllaunch.remote.agent.launcher_channel import LauncherChannel
from colcon_yamllaunch.remote.agent.launcher_channel import LauncherGoneError
from colcon_yamllaunch.remote.agent.launcher_channel import reply_of
from colcon_yamllaunch.remote.agent.launcher_channel import send

#: Days after which a program that was not used is removed.
UNUSED_DAYS = 30
#: Seconds that the file of `setup:` may take.
_SETUP_TIMEOUT = 50.0
#: Seconds that a shell may take to say what its PATH is.
_SHELL_TIMEOUT = 3.0


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
    Have the launcher seem gone; that is seen where it is waited for.

    An exception would come anywhere, also where what was started is ended.
    """
    null = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1):
        os.dup2(null, descriptor)
    os.close(null)


def _idle(launcher: LauncherChannel) -> None:
    """Do what can be done before it is asked for, as that takes a while."""
    from colcon_yamllaunch.remote.agent import part  # noqa: F401

    _end_what_others_left()
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
        reply = reply_of(content, partial(_result_of, launcher, name, content))
        if reply.get('result') is not ANSWERED:
            send(reply)


def _result_of(
    launcher: LauncherChannel, name: str, content: Mapping[str, Any]
) -> Any:
    if name == 'hello':
        begin = time.time()
        _set_up(launcher, content.get('setup'))
        facts = _hello(content)
        # who asks tells from that how far our clock is ahead
        clock = time.time()
        return {**facts, 'clock': clock, 'took': clock - begin}
    if name == 'stream':
        from colcon_yamllaunch.remote.agent.requests import run_program

        return run_program(launcher, content)
    if name == 'start':
        _end_what_others_left()
    if name in ('start', 'resume'):
        from colcon_yamllaunch.remote.agent import part_link

        act = part_link.start if name == 'start' else part_link.resume
        act(launcher, content)
        raise LauncherGoneError
    from colcon_yamllaunch.remote.agent.requests import answer

    answer(launcher, name, content)
    return ANSWERED


def _hello(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the machine is like."""
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
    """Set what any login would have set; Slurm sets nothing."""
    with suppress(KeyError):
        user = pwd.getpwuid(os.getuid())
        os.environ.setdefault('HOME', user.pw_dir)
        os.environ.setdefault('SHELL', user.pw_shell or '/bin/sh')
        for name in ('USER', 'LOGNAME'):
            os.environ.setdefault(name, user.pw_name)
    if 'PATH' not in os.environ:
        os.environ['PATH'] = os.defpath
        os.environ['PATH'] = _path_of_login()


def _path_of_login() -> str:
    from colcon_yamllaunch.remote.sync.system import login_shell_line

    line = login_shell_line('printenv PATH', _SHELL_TIMEOUT)
    return line if '/' in line else os.defpath


@cache
def _end_what_others_left() -> None:
    """End parts whose engine and guard were killed, in another process."""
    from colcon_yamllaunch.remote.agent.part_place import PartPlace

    try:
        place = PartPlace(os.environ)
        identities = list(place.left_behind())
    except (OSError, UserError):
        # who needs it says so
        return
    if identities and not os.fork():
        with suppress(BaseException):
            _detach()
            from colcon_yamllaunch.remote.agent.part_place import (
                end_what_is_left,
            )

            for identity in identities:
                end_what_is_left(identity)
                place.remove(identity)
        os._exit(0)


def _detach() -> None:
    """Let go of the connection."""
    os.setsid()
    null = os.open(os.devnull, os.O_RDWR)
    for descriptor in (0, 1, 2):
        os.dup2(null, descriptor)
