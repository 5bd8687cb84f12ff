# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The table of substitutions.

To add a substitution is to add a function and an entry to :data:`KINDS`.
"""

from collections.abc import Callable
import importlib
import math
import os
from pathlib import Path
import platform
import random
import shlex
import shutil
import subprocess
from typing import Protocol

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.position import Position
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.language.syntax.template import Substitution
from colcon_yamllaunch.language.syntax.template import Template
from colcon_yamllaunch.language.syntax.yaml_reader import construct
from colcon_yamllaunch.language.syntax.yaml_reader import plain_kind
from colcon_yamllaunch.language.vocabulary.package_lookup import Packages
from colcon_yamllaunch.language.vocabulary.scope import Scope

#: How many characters of a command's error output a message shows.
MAXIMUM_STDERR = 2000
#: The ways of `$(command …)` with output on stderr, as ROS 2 names them.
STDERR_MODES = ('fail', 'ignore', 'warn', 'capture')


class Context(Protocol):
    """What a substitution may look at."""

    scope: Scope
    packages: Packages
    cwd: str
    log_folder: str
    #: where the value that was read first in a text came from
    origins: tuple[Position, ...]

    @property
    def source(self) -> Source:
        """The launch file that is being evaluated."""

    def use_package(self, name: str, position: Position) -> None:
        """Note that the launch needs a package."""

    def use_configuration(self, name: str) -> None:
        """Note that a launch configuration is read."""

    def warn(self, message: str, position: Position) -> None:
        """Note a warning."""


class SubstitutionError(Exception):
    """
    A substitution cannot be made.

    :param message: Why
    :param hint: The way out
    :param may_pass_after_build: See :class:`Diagnostic`
    """

    def __init__(
        self,
        message: str,
        hint: str | None = None,
        *,
        may_pass_after_build: bool = False,
    ) -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint
        self.may_pass_after_build = may_pass_after_build


class AlreadyReportedError(Exception):
    """A substitution cannot be made for a reason that was shown before."""


class Call:
    """
    A substitution to be made.

    :param context: What it may look at
    :param substitution: The substitution
    :param position_at: Gives the position for an index in its text
    """

    __slots__ = ('_position_at', '_substitution', 'context')

    def __init__(
        self,
        context: Context,
        substitution: Substitution,
        position_at: Callable[[int], Position],
    ) -> None:
        self.context = context
        self._substitution = substitution
        self._position_at = position_at

    def __len__(self) -> int:
        return len(self._substitution.arguments)

    def __getitem__(self, index: int) -> str:
        return evaluate_template(
            self._substitution.arguments[index],
            self.context,
            self._position_at,
        )

    @property
    def position(self) -> Position:
        """Where it is written."""
        return self._position_at(self._substitution.start)

    def all(self) -> list[str]:
        """Return all arguments."""
        return [self[index] for index in range(len(self))]


@dataclass(frozen=True, slots=True)
class Kind:
    """
    A kind of substitution.

    :param name: Its name
    :param arguments: How its arguments are written; optional ones in brackets
    :param minimum: How many arguments it needs
    :param maximum: How many it takes, or None without limit
    :param make: Makes one
    :param help: What it comes to, in one sentence
    :param example: How it may be used
    :param since: The first ROS 2 release that has it, as in `actions.py`
    """

    name: str
    arguments: str
    minimum: int
    maximum: int | None
    make: Callable[[Call], str]
    help: str
    example: str
    since: str = 'Humble'

    @property
    def usage(self) -> str:
        """How it is written."""
        return f'$({" ".join((self.name, self.arguments)).rstrip()})'

    def arity_problem(self, count: int) -> str | None:
        """Say what is wrong with a number of arguments, if anything."""
        wanted = str(self.minimum)
        if self.maximum is None:
            wanted = f'at least {self.minimum}'
        elif self.maximum != self.minimum:
            wanted = f'{self.minimum} to {self.maximum}'
        if count < self.minimum or (
            self.maximum is not None and count > self.maximum
        ):
            plural = '' if wanted == '1' else 's'
            return (
                f"'{self.name}' takes {wanted} argument{plural}, not {count}"
            )
        return None


def evaluate_template(
    template: Template,
    context: Context,
    position_at: Callable[[int], Position],
) -> str:
    """
    Put the substitutions into a text.

    :raises LaunchError: if one cannot be made
    """
    return ''.join(
        part
        if isinstance(part, str)
        else _make(Call(context, part, position_at), part)
        for part in template.parts
    )


def _make(call: Call, substitution: Substitution) -> str:
    try:
        return KINDS[substitution.name].make(call)
    except SubstitutionError as e:
        raise error(
            e.message,
            call.position,
            hint=e.hint,
            length=substitution.end - substitution.start,
            may_pass_after_build=e.may_pass_after_build,
        ) from e


def parse_boolean(text: str) -> bool | None:
    """Return the YAML 1.1 boolean, `1` or `0` that a text is, else None."""
    text = text.strip()
    if text in ('0', '1'):
        return text == '1'
    if plain_kind(text) == 'bool':
        return construct('bool', text) is True
    return None


def _boolean(text: str) -> bool:
    value = parse_boolean(text)
    if value is None:
        raise SubstitutionError(
            f"'{text}' is neither true nor false",
        )
    return value


def _shown(value: bool) -> str:
    return 'true' if value else 'false'


def _var(call: Call) -> str:
    name = call[0]
    scope = call.context.scope
    call.context.use_configuration(name)
    if name in scope.configurations:
        return scope.configurations[name]
    if name in scope.failed:
        raise AlreadyReportedError
    if len(call) > 1:
        return call[1]
    raise SubstitutionError(
        f"launch configuration '{name}' does not exist",
        did_you_mean(name, scope.configurations)
        or f"declare it with 'arg' or set it with 'let' before this, or "
        f'give a default: $(var {name} default)',
    )


def _env(call: Call) -> str:
    name = call[0]
    environment = call.context.scope.environment
    if name in environment:
        return environment[name]
    if len(call) > 1:
        return call[1]
    raise SubstitutionError(
        f"environment variable '{name}' does not exist",
        did_you_mean(name, environment)
        or f'set it, or give a default: $(env {name} default)',
        may_pass_after_build=True,
    )


def _eval(call: Call) -> str:
    expression = call[0]
    names = ['math']
    if len(call) > 1:
        names = [name.strip() for name in call[1].split(',') if name.strip()]
    variables: dict[str, object] = {}
    try:
        for name in names:
            module = importlib.import_module(name)
            if name == 'math':
                variables.update(vars(math))
            variables[module.__name__] = module
            variables.setdefault(name.partition('.')[0], module)
        return str(eval(expression, variables))
    except (Exception, SystemExit) as e:
        # the expression is the user's own program, and may raise anything
        raise SubstitutionError(
            f"the expression '{expression}' fails: {type(e).__name__}: {e}",
        ) from e


def _command(call: Call) -> str:
    line = call[0]
    mode = call[1] if len(call) > 1 else 'fail'
    if mode not in STDERR_MODES:
        raise SubstitutionError(
            f"'{mode}' is no way to treat output on stderr",
            f'it is one of {", ".join(STDERR_MODES)}',
        )
    try:
        words = shlex.split(line)
    except ValueError as e:
        raise SubstitutionError(
            f"the command '{line}' has an open quote"
        ) from e
    if not words:
        raise SubstitutionError('the command is empty')
    return _run_command(call, line, words, mode)


def _run_command(call: Call, line: str, words: list[str], mode: str) -> str:
    context = call.context
    environment = context.scope.environment
    program = shutil.which(words[0], path=environment.get('PATH'))
    try:
        result = subprocess.run(
            words,
            executable=program or words[0],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT if mode == 'capture' else subprocess.PIPE,
            env=environment,
            cwd=context.cwd,
            check=False,
        )
    except (OSError, ValueError) as e:
        raise SubstitutionError(
            f"the command '{line}' cannot be run: {e}",
            may_pass_after_build=True,
        ) from e
    stderr = (result.stderr or b'').decode(errors='replace').strip()
    stderr = stderr[:MAXIMUM_STDERR]
    if result.returncode != 0:
        raise SubstitutionError(
            f"the command '{line}' failed with exit code "
            f'{result.returncode}' + (f': {stderr}' if stderr else ''),
            may_pass_after_build=True,
        )
    if stderr and mode == 'warn':
        context.warn(f"the command '{line}' said: {stderr}", call.position)
    elif stderr and mode == 'fail':
        raise SubstitutionError(
            f"the command '{line}' wrote to stderr: {stderr}",
            f"add 'ignore', 'warn' or 'capture': $(command '{line}' ignore)",
            may_pass_after_build=True,
        )
    return result.stdout.decode(errors='replace')


def _find_exec(call: Call) -> str:
    name = call[0]
    path = call.context.scope.environment.get('PATH', os.defpath)
    found = shutil.which(name, path=path)
    if found is None:
        raise SubstitutionError(
            f"there is no executable '{name}' on the PATH",
            may_pass_after_build=True,
        )
    return found


def _prefix(call: Call, name: str) -> str:
    context = call.context
    prefix = context.packages.prefix(name)
    if prefix is None:
        raise SubstitutionError(
            f"there is no package '{name}' in the workspace or an underlay",
            did_you_mean(name, context.packages.names()),
        )
    context.use_package(name, call.position)
    return prefix


def _find_pkg_prefix(call: Call) -> str:
    return _prefix(call, call[0])


def _find_pkg_share(call: Call) -> str:
    name = call[0]
    return os.path.join(_prefix(call, name), 'share', name)


def _exec_in_pkg(call: Call) -> str:
    name, package = call[0], call[1]
    _prefix(call, package)
    found = call.context.packages.executable(package, name)
    if found is None:
        raise SubstitutionError(
            call.context.packages.explain_executable(package, name)
        )
    return found


def _anon(call: Call) -> str:
    name = call[0]
    configurations = call.context.scope.configurations
    key = f'anon{name}'
    if key not in configurations:
        unique = f'{name}_{platform.node()}_{os.getpid()}_' + str(
            random.getrandbits(64)
        )
        for character in '.-:':
            unique = unique.replace(character, '_')
        configurations[key] = unique
    return configurations[key]


def _dirname(call: Call) -> str:
    return os.path.dirname(call.context.source.name)


def _filename(call: Call) -> str:
    return call.context.source.name


def _log_dir(call: Call) -> str:
    return call.context.log_folder


def _file_content(call: Call) -> str:
    path = Path(call.context.cwd, call[0])
    try:
        return path.read_text(encoding='utf-8')
    except (OSError, ValueError) as e:
        reason = getattr(e, 'strerror', None) or 'it is not UTF-8 text'
        raise SubstitutionError(
            f"cannot read '{path}': {reason}",
            may_pass_after_build=call.context.packages.may_appear(str(path)),
        ) from e


def _not(call: Call) -> str:
    return _shown(not _boolean(call[0]))


def _and(call: Call) -> str:
    values = [_boolean(text) for text in call.all()]
    return _shown(all(values))


def _or(call: Call) -> str:
    values = [_boolean(text) for text in call.all()]
    return _shown(any(values))


def _equals(call: Call) -> str:
    return _shown(_is_equal(call[0], call[1]))


def _not_equals(call: Call) -> str:
    return _shown(not _is_equal(call[0], call[1]))


def _is_equal(left: str, right: str) -> bool:
    booleans = ('true', '1', 'false', '0')
    if left.lower() in booleans and right.lower() in booleans:
        true = ('true', '1')
        return (left.lower() in true) == (right.lower() in true)
    try:
        return math.isclose(float(left), float(right))
    except ValueError:
        return left == right


def _if(call: Call) -> str:
    if _boolean(call[0]):
        return call[1]
    return call[2] if len(call) > 2 else ''


def _param(call: Call) -> str:
    name = call[0]
    for parameter in call.context.scope.parameters:
        if not isinstance(parameter, str) and parameter.name == name:
            return str(parameter.value)
    if len(call) > 1:
        return call[1]
    raise SubstitutionError(
        f"no 'set_parameter' before this sets the parameter '{name}'",
        f'give a default: $(param {name} default)',
    )


def _for_variable(call: Call) -> str:
    name = call[0]
    variables = call.context.scope.locals
    if name in variables:
        return variables[name]
    if len(call) > 1:
        return call[1]
    raise SubstitutionError(
        f"no 'for_each' or 'for' around this has the variable '{name}'",
        did_you_mean(name, variables),
    )


def _string_join(call: Call) -> str:
    delimiter, *parts = call.all()
    return delimiter.join(parts)


def _path_join(call: Call) -> str:
    return str(Path(*call.all()))


def _string_strip(call: Call) -> str:
    return call[0].strip()


_KINDS = (
    Kind(
        'var',
        'name [default]',
        1,
        2,
        _var,
        'The value of a launch argument or other launch configuration.',
        '$(var rate 10)',
    ),
    Kind(
        'env',
        'NAME [default]',
        1,
        2,
        _env,
        'The value of an environment variable.',
        "$(env ROBOT_NAME '')",
    ),
    Kind(
        'eval',
        "'expression' [modules]",
        1,
        2,
        _eval,
        'What a Python expression comes to, with the names of the `math` '
        'module, or those of other modules, separated by commas (the modules '
        'since Iron).',
        "$(eval '2 * $(var rate 10)')",
    ),
    Kind(
        'command',
        "'command line' [stderr]",
        1,
        2,
        _command,
        'The output of a command, run while the launch file is read; the '
        'command may not fail, and what it writes to stderr is an error '
        '(`fail`), dropped (`ignore`), a warning (`warn`) or part of the '
        'output (`capture`).',
        "$(command 'uname -m' ignore)",
    ),
    Kind(
        'find-exec',
        'name',
        1,
        1,
        _find_exec,
        'The path of a program on the PATH.',
        '$(find-exec sh)',
    ),
    Kind(
        'find-pkg-prefix',
        'package',
        1,
        1,
        _find_pkg_prefix,
        'The folder that a package is installed to.',
        '$(find-pkg-prefix my_pkg)',
    ),
    Kind(
        'find-pkg-share',
        'package',
        1,
        1,
        _find_pkg_share,
        'The share folder of a package.',
        '$(find-pkg-share my_pkg)/config/rates.yaml',
    ),
    Kind(
        'exec-in-pkg',
        'executable package',
        2,
        2,
        _exec_in_pkg,
        'The path of a program of a package.',
        '$(exec-in-pkg my_node my_pkg)',
    ),
    Kind(
        'anon',
        'id',
        1,
        1,
        _anon,
        'A name that no other launch has; the same for the same id in one '
        'scope.',
        '$(anon viewer)',
    ),
    Kind(
        'dirname',
        '',
        0,
        0,
        _dirname,
        'The folder of the launch file that it is written in.',
        '$(dirname)/driver.yaml',
    ),
    Kind(
        'filename',
        '',
        0,
        0,
        _filename,
        'The path of the launch file that it is written in.',
        '$(filename)',
    ),
    Kind(
        'log_dir',
        '',
        0,
        0,
        _log_dir,
        'The folder for the logs of this launch.',
        '$(log_dir)/rosbag',
    ),
    Kind(
        'launch_log_dir',
        '',
        0,
        0,
        _log_dir,
        'The same as `log_dir`.',
        '$(launch_log_dir)/rosbag',
        'Iron',
    ),
    Kind(
        'file-content',
        'path',
        1,
        1,
        _file_content,
        'The text of a file, its last line end included.',
        '$(file-content $(dirname)/arm.urdf)',
        'Iron',
    ),
    Kind(
        'not',
        'condition',
        1,
        1,
        _not,
        '`true` if the condition is false, else `false`.',
        '$(not $(var sim true))',
    ),
    Kind(
        'and',
        'condition condition',
        2,
        2,
        _and,
        '`true` if both are true, else `false`.',
        '$(and $(var sim true) $(var gui true))',
    ),
    Kind(
        'or',
        'condition condition',
        2,
        2,
        _or,
        '`true` if one or both are true, else `false`.',
        '$(or $(var sim true) $(var gui true))',
    ),
    Kind(
        'any',
        'condition …',
        0,
        None,
        _or,
        '`true` if one or more are true, else `false`.',
        '$(any $(var a true) $(var b true) $(var c true))',
        'Iron',
    ),
    Kind(
        'all',
        'condition …',
        0,
        None,
        _and,
        '`true` if all are true, else `false`.',
        '$(all $(var a true) $(var b true) $(var c true))',
        'Iron',
    ),
    Kind(
        'equals',
        'left right',
        2,
        2,
        _equals,
        '`true` if both are equal as booleans, as numbers or as texts, else '
        '`false`.',
        '$(equals $(var mode fast) fast)',
        'Iron',
    ),
    Kind(
        'not-equals',
        'left right',
        2,
        2,
        _not_equals,
        'The opposite of `equals`.',
        '$(not-equals $(var mode fast) slow)',
        'Iron',
    ),
    Kind(
        'if',
        'condition then [else]',
        2,
        3,
        _if,
        'One of two texts; empty if the condition is false and there is no '
        'second.',
        '$(if $(var sim true) gazebo driver)',
        'Iron',
    ),
    Kind(
        'param',
        'name [default]',
        1,
        2,
        _param,
        'The value of a parameter that `set_parameter` has set before (the '
        'default since Iron).',
        '$(param use_sim_time false)',
    ),
    Kind(
        'for-var',
        'name [default]',
        1,
        2,
        _for_variable,
        'The value of a variable of the `for_each` around it.',
        '$(for-var robot r2d2)',
        'Kilted',
    ),
    Kind(
        'index',
        'name',
        1,
        1,
        _for_variable,
        'The index of the `for` around it.',
        '$(index i)',
        'Kilted',
    ),
    Kind(
        'string-join',
        'delimiter text …',
        2,
        None,
        _string_join,
        'The texts, with the delimiter between them.',
        '$(string-join _ left $(var camera front) raw)',
        'Lyrical',
    ),
    Kind(
        'path-join',
        'path …',
        1,
        None,
        _path_join,
        'The paths, one within the other.',
        '$(path-join $(dirname) config rates.yaml)',
        'Lyrical',
    ),
    Kind(
        'string-strip',
        'text',
        1,
        1,
        _string_strip,
        'The text without the white space at its ends.',
        '$(string-strip $(file-content $(dirname)/version))',
        'Rolling',
    ),
)

#: All kinds of substitutions by name.
KINDS = {kind.name: kind for kind in _KINDS}
