# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What to do about a process that failed, where its last words tell."""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
import os
from pathlib import Path
import re
import signal
import sys

from colcon_yamllaunch.language.plan.plan import Process
from colcon_yamllaunch.runtime.core.events import Exited
from colcon_yamllaunch.runtime.process.line_buffering import (
    LINE_BUFFERED_VARIABLE,
)
from colcon_yamllaunch.runtime.process.spawn import find_program
from colcon_yamllaunch.runtime.process.spawn import interpreter_of
from colcon_yamllaunch.runtime.process.spawn import StartError
from colcon_yamllaunch.runtime.record.failures import OwnerOf
from colcon_yamllaunch.runtime.record.failures import ParametersOf
from colcon_yamllaunch.runtime.record.parameter_advice import parameter_advice

_MISSING_MODULE = re.compile(
    r"^ModuleNotFoundError: No module named '([\w]+)[\w.]*'"
)
# input() and termios.tcgetattr() of Python without a terminal
_KEYBOARD = re.compile(
    r'^EOFError: EOF when reading a line|^termios\.error: .*ioctl'
)
# AddressSanitizer, where another library was loaded before
_NOT_FIRST = 'runtime does not come first in initial library list'
_CRASHES = frozenset(
    (signal.SIGSEGV, signal.SIGBUS, signal.SIGABRT, signal.SIGFPE)
)


class Advisor:
    """
    Tells the way out of failures.

    :param environment: That of the processes, for its `PATH`
    :param owner_of: See :data:`OwnerOf`
    :param holds_back: Tells whether a process may have held lines back, which
      went with it
    :param parameters_of: See :data:`ParametersOf`
    :param is_elsewhere: Tells whether a process, by its label, runs on
      another machine, whose files are not to be looked at
    """

    def __init__(
        self,
        environment: Mapping[str, str],
        owner_of: OwnerOf,
        holds_back: Callable[[Process], bool] = lambda _process: False,
        parameters_of: ParametersOf = lambda process: process.parameters,
        is_elsewhere: Callable[[str], bool] = lambda _label: False,
    ) -> None:
        self._path = environment.get('PATH', os.defpath)
        self._owner_of = owner_of
        self._holds_back = holds_back
        self._parameters_of = parameters_of
        self._is_elsewhere = is_elsewhere

    def advise(self, event: Exited, tail: Sequence[str]) -> str | None:
        """
        Return the way out in one line, if the failure tells one.

        :param tail: The last lines that the process wrote
        """
        process = event.process
        program = _program_of(process)
        for line in tail:
            # rclcpp dies of it by SIGABRT
            advice = parameter_advice(line, self._parameters_of(process))
            if advice is not None:
                return advice
        if event.outcome.signal in _CRASHES:
            advice = self._debugger(program, process.label)
            if not self._holds_back(process):
                return advice
            lost = 'what it printed last may be lost, which --tty prevents'
            return f'{lost}; {advice}' if advice else lost
        for line in reversed(tail):
            if _NOT_FIRST in line:
                return f'let it start with {LINE_BUFFERED_VARIABLE}=0'
            if _KEYBOARD.match(line):
                return (
                    'it reads the keyboard, which it gets by '
                    f'--attach {process.label}'
                )
            missing = _MISSING_MODULE.match(line)
            if missing is not None:
                owner = self._owner_of(missing[1], process.package)
                if owner is not None:
                    return (
                        f"the package {owner} has the module '{missing[1]}': "
                        f'add <exec_depend>{owner}</exec_depend> to the '
                        f'package.xml of {process.package}'
                    )
                if self._is_elsewhere(process.label):
                    return None
                return self._missing_module(program, missing[1])
        return None

    def _debugger(self, program: str, label: str) -> str | None:
        try:
            path = find_program(program, self._path)
            interpreter = interpreter_of(path, self._path)
        except StartError:
            return None
        prefix = 'gdb -ex run --args'
        if interpreter is not None:
            prefix = f'{prefix} {interpreter}'
        return (
            f"to see where: --attach {label} --launch-prefix '{prefix}' "
            f'--launch-prefix-filter {os.path.basename(program)}'
        )

    def _missing_module(self, program: str, module: str) -> str | None:
        try:
            program = find_program(program, self._path)
            used = interpreter_of(program, self._path) or program
        except StartError:
            return None
        text = f"it ran with {used}, which has no module '{module}'"
        # what is installed may be a link to the file that is edited
        source = os.path.realpath(program)
        for other in self._interpreters():
            if other != used and _has_module(other, module):
                return (
                    f'{text}; {other} has it: let the first line of '
                    f'{source} be #!/usr/bin/env python3'
                )
        return f'{text}: install it there, or source the underlay that has it'

    def _interpreters(self) -> Iterator[str]:
        for folder in self._path.split(':'):
            candidate = os.path.join(folder, 'python3')
            if os.access(candidate, os.X_OK):
                yield candidate
        yield sys.executable


def _program_of(process: Process) -> str:
    """Return the program of a node, which may stand behind a prefix."""
    argv = [argument for argument in process.argv if isinstance(argument, str)]
    for argument in argv:
        folder = os.path.basename(os.path.dirname(argument))
        if folder and folder == process.package:
            return argument
    return argv[0]


def _has_module(interpreter: str, module: str) -> bool:
    # where a virtual environment, or an installed Python, keeps its packages
    library = Path(interpreter).parents[1] / 'lib'
    return any(
        Path(folder, name).exists()
        for folder in library.glob('python3*/*-packages')
        for name in (module, f'{module}.py')
    )
