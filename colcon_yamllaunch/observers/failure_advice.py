# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Advice about a process that failed, from its last output."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
import os
from pathlib import Path
import re
import signal
import sys

from colcon_yamllaunch.common.files import split_path
from colcon_yamllaunch.common.suggestions import did_you_mean, is_slip
from colcon_yamllaunch.common.table import size
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.events import Exited
from colcon_yamllaunch.engine.line_buffering import LINE_BUFFERED_VARIABLE
from colcon_yamllaunch.engine.spawn import (
    find_program,
    interpreter_of,
    StartError,
)
from colcon_yamllaunch.observers.failures import OwnerOf
from colcon_yamllaunch.plan.plan import ParametersOf, Process, SetParameter
from colcon_yamllaunch.plan.position import Position

_MISSING_MODULE = re.compile(
    r"^ModuleNotFoundError: No module named '([\w]+)[\w.]*'"
)
# input() and termios.tcgetattr() of Python without a terminal
_KEYBOARD = re.compile(
    r'^EOFError: EOF when reading a line|^termios\.error: .*ioctl'
)
# AddressSanitizer, where another library was loaded before
_NOT_FIRST = 'runtime does not come first in initial library list'
_FIRST_MISSING = """\
import sys
from importlib.util import find_spec
sys.path[0], *modules = sys.argv[1:]
print(next((m for m in modules if find_spec(m) is None), ''), end='')
"""
_CRASHES = frozenset(
    (signal.SIGSEGV, signal.SIGBUS, signal.SIGABRT, signal.SIGFPE)
)


class Advisor:
    """
    Explains how to fix failures.

    :param environment: The environment of the processes, for its `PATH`
    :param owner_of: See :data:`OwnerOf`
    :param holds_back: Returns whether a process may have buffered lines,
      which are lost when it crashes
    :param parameters_of: See :data:`ParametersOf`
    :param is_elsewhere: Returns whether the process with a label runs on
      another machine, whose files are not read
    """

    def __init__(
        self,
        environment: Mapping[str, str],
        owner_of: OwnerOf,
        holds_back: Callable[[Process], bool] = lambda _process: False,
        parameters_of: ParametersOf = lambda process: process.parameters,
        is_elsewhere: Callable[[str], bool] = lambda _label: False,
    ) -> None:
        self._environment = environment
        self._path = environment.get('PATH', os.defpath)
        self._owner_of = owner_of
        self._holds_back = holds_back
        self._parameters_of = parameters_of
        self._is_elsewhere = is_elsewhere

    def advise(self, event: Exited, tail: Sequence[str]) -> str | None:
        """
        Return how to fix a failure, in one line, or None if unknown.

        :param tail: The last lines that the process wrote
        """
        process = event.process
        program = _program_of(process)
        limit = limit_advice(event, tail)
        if limit is not None:
            return limit
        for line in tail:
            # before the signal, as rclcpp dies by SIGABRT in this case
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
                cure = self._undeclared(missing[1], process.package)
                if cure is not None or self._is_elsewhere(process.label):
                    return cure
                used = self._interpreter(program)
                return used and (
                    f"it ran with {used}, which has no module '{missing[1]}'; "
                    f'{self._cure(program, used, missing[1])}'
                )
        return None

    def lacks(
        self, program: str, package: str, modules: Sequence[str]
    ) -> tuple[str, str, str] | None:
        """
        Return a module that the interpreter of a script lacks, if any.

        With it, return the interpreter, and how to fix that.

        :param modules: The modules that the script imports
        """
        used = self._interpreter(program)
        if used is None or not os.path.basename(used).startswith('python'):
            return None
        folder = os.path.dirname(os.path.realpath(program))
        there = self._folders(used)
        # ask the interpreter about few modules only, as starting it takes time
        doubtful = [
            module
            for module in modules
            if module not in sys.stdlib_module_names
            and not _has_module((Path(folder), *there), module)
        ]
        missing = doubtful and self._asked(used, folder, doubtful)
        if not missing:
            return None
        cure = self._undeclared(missing, package)
        return missing, used, cure or self._cure(program, used, missing)

    def _undeclared(self, module: str, package: str | None) -> str | None:
        owner = self._owner_of(module, package)
        if owner is None:
            return None
        return (
            f"the package {owner} has the module '{module}': add "
            f'<exec_depend>{owner}</exec_depend> to the package.xml of '
            f'{package}'
        )

    def _asked(
        self, interpreter: str, folder: str, modules: Sequence[str]
    ) -> str:
        """Return the first module that an interpreter does not find."""
        # imported late, as few scripts lack a module
        import subprocess

        try:
            return subprocess.run(
                [interpreter, '-c', _FIRST_MISSING, folder, *modules],
                env=dict(self._environment),
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                timeout=limits.INTERPRETER_TIMEOUT,
                check=False,
            ).stdout
        except (OSError, subprocess.TimeoutExpired):
            return ''

    def _resolved(self, program: str) -> tuple[str, str | None] | None:
        """Return the path and the interpreter of a program, if it is there."""
        try:
            path = find_program(program, self._path)
            return path, interpreter_of(path, self._path)
        except StartError:
            return None

    def _debugger(self, program: str, label: str) -> str | None:
        found = self._resolved(program)
        if found is None:
            return None
        prefix = ' '.join(filter(None, ('gdb -ex run --args', found[1])))
        return (
            f"to see where: --attach {label} --launch-prefix '{prefix}' "
            f'--launch-prefix-filter {os.path.basename(program)}'
        )

    def _interpreter(self, program: str) -> str | None:
        found = self._resolved(program)
        return found and (found[1] or found[0])

    def _cure(self, program: str, used: str, module: str) -> str:
        """Return how to fix that an interpreter lacks a module."""
        paths = (os.path.join(f, 'python3') for f in self._path.split(':'))
        here = [path for path in paths if os.access(path, os.X_OK)]
        for other in (*here, sys.executable):
            if other != used and _has_module(_libraries(other), module):
                # what is installed may be a link to the file that is edited
                source = os.path.realpath(find_program(program, self._path))
                return (
                    f'{other} has it: let the first line of {source} be '
                    '#!/usr/bin/env python3'
                )
        names = {
            file.name.partition('.')[0]
            for folder in self._folders(used)
            if folder.is_dir()
            for file in folder.iterdir()
        } | sys.stdlib_module_names
        if is_slip(module, names):
            return did_you_mean(module, names) or ''
        return 'install it there, or source the setup.bash that has it'

    def _folders(self, interpreter: str) -> list[Path]:
        """Return the folders in which an interpreter finds packages."""
        given = split_path(self._environment.get('PYTHONPATH', ''))
        return [*map(Path, given), *_libraries(interpreter)]


# what Python, the C++ library and the C library report without memory
_NO_MEMORY = re.compile(
    r'\bMemoryError\b|\bstd::bad_alloc\b|Cannot allocate memory'
)


def limit_advice(event: Exited, tail: Sequence[str]) -> str | None:
    """Return which limit of its deployment file a process needs raised."""
    settings, outcome = event.process.settings, event.outcome
    limits = None if settings is None else settings.limits
    if settings is None or limits is None:
        return None
    if limits.memory is not None:
        place = _place(settings.place('memory'))
        if outcome.limit and outcome.signal == signal.SIGKILL:
            return f"raise 'memory' at {place}, or let it need less"
        # without a control group, no more memory is given
        if any(map(_NO_MEMORY.search, tail)):
            limit = size(limits.memory).replace('.0 ', ' ')
            return (
                f"its limit is {limit}: raise 'memory' at {place}, or let it "
                'need less'
            )
    if outcome.limit and limits.tasks is not None:
        return f"raise 'tasks' at {_place(settings.place('tasks'))}"
    return None


def _program_of(process: Process) -> str:
    """Return the program of a node, which may stand behind a prefix."""
    argv = [argument for argument in process.argv if isinstance(argument, str)]
    for argument in argv:
        folder = os.path.basename(os.path.dirname(argument))
        if folder and folder == process.package:
            return argument
    return argv[0]


def _libraries(interpreter: str) -> Iterator[Path]:
    # where a virtual environment, or an installed Python, keeps its packages
    return (Path(interpreter).parent.parent / 'lib').glob(
        'python3*/*-packages'
    )


def _has_module(folders: Iterable[Path], module: str) -> bool:
    return any(
        Path(folder, name).exists()
        for folder in folders
        for name in (module, f'{module}.py')
    )


# InvalidParameterTypeException of rclpy, and that of rclcpp, which has two
# texts (exceptions.hpp and node_parameters.cpp)
_REFUSALS = tuple(
    map(
        re.compile,
        (
            r"Trying to set parameter '(?P<name>[^']+)' to '.*' of type "
            r"'(?P<got>\w+)', expecting type '(?P<wanted>\w+)'",
            r"parameter '(?P<name>[^']+)' has invalid type: "
            r'expected \[(?P<wanted>\w+)\] got \[(?P<got>\w+)\]',
            r'parameter \{(?P<name>[^}]+)\} is of type \{(?P<wanted>\w+)\}, '
            r'setting it to \{(?P<got>\w+)\} is not allowed',
        ),
    )
)
_ARRAY = '_array'
_WHOLE = re.compile(r'[-+]?\d+')
_ROUND = re.compile(r'([-+]?\d+)(?:\.0*)?')
_NUMBER = re.compile(r'[-+]?(\d+\.\d*|\.?\d+)([eE][-+]?\d+)?')
_NAMES = {'bool': 'a bool', 'integer': 'an integer', 'double': 'a double'}


def parameter_advice(
    line: str, parameters: Iterable[SetParameter]
) -> str | None:
    """
    Return how to fix a parameter of the wrong type, None for other lines.

    :param line: A line that the node wrote
    :param parameters: Its parameters; the last one with a name counts
    """
    found = next(filter(None, (r.search(line) for r in _REFUSALS)), None)
    if found is None:
        return None
    name, got, wanted = found['name'], found['got'], found['wanted']
    got, wanted = got.lower(), wanted.lower()
    text = f"the node takes {_with_article(wanted)} for '{name}'"
    same_name = [p for p in parameters if p.name == name]
    # a file may have it for several nodes
    fitting = [p for p in same_name if _type_of(p.value) == got]
    if not same_name:
        return f'{text}, and it was given {_with_article(got)}'
    parameter = (fitting or same_name)[-1]
    passed = ''.join(f', passed by {_place(p)}' for p in parameter.origins)
    return (
        f'{text}: give it {_cure(parameter.value, wanted)} instead of '
        f'{parameter.value}, at {_place(parameter.position)}{passed}'
    )


def _place(position: Position) -> str:
    if os.path.islink(position.path):
        # an installed file is edited in the source
        path = os.path.realpath(position.path)
        position = Position(path, position.line, position.column)
    return events.shown(position)


def _cure(value: str, wanted: str) -> str:
    """Return a value of the wanted type that replaces `value`."""
    element = wanted.removesuffix(_ARRAY)
    is_array = element != wanted
    plain = value.strip('[]') if is_array or value[:1] == '[' else value
    items = [_unquoted(item.strip()) for item in plain.split(',')]
    if not is_array and value[:1] == '[':
        return _with_article(wanted)
    new = [_as_type(item, element) for item in items]
    if None in new:
        return _with_article(wanted)
    joined = ', '.join(map(str, new))
    return f'[{joined}]' if is_array else joined


def _as_type(value: str, wanted: str) -> str | None:
    """Return `value` in the notation of another type, None if impossible."""
    if wanted == 'string':
        return f"'{value}'"
    if wanted == 'double' and _WHOLE.fullmatch(value):
        return f'{value}.0'
    if wanted == 'double' and _NUMBER.fullmatch(value):
        return value
    if wanted == 'integer' and (whole := _ROUND.fullmatch(value)):
        return whole[1]
    if wanted == 'bool' and value.lower() in ('0', 'false', 'off', 'no'):
        return 'false'
    if wanted == 'bool' and value.lower() in ('1', 'true', 'on', 'yes'):
        return 'true'
    return None


def _type_of(value: str) -> str:
    """Return the type of a value of YAML, as ROS 2 calls it."""
    if value[:1] == '[':
        first = value.strip('[]').partition(',')[0]
        return _type_of(first.strip()) + _ARRAY
    if _WHOLE.fullmatch(value):
        return 'integer'
    if _NUMBER.fullmatch(value):
        return 'double'
    return 'bool' if value.lower() in ('true', 'false') else 'string'


def _unquoted(value: str) -> str:
    is_quoted = len(value) > 1 and value[0] == value[-1] and value[0] in '"\''
    return value[1:-1] if is_quoted else value


def _with_article(kind: str) -> str:
    if kind.endswith(_ARRAY):
        return f'a list of {kind.removesuffix(_ARRAY)}s'
    return _NAMES.get(kind, f'a {kind}')
