# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Processes under a debugger, and the core dumps of those that crashed."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
import glob
import os
from pathlib import Path
import re
import socket
import subprocess
import time

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.common.suggestions import on_debian
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.spawn import (
    find_program,
    interpreter_of,
    StartError,
)
from colcon_yamllaunch.plan.plan import ParameterFile, Process

_Words = tuple[str | ParameterFile, ...]
_PYTHON = 'python'
# Debuggers in a terminal, for Python and for other programs; and those that
# wait for a connection, which get the address and the program.
_PDB = ('-m', 'pdb')
_GDB = ('gdb', '-q', '--args')
_DEBUGPY = ('-m', 'debugpy', '--wait-for-client', '--listen')
_GDBSERVER = ('gdbserver', '--once')
_HAS_DEBUGPY = 'import importlib.util as i; exit(not i.find_spec("debugpy"))'
#: Where a debugger waits for a connection: only this machine reaches it.
HOST = '127.0.0.1'
# What gdb answers goes to standard error, and its prompt to standard output;
# in two terminals they come in any order.
_ONE_STREAM = ('sh', '-c', 'exec "$0" "$@" 2>&1')
# options of Python that have a value in a word of its own (python3 --help)
_WITH_VALUE = frozenset(('-W', '-X', '--check-hash-based-pycs'))
# what is run is not a script, or cannot be distinguished from the options
_RUNS_OTHER = re.compile(r'-|-[A-VYZa-z]*[cm].*')
#: How many interpreters of interpreters are looked up.
_DEPTH = 4


def debugged(
    process: Process, environment: Mapping[str, str], port: int | None = None
) -> Process:
    """
    Return a process under a debugger, which waits before the program begins.

    Without a port, it waits for commands in a terminal: `pdb` for a program
    in Python, which each Python has; `gdb` for any other, and then all output
    goes to standard output. With a port, `debugpy` or `gdbserver` waits for
    a connection.

    :param environment: The variables of the process
    :param port: The TCP port at :data:`HOST`
    :raises RefusedError: when the debugger is not installed, or the port
      cannot be used
    """
    path = environment.get('PATH', os.defpath)
    python: _Words = _PDB
    native: _Words = _GDB
    if port is not None:
        _refuse_unusable(port)
        address = f'{HOST}:{port}'
        python, native = (*_DEBUGPY, address), (*_GDBSERVER, address)
    try:
        argv = _under_debugger(process, path, python, native)
    except StartError:
        # the error is reported when it is started
        argv = (*native, *process.argv)
    program = str(argv[0])
    is_native = program == native[0]
    if is_native:
        try:
            find_program(program, path)
        except StartError as error:
            raise RefusedError(
                f'{process.label} needs {program} to be debugged, which is '
                f'not installed; {on_debian(program)}'
            ) from error
    if port is None:
        words = (*_ONE_STREAM, *argv) if is_native else argv
        return replace(process, argv=words, emulate_tty=True)
    if not is_native:
        _need_debugpy(process, program, environment)
    return replace(process, argv=argv)


def _refuse_unusable(port: int) -> None:
    with socket.socket() as listener:
        # debuggers do this, too; without it, a port that was used a moment
        # ago could not be used again
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((HOST, port))
        except (OSError, OverflowError) as error:
            reason = getattr(error, 'strerror', None) or error
            raise RefusedError(
                f'port {port} cannot be used: {reason}'
            ) from error


def _need_debugpy(
    process: Process, python: str, environment: Mapping[str, str]
) -> None:
    # a process that runs must not end for a debugger that cannot start
    found = subprocess.run(
        [python, '-c', _HAS_DEBUGPY],
        env=environment,
        cwd=process.cwd or None,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        check=False,
    )
    if found.returncode:
        raise RefusedError(
            f'{process.label} needs debugpy to be debugged, which is not '
            f'installed: {python} -m pip install debugpy'
        )


def _under_debugger(
    process: Process, path: str, python: _Words, native: _Words
) -> _Words:
    program, *arguments = process.argv
    found = _found(str(program), process.cwd, path)
    if _is_python(found):
        start = _script_index(arguments)
        if start is not None:
            options, rest = arguments[:start], arguments[start:]
            return (program, *options, *python, *rest)
    words: _Words = process.argv
    # gdb takes programs of the machine, and follows a script when it becomes
    # another program
    for _ in range(_DEPTH):
        interpreter = interpreter_of(found, path)
        if interpreter is None:
            break
        if words == process.argv and _is_python(interpreter):
            return (interpreter, *python, found, *arguments)
        words = (interpreter, found, *words[1:])
        found = interpreter
    return (*native, *words)


def _found(name: str, cwd: str, path: str) -> str:
    return find_program(os.path.join(cwd, name) if '/' in name else name, path)


def _script_index(arguments: Sequence[str | ParameterFile]) -> int | None:
    """
    Return which argument of Python pdb takes: a script, or -m and a module.

    None when there is none.
    """
    words = iter(enumerate(map(str, arguments)))
    for index, word in words:
        if word == '-m' or word[:1] != '-':
            return index
        if word in _WITH_VALUE:
            next(words, None)
        elif _RUNS_OTHER.fullmatch(word):
            return None
    return None


def _is_python(program: str) -> bool:
    return os.path.basename(program).startswith(_PYTHON)


#: Where Linux says what it does with core dumps.
KERNEL = Path('/proc/sys/kernel')


def find_core_dump(
    pid: int,
    cwd: str,
    seconds: float,
    kernel: Path = KERNEL,
    now: Callable[[], float] = time.time,
) -> str | None:
    """
    Return where the core dump of a process is that has just ended.

    That is a path, a command that opens it, or the program that got it; None
    if it is not found.

    :param cwd: The working directory that it was started in
    :param seconds: How long it ran
    """
    pattern = _setting(kernel / 'core_pattern') or 'core'
    if pattern.startswith('|'):
        program = pattern[1:].split()[0]
        if program.endswith('systemd-coredump'):
            return f'coredumpctl debug {pid}'
        return f'passed to {program}'
    path = os.path.join(glob.escape(cwd), _as_glob(pattern, pid))
    if '%p' not in pattern and _setting(kernel / 'core_uses_pid') == '1':
        path += f'.{pid}'
    return _newest(path, now() - seconds)


def _as_glob(pattern: str, pid: int) -> str:
    known = {'%%': '%', '%p': str(pid), '%P': str(pid)}
    return re.sub(
        r'%.|[\[*?]',
        lambda m: known.get(m[0], '*' if m[0][0] == '%' else f'[{m[0]}]'),
        pattern,
    )


def _newest(pattern: str, since: float) -> str | None:
    """Return the newest file, unless it is older than the process."""
    times = {}
    for name in glob.glob(pattern):
        try:
            times[name] = Path(name).stat().st_mtime
        except OSError:
            continue
    newest = max(times, key=times.__getitem__, default=None)
    if newest is None or times[newest] < since - limits.FILE_TIME_TOLERANCE:
        return None
    return newest


def _setting(path: Path) -> str:
    try:
        return path.read_text(encoding='utf-8', errors='replace').strip()
    except OSError:
        return ''
