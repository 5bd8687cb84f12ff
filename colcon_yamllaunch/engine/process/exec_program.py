# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Replacing this process by another program, as execve(2) does."""

from collections.abc import Mapping
from collections.abc import Sequence
import os
import signal
import sys
from typing import NoReturn

from colcon_yamllaunch.engine.process.spawn import explained
from colcon_yamllaunch.engine.process.spawn import find_program
from colcon_yamllaunch.engine.process.spawn import interpreter_of

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
