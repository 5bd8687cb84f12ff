# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Building on the machine, by its colcon, under the lock of the workspace.

This module runs in the process that answers the request. `colcon_build.py`
runs in another one, by the Python of colcon, and decides which packages to
build as a launch there does. It stops when this process ends.

A lock ends with the last process that has it, and each request has its own
process. So a further process inherits the lock at :func:`begin`, and has it
until :func:`end`, or until the agent ends.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import partial
import json
import os
from pathlib import Path
import shlex
import shutil
import signal
import stat
import subprocess
import sys
import time
from typing import Any

import colcon_yamllaunch
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.process_scan import read_process
from colcon_yamllaunch.common.suggestions import on_debian
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.remote.agent.launcher_channel import redirect_to_null
from colcon_yamllaunch.remote.agent.part_sockets import boot_of_machine
from colcon_yamllaunch.remote.sync.inspection import (
    check_system,
    login_shell_line,
)
from colcon_yamllaunch.remote.sync.manifest import Manifest, record_build
from colcon_yamllaunch.workspace.building.build_lock import (
    LOCK_NAME,
    WorkspaceLock,
)
from colcon_yamllaunch.workspace.building.build_processes import BuildProcesses
from colcon_yamllaunch.workspace.packages.workspace_root import Trust

Say = Callable[[str], None]

#: Runs `colcon_build.py`, which needs our modules.
_PROGRAM = """\
import sys
sys.path.insert(0, sys.argv.pop(1))
from colcon_yamllaunch.remote.sync.colcon_build import main
sys.exit(main())
"""
#: How much the clock of a file server may be behind (seconds).
_CLOCKS = 1.0
#: How long a build that is stopped may take (seconds).
_TIMEOUT = 10.0
#: How long a shell may take to say where colcon is (seconds).
_SHELL_TIMEOUT = 10.0
#: The longest line of output; a longer one becomes several (bytes).
_LINE = 64 * 1024
#: Where colcon is when it is not on the path.
_USUAL = ('~/.local/bin/colcon', '/usr/local/bin/colcon', '/usr/bin/colcon')
#: How often the holder checks whether the agent still runs (seconds).
_INTERVAL = 0.1


def begin(arguments: Mapping[str, Any], say: Say) -> dict[str, Any]:
    """
    Acquire the lock of the workspace, and compare it with the launcher's.

    The arguments are `workspace`, its root; `build_base`; `title`, the
    command; `launcher`, its boot id and process id; `origin`, the workspace
    that the code comes from, and `states`, those of its folders by place;
    `build`, the arguments of :func:`build`, to build at once if nothing
    differs; and `needs`, those of :func:`check_system` for code that was built
    elsewhere. Return the `root`; the places that are `changed`; the `holder`
    of the lock, for :func:`end`; and the result of :func:`build` if
    nothing differs.
    """
    if arguments['needs']:
        check_system(**arguments['needs'])
    root = _prepared_root(str(arguments['workspace']), say)
    holder = hold_lock(root, arguments, say)
    try:
        changed = Manifest(root).changed_places(
            arguments['origin'], arguments['states']
        )
        answer = {'root': root, 'changed': changed, 'holder': holder}
        if not changed and arguments['build']:
            answer |= build({**arguments['build'], 'root': root}, say)
    except BaseException:
        end({'holder': holder}, say)
        raise
    return answer


def build(arguments: Mapping[str, Any], say: Say) -> dict[str, Any]:
    """
    Build the stale packages, and pass on the output of colcon.

    The arguments and the result are those of `colcon_build.py`.
    """
    # a clock of a file server may be behind ours
    begin = time.time() - _CLOCKS
    library = Path(colcon_yamllaunch.__file__).parents[1]
    request = json.dumps({**arguments, 'parent': os.getpid()})
    with subprocess.Popen(
        [*colcon_python(), '-c', _PROGRAM, str(library), request],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=str(arguments['root']),
        # it ends by our signal, not by those that we get
        start_new_session=True,
    ) as process:
        assert process.stdout is not None and process.stderr is not None
        try:
            for line in iter(partial(process.stderr.readline, _LINE), b''):
                say(line.decode(errors='replace').rstrip('\r\n'))
            result = process.stdout.read()
        except BaseException:
            process.terminate()
            raise
        finally:
            _wait(process)
    if not result:
        code = process.returncode
        outcome = Outcome(code) if code >= 0 else Outcome(signal=-code)
        raise UserError(f'the build {outcome} without a result')
    answer: dict[str, Any] = json.loads(result)
    # a build that failed may have written, too
    if answer.get('built') or 'error' in answer:
        record_build(str(arguments['root']), begin)
    if 'error' in answer:
        raise UserError(str(answer['error']))
    return answer


def _prepared_root(workspace: str, say: Say) -> str:
    """
    Return the root of the workspace, which is created if necessary.

    :raises UserError: when it cannot be created
    """
    root = Path(os.path.realpath(Path(workspace).expanduser()))
    if root.is_dir():
        Trust(os.environ).check(root)
        return str(root)
    try:
        root.mkdir()
    except FileNotFoundError:
        raise UserError(
            f'there is no folder {root.parent} to make the workspace '
            f'{root.name} in: make it, or name another `workspace:`'
        ) from None
    except OSError as e:
        raise UserError(
            f'cannot make the workspace {root}: {e.strerror}. Make it, or '
            'name another `workspace:`'
        ) from e
    say(f'made the workspace {root}')
    return str(root)


def colcon_python() -> list[str]:
    """
    Return the command of the Python that the colcon there runs with.

    :raises UserError: when there is no colcon
    """
    for program in _colcons():
        with suppress(OSError):
            if os.access(program, os.X_OK) and (w := _interpreter(program)):
                return w
    raise UserError(
        'colcon is not installed there, which is to build the packages: '
        f'install it there ({on_debian("python3-colcon-common-extensions")}; '
        'elsewhere: pip install colcon-common-extensions), or bring what is '
        'built here, by `sync: install`'
    )


def _colcons() -> Iterator[str]:
    """Yield the paths where a colcon may be."""
    # that of a virtual environment that `python:` names
    folder = os.path.dirname(sys.executable)
    if os.path.exists(f'{folder}/../pyvenv.cfg'):
        yield f'{folder}/colcon'
    yield shutil.which('colcon') or ''
    yield from map(os.path.expanduser, _USUAL)
    # as the user has it after a login; there it may be an alias
    line = login_shell_line('command -v colcon', _SHELL_TIMEOUT)
    yield line if line.startswith('/') else ''


def _interpreter(program: str) -> list[str]:
    """Return the words of the Python in the first lines of a program."""
    with open(program, 'rb') as file:
        start = os.fsdecode(file.read(4096))
    lines = start.splitlines()
    words = shlex.split(lines[0][2:]) if start.startswith('#!') else []
    if words and os.path.basename(words[0]) == 'env':
        words = [w for w in words[1:] if w != '-S']
        path = shutil.which(words[0]) if words else None
        words = [path, *words[1:]] if path else []
    elif words and os.path.basename(words[0]) == 'sh' and len(lines) > 1:
        # how pip writes a path that is too long: '''exec' PATH "$0" "$@"
        words = shlex.split(lines[1].replace("'''exec'", '', 1))[:1]
    if words and 'python' in os.path.basename(words[0]):
        return words
    beside = Path(os.path.realpath(program)).with_name('python3')
    return [str(beside)] if beside.exists() else []


def _wait(process: 'subprocess.Popen[bytes]') -> None:
    """Wait for the end of a build; kill it if it takes too long."""
    try:
        # so that it can write its output
        process.communicate(timeout=_TIMEOUT)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    if process.returncode < 0:
        # it has not ended its own processes
        BuildProcesses(builder=process.pid).end()


def hold_lock(root: str, arguments: Mapping[str, Any], say: Say) -> list[int]:
    """
    Acquire the lock, and start a process that inherits it.

    The arguments are the `build_base`; the `title`, the command; and the
    `launcher`, its boot id and process id. If the workspace is that of the
    launcher itself, the launcher holds the lock already. Return the `holder`
    for :func:`end`.

    :raises UserError: when there can be no lock
    """
    base = Path(root, str(arguments['build_base']))
    if _launcher_has_lock(base, arguments['launcher']):
        return []
    agent = os.getppid()
    lock = WorkspaceLock(str(arguments['title']))
    lock.acquire(base, say)
    pid = os.fork()
    if not pid:
        try:
            os.setsid()
            signal.signal(signal.SIGTERM, signal.default_int_handler)
            redirect_to_null(0, 1, 2)
            # the agent waits for the end of all that write to its pipes
            for name in os.listdir('/proc/self/fd'):
                with suppress(OSError):
                    if stat.S_ISFIFO(os.fstat(int(name)).st_mode):
                        os.close(int(name))
            while read_process(agent) is not None:
                time.sleep(_INTERVAL)
        finally:
            lock.release()
            os._exit(0)
    return [pid, _birth(pid)]


def end(arguments: Mapping[str, Any], say: Say) -> dict[str, Any]:  # noqa: ARG001
    """End the process that :func:`hold_lock` has started, the `holder`."""
    if arguments['holder']:
        pid, birth = arguments['holder']
        if _birth(pid) == birth:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGTERM)
    return {}


def _launcher_has_lock(base: Path, launcher: tuple[str, int]) -> bool:
    boot, pid = launcher
    with suppress(OSError, ValueError):
        holder = (base / LOCK_NAME).read_bytes().partition(b'\t')[0]
        return int(holder) == pid and boot_of_machine() == boot
    return False


def _birth(pid: int) -> int:
    process = read_process(pid)
    return -1 if process is None else process.birth
