# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What went wrong in a launch file in Python, as problems of that file."""

import ast
from collections.abc import Iterator
import os
from pathlib import Path
import re

from colcon_yamllaunch.common.text_files import text_of
from colcon_yamllaunch.language.evaluation.findings import DeclaredArgument
from colcon_yamllaunch.language.evaluation.launch_worker import WorkerMessage
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.python_files.worker_dialogue import position_of
from colcon_yamllaunch.language.python_files.worker_dialogue import written_at
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.plan.position import Position

# what takes the name of a package first, by the name that it is called by
_PACKAGE_CALLS = frozenset(
    (
        'FindPackage',
        'FindPackagePrefix',
        'FindPackageShare',
        'get_package_prefix',
        'get_package_share_directory',
        'get_package_share_path',
    )
)
_PACKAGE_KEYWORDS = ('package', 'package_name')
_ARGUMENT = 'DeclareLaunchArgument'


def named_packages(path: str) -> Iterator[tuple[str, Position]]:
    """Iterate over the names of packages that stand in a launch file."""
    for call in _calls(path):
        values = [k.value for k in call.keywords if k.arg in _PACKAGE_KEYWORDS]
        if _name(call) in _PACKAGE_CALLS:
            values += call.args[:1]
        for value in values:
            text = _text(value)
            if text:
                column = value.col_offset + 1
                yield text, Position(path, value.lineno, column)


def written_arguments(path: str) -> Iterator[DeclaredArgument]:
    """Iterate over the launch arguments that a launch file declares."""
    for call in _calls(path):
        keywords = {k.arg: k.value for k in call.keywords}
        first = call.args[0] if call.args else keywords.get('name')
        if _name(call) != _ARGUMENT or first is None:
            continue
        name = _text(first)
        if name is None:
            continue
        default = keywords.get('default_value')
        if len(call.args) > 1:
            default = call.args[1]
        choices = keywords.get('choices')
        yield DeclaredArgument(
            name,
            Position(path, call.lineno, call.col_offset + 1),
            _text(keywords.get('description')),
            # one that is computed shows only when it runs
            '…' if default and _text(default) is None else _text(default),
            tuple(filter(None, map(_text, choices.elts)))
            if isinstance(choices, ast.List | ast.Tuple)
            else (),
        )


def _calls(path: str) -> Iterator[ast.Call]:
    try:
        tree = ast.parse(text_of(Path(path)))
    except (OSError, SyntaxError, ValueError, RecursionError):
        # who runs it says what is wrong
        return
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            yield node


def _name(call: ast.Call) -> str:
    function = call.func
    if isinstance(function, ast.Attribute):
        return function.attr
    return function.id if isinstance(function, ast.Name) else ''


def _text(node: ast.expr | None) -> str | None:
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    return None


#: The variable with the seconds that the host may take.
TIMEOUT_VARIABLE = 'COLCON_LAUNCH_PYTHON_TIMEOUT'
# of an exception that no build helps against
_CERTAIN = ('SyntaxError:', 'IndentationError:', 'TabError:')

# what DeclareLaunchArgument says
_NO_CHOICE = re.compile(
    'RuntimeError: Argument "(?P<name>[^"]+)" provided value "(?P<value>.*)" '
    r'is not valid. Valid options are: \[(.*)\]',
    re.DOTALL,
)
_QUOTED = re.compile(r"'([^']*)'|\"([^\"]*)\"")


class MissingArgumentError(LaunchError):
    """A launch argument that has no default is not given."""

    def included_from(self, position: Position) -> 'LaunchError':
        """Return the same error with one more include in its chain."""
        problem = super().included_from(position)
        return MissingArgumentError(*problem.diagnostics)


def python_error(
    walk: Walk, said: WorkerMessage, start: Position
) -> LaunchError:
    """
    Return the error that the end of an answer tells.

    :param said: Its `error`
    :param start: The start of the launch file
    """
    text, hint = str(said['text']), said.get('hint')
    may_pass = not text.startswith(_CERTAIN) and may_be_built(walk)
    package, argument = said.get('package'), said.get('argument')
    word = argument
    if argument is not None:
        text = f"launch argument '{argument}' is required, and was not given"
        hint = f'give it: {argument}:=…'
        may_pass = False
    elif package is not None and walk.packages.prefix(package) is None:
        text, hint = walk.no_package(package)
        may_pass, word = False, package
    frames = said.get('frames') or ()
    problem = at_frames(
        walk, frames, text, hint, start, may_pass=may_pass, word=word
    )
    if may_pass:
        _use_named_packages(walk)
    if package is not None and may_pass:
        position = problem.diagnostics[0].position
        walk.use_package(package, position or start)
    if argument is not None:
        return MissingArgumentError(*problem.diagnostics)
    return problem


def is_no_choice(walk: Walk, said: WorkerMessage, start: Position) -> bool:
    """
    Report a launch argument that has none of its choices; say whether one has.

    :param said: The `error` of an answer
    :param start: The start of the launch file
    """
    found = _NO_CHOICE.match(str(said['text']))
    value = found and walk.scope.configurations.get(found['name'])
    if not found or value is None or value.text != found['value']:
        return False
    at = at_frames(walk, said.get('frames') or (), '', None, start)
    choices = [first or second for first, second in _QUOTED.findall(found[3])]
    place = at.diagnostics[0].position or start
    walk.fail_choice(found['name'], value, choices, place)
    return True


def at_frames(
    walk: Walk,
    frames: 'list[WorkerMessage] | tuple[()]',
    text: str,
    hint: str | None,
    start: Position,
    *,
    may_pass: bool = False,
    word: str | None = None,
) -> LaunchError:
    """
    Return an error at the innermost of some calls in Python.

    :param start: Where it is when there are none
    :param word: What is wrong in that call, if it is known
    """
    positions = [position_of(frame, start, walk) for frame in frames]
    *calls, position = positions or [start]
    length = 1
    if word is not None and written_at(word, position) != position:
        position, length = written_at(word, position), len(word)
    elif frames and frames[-1].get('end_column'):
        length = max(1, int(frames[-1]['end_column']) - position.column)
    return LaunchError(
        Diagnostic(
            'error',
            text,
            position,
            hint,
            length,
            may_pass_after_build=may_pass,
            calls=tuple(reversed(calls)),
        )
    )


def may_be_built(walk: Walk) -> bool:
    """Say whether something of the workspace may still be built."""
    for name in walk.packages.own_names():
        prefix = walk.packages.prefix(name) or ''
        return walk.packages.may_appear(os.path.join(prefix, 'share', name))
    return False


def _use_named_packages(walk: Walk) -> None:
    """Note what launch files name, so that all of it is built at once."""
    own = set(walk.packages.own_names())
    for path in walk.python_files:
        for name, position in named_packages(path):
            if name in own:
                walk.use_package(name, position)
