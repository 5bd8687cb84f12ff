# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Replacing this process by another program, as execve(2) does."""

from collections.abc import Mapping
from collections.abc import Sequence
import os
from pathlib import Path
import signal
import sys
from typing import NoReturn

from colcon_yamllaunch.runtime.process.spawn import ends_as_on_windows
from colcon_yamllaunch.runtime.process.spawn import explained
from colcon_yamllaunch.runtime.process.spawn import find_program
from colcon_yamllaunch.runtime.process.spawn import StartError

#: What Python ignores for itself; a program that it becomes would, too.
_IGNORED_BY_PYTHON = (signal.SIGPIPE, signal.SIGXFSZ)
#: How much of a file its first line is looked for in (bytes; Linux reads no
#: more).
_FIRST_LINE = 256


def exec_program(
    argv: Sequence[str], environment: Mapping[str, str]
) -> NoReturn:
    """
    Replace this process by a program.

    The program has its terminal, descriptors, signals and exit code, as if
    the user had started it.

    :param argv: The command line; its first item is a path, or is looked up
      in the `PATH` of `environment`
    :param environment: The whole environment
    :raises StartError: when the program cannot be started
    """
    path = environment.get('PATH', os.defpath)
    program = find_program(argv[0], path)
    _check_first_line(program, path)
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


def _check_first_line(program: str, path: str) -> None:
    """
    Check that `env` will find the interpreter of a script.

    The system finds `env` itself, so it would not report this, and what `env`
    says does not name the script.
    """
    try:
        with Path(program).open('rb') as file:
            line, _, _ = file.read(_FIRST_LINE).partition(b'\n')
    except OSError:
        return
    words = os.fsdecode(line.removeprefix(b'#!')).split()
    if not line.startswith(b'#!') or Path(*words[:1]).name != 'env':
        return
    if line.endswith(b'\r'):
        raise StartError(ends_as_on_windows(program))
    # with options or variables, only `env` itself can tell
    if len(words) == 2 and not set('-=') & set(words[1]):
        try:
            find_program(words[1], path)
        except StartError:
            raise StartError(
                f"the first line of '{program}' names the interpreter "
                f"'{words[1]}', which is not in the folders of PATH; "
                'install it, or correct the line'
            ) from None
