# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Starting programs, and the descriptors that they get."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
import errno
import os
from pathlib import Path
import resource
import signal
import sys
from typing import Any, NoReturn

#: Starts a program as :func:`os.posix_spawn` does.
Spawn = Callable[..., int]

_SIGNALS = sorted(signal.valid_signals() - {signal.SIGKILL, signal.SIGSTOP})


class StartError(Exception):
    """
    A process cannot be started; the text says why, in one line.

    :param problem: Why
    :param hint: How to fix it, if that is known
    """

    def __init__(self, problem: str, hint: str | None = None) -> None:
        super().__init__('; '.join(filter(None, (problem, hint))))
        self.problem = problem
        self.hint = hint


def spawn_process(
    argv: Sequence[str],
    environment: Mapping[str, str],
    cwd: str,
    descriptors: tuple[int, int, int],
    spawn: Spawn = os.posix_spawn,
) -> int:
    """
    Start a process in a group of its own, and return the id of both.

    It gets no signal mask and no ignored signal of ours, and no descriptor
    but the three. Threads must not run beside, as the working directory
    changes for a moment: Python's posix_spawn() takes none.

    :param argv: The command line; its first item is looked up in the `PATH`
      of `environment`, or is a path, which may be relative to `cwd`
    :param descriptors: What becomes its standard input, output and error
    :raises StartError: when it cannot be started
    """
    with _working_directory(cwd):
        path = environment.get('PATH', os.defpath)
        program = find_program(argv[0], path)
        # it says itself what is wrong
        interpreter_of(program, path)
        actions = [
            (os.POSIX_SPAWN_DUP2, descriptor, number)
            for number, descriptor in enumerate(descriptors)
        ]
        options: dict[str, Any] = {
            'file_actions': actions,
            'setpgroup': 0,
            'setsigmask': (),
            'setsigdef': _SIGNALS,
        }
        with explained(program):
            return spawn(program, argv, environment, **options)


@contextmanager
def explained(program: str) -> Iterator[None]:
    """
    Turn errors inside into one line that says why a program does not start.

    :raises StartError: when the system or Python complains inside
    """
    try:
        yield
    except OSError as error:
        raise _explanation(error, program) from error
    except ValueError as error:
        raise StartError(
            f'{program}: its arguments or its environment cannot be '
            f'passed to a program: {error}'
        ) from error


def find_program(name: str, path: str) -> str:
    """
    Find a program as execvp() of POSIX does, and return its path.

    The path may be relative to the working directory.

    :param name: Its name, or a path when it contains a slash
    :param path: The folders to search, separated by colons
    :raises StartError: when there is no such program
    """
    if not name:
        raise StartError('the name of the program is empty')
    if '/' in name:
        if not os.path.lexists(name):
            raise StartError(f"there is no file '{name}'")
        return name
    denied = None
    for folder in path.split(':'):
        candidate = os.path.join(folder, name)
        if os.path.isfile(candidate):
            if os.access(candidate, os.X_OK):
                return candidate
            denied = denied or candidate
    if denied is not None:
        raise _not_executable(denied)
    raise StartError(
        f"there is no program '{name}' in the folders of PATH",
        'install it, or give its path',
    )


def _explanation(error: OSError, program: str) -> StartError:
    """Return why the system cannot start a program, and the fix."""
    interpreter = _interpreter(program)
    start = _first_bytes(program)
    if error.errno == errno.EACCES:
        if Path(program).is_dir():
            return StartError(f"'{program}' is a folder, not a program")
        if os.access(program, os.X_OK) and interpreter is not None:
            return StartError(
                f"the first line of '{_source(program)}' names the "
                f"interpreter '{interpreter}', which may not be executed"
            )
        return _not_executable(program)
    if error.errno == errno.ENOENT:
        if not Path(program).exists():
            return StartError(
                f"'{program}' is a link to a file that does not exist"
            )
        if interpreter is None:
            return StartError(
                f"'{program}' needs a program loader that does not exist "
                'here; it was made for another system'
            )
        if interpreter.endswith('\r'):
            return _ends_as_on_windows(program)
        return StartError(
            f"the first line of '{_source(program)}' names the "
            f"interpreter '{interpreter}', which does not exist",
            'install it, or correct the line',
        )
    if error.errno == errno.ENOEXEC:
        if start.startswith(b'\x7fELF'):
            return StartError(
                f"'{program}' was made for another kind of machine"
            )
        if not start:
            return StartError(f"'{program}' is empty")
        return StartError(
            f"'{program}' is no program: a script needs a first line that "
            'names its interpreter, such as #!/usr/bin/env python3'
        )
    reason = os.strerror(error.errno) if error.errno else str(error)
    return StartError(f"'{program}': {reason}")


def _source(program: str) -> str:
    """Return the file to edit, which what is installed may link to."""
    return os.path.realpath(program)


def _ends_as_on_windows(program: str) -> StartError:
    """Return what to say of a script with the line ends of Windows."""
    return StartError(
        f"the lines of '{program}' end as on Windows, so its "
        'interpreter is not found',
        # in place of a link, sed would put a copy
        f"convert it: sed -i 's/\\r$//' {_source(program)}",
    )


def interpreter_of(program: str, path: str) -> str | None:
    """
    Return the interpreter of a script, also one that `env` finds.

    None when it is no script, or when only `env` itself can tell. The system
    finds `env`, so it would not report an interpreter that is missing, and
    what `env` says does not name the script.

    :param path: The folders to search, separated by colons
    :raises StartError: when `env` will not find the interpreter
    """
    line = _first_bytes(program).partition(b'\n')[0]
    words = os.fsdecode(line.removeprefix(b'#!')).split()
    if not line.startswith(b'#!') or not words:
        return None
    if Path(words[0]).name != 'env':
        return words[0]
    if line.endswith(b'\r'):
        raise _ends_as_on_windows(program)
    if len(words) != 2 or set('-=') & set(words[1]):
        return None
    try:
        return find_program(words[1], path)
    except StartError:
        raise StartError(
            f"the first line of '{_source(program)}' names the interpreter "
            f"'{words[1]}', which is not in the folders of PATH",
            'install it, or correct the line',
        ) from None


@contextmanager
def _working_directory(path: str) -> Iterator[None]:
    try:
        before = os.open('.', os.O_PATH | os.O_CLOEXEC)
    except OSError as error:
        raise StartError(
            f'there is no way back from its working directory: '
            f'{error.strerror}'
        ) from error
    try:
        try:
            os.chdir(path)
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise StartError(
                f"the working directory '{path}' cannot be entered: {reason}"
            ) from error
        yield
    finally:
        os.fchdir(before)
        os.close(before)


def _not_executable(program: str) -> StartError:
    return StartError(
        f"'{program}' may not be executed",
        f'make it executable: chmod +x {program}',
    )


def _interpreter(program: str) -> str | None:
    start = _first_bytes(program)
    if not start.startswith(b'#!'):
        return None
    line = start[2:].partition(b'\n')[0].strip(b' \t')
    return os.fsdecode(line.replace(b'\t', b' ').partition(b' ')[0])


def _first_bytes(program: str) -> bytes:
    """Return what Linux reads to find an interpreter, or nothing."""
    try:
        if not os.path.isfile(program):
            return b''
        with open(program, 'rb') as file:
            return file.read(256)
    except OSError:
        return b''


#: What Python ignores for itself; a program that it becomes would, too.
_IGNORED_BY_PYTHON = (signal.SIGPIPE, signal.SIGXFSZ)


def exec_program(
    argv: Sequence[str], environment: Mapping[str, str]
) -> NoReturn:
    """
    Replace this process by a program.

    The program has its terminal, descriptors, signals and exit code, as if
    the user had started it.

    :param argv: The command line; its first item is a path, or is looked up
      in the `PATH` of `environment`
    :raises StartError: when the program cannot be started
    """
    path = environment.get('PATH', os.defpath)
    program = find_program(argv[0], path)
    interpreter_of(program, path)
    sys.stdout.flush()
    sys.stderr.flush()
    before = {
        number: signal.signal(number, signal.SIG_DFL)
        for number in _IGNORED_BY_PYTHON
    }
    try:
        with explained(program):
            os.execve(program, list(argv), dict(environment))
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


# two pipes or terminals with both ends while starting, a terminal to type at,
# three log files
_PER_PROCESS = 6
_BESIDES = 128


def close_on_exec_all() -> None:
    """
    Mark all descriptors but the first three as close-on-exec.

    The launcher may have inherited some; no process of the launch does. The
    first three are opened if they are closed, so that no other file gets their
    numbers.
    """
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(descriptor, True)
    os.close(descriptor)
    with os.scandir('/proc/self/fd') as entries:
        descriptors = [int(e.name) for e in entries]
    for descriptor in descriptors:
        if descriptor > 2:
            # one of them listed the folder, and is closed now
            with suppress(OSError):
                os.set_inheritable(descriptor, False)


class DescriptorLimit:
    """
    The soft limit of open files, raised as far as a launch needs.

    :param processes: How many processes the plan has
    """

    def __init__(self, processes: int) -> None:
        self._before = resource.getrlimit(resource.RLIMIT_NOFILE)
        self._processes = 0
        self.expect(processes)

    def expect(self, processes: int) -> None:
        """Raise the limit of descriptors for more processes."""
        self._processes += processes
        soft, hard = self._before
        wanted = _BESIDES + _PER_PROCESS * self._processes
        if hard != resource.RLIM_INFINITY:
            wanted = min(wanted, hard)
        self._raised = soft != resource.RLIM_INFINITY and wanted > soft
        self._during = (wanted, hard)
        if self._raised:
            resource.setrlimit(resource.RLIMIT_NOFILE, self._during)

    def wrapped(self, spawn: Spawn) -> Spawn:
        """Return a spawn whose processes have the limit as it was."""
        if not self._raised:
            return spawn

        def spawn_with_original_limit(*args: Any, **options: Any) -> int:
            # lowering our own limit meanwhile would make glibc reject the
            # descriptors above it
            pid = spawn(*args, **options)
            with suppress(OSError):
                resource.prlimit(pid, resource.RLIMIT_NOFILE, self._before)
            return pid

        return spawn_with_original_limit

    def restore(self) -> None:
        """Restore the limit."""
        if self._raised:
            resource.setrlimit(resource.RLIMIT_NOFILE, self._before)
