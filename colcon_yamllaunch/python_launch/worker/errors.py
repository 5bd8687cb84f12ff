# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What goes wrong in launch files, as their authors see it."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
import contextlib
import difflib
from functools import wraps
import inspect
import linecache
import re
import sys
import traceback
from typing import Any, TYPE_CHECKING

from .channel import Json
from .descriptions import is_a

if TYPE_CHECKING:
    from types import CodeType, TracebackType

    from .positions import Positions


#: How many frames are shown of a recursion without end, the innermost ones.
MAXIMUM_FRAMES = 20
#: The function that each launch file in Python has.
_GENERATE = 'generate_launch_description'
#: Keeps the entity that was visited, or the position of what went wrong.
_ENTITY = '_launch_worker_entity'
#: How `launch` says that an included file is not given an argument.
_MISSING_ARGUMENT = re.compile(
    r"missing required argument '([^']+)'|"
    r'[Rr]equired launch argument "([^"]+)"'
)
#: How Python says that a call has an argument of another name.
_KEYWORD = re.compile(r"unexpected keyword argument '([^']+)'")

_QUOTED = re.compile("'([^']+)'")
#: The arguments of nodes and components that had other names before Foxy.
_RENAMED = {
    'node_executable': 'executable',
    'node_plugin': 'plugin',
    'node_name': 'name',
    'node_namespace': 'namespace',
}


class VisitRefused(BaseException):
    """Only `ros2 launch` can run it, with the reason."""


class Failed(BaseException):
    """The launcher has told the user of errors."""


class PlainError(Exception):
    """
    An error in words of our own, no exception of `launch` or of the user.

    :param message: What is wrong
    :param position: Where, None when that is not known
    :param length: How many characters are meant
    :param hint: The way out, if it is known
    """

    def __init__(
        self,
        message: str,
        position: list[object] | None = None,
        length: int = 1,
        hint: str | None = None,
    ) -> None:
        super().__init__(message)
        self.position = position
        self.length = length
        self.hint = hint


class ArgumentError(Exception):
    """A required launch argument is not given."""

    def __init__(self, name: str) -> None:
        super().__init__(f"the launch argument '{name}' is not given")
        self.argument = name


def note_entity(error: BaseException, entity: object) -> None:
    """Note the entity in whose visit an error came up; the first counts."""
    if not hasattr(error, _ENTITY):
        with contextlib.suppress(AttributeError):
            setattr(error, _ENTITY, entity)


def described(
    error: BaseException, positions: Positions, packages: Any
) -> Json:
    """
    Return what the protocol says of an error.

    :param packages: Tells by `missing(error)` which package is not there
    """
    entity = getattr(error, _ENTITY, None)
    error = _inner(error)
    frames = list(_frames(error, positions))[-MAXIMUM_FRAMES:]
    if not frames:
        noted = entity or getattr(error, _ENTITY, None)
        frames = [frame_of(noted, positions)]
    elif positions.otherwise and positions.otherwise[0] not in positions.files:
        # an action in YAML or XML led there
        frames.insert(0, _frame_of(positions.otherwise, None))
    if isinstance(error, PlainError) and error.position is not None:
        column: Any = error.position[2]
        frames = [_frame_of(error.position, column + error.length)]
    frames = [frame for frame in frames if frame['position'] is not None]
    argument = _argument(error)
    package = None
    if argument is None and not isinstance(error, SyntaxError):
        package = packages.missing(error)
    return {
        'text': _text(error),
        'hint': _renamed(error, frames) or _hint(error),
        'frames': frames,
        'package': package,
        'argument': argument,
    }


def plainly_described(error: BaseException, positions: Positions) -> Json:
    """Return the same of an error that fails itself when it is asked."""
    return {
        'text': type(error).__name__,
        'hint': None,
        'frames': list(_frames(error, positions))[-MAXIMUM_FRAMES:],
        'package': None,
        'argument': None,
    }


def chain(error: BaseException) -> Iterator[BaseException]:
    """Iterate over an error and those that led to it."""
    seen = set()
    current: BaseException | None = error
    while current is not None and id(current) not in seen:
        seen.add(id(current))
        yield current
        current = current.__cause__ or current.__context__


def _inner(error: BaseException) -> BaseException:
    """Return the error that `launch` has wrapped, or else the error."""
    while True:
        # what a substitution says while it is parsed, lark wraps
        original = getattr(error, 'orig_exc', None)
        if isinstance(original, Exception):
            error = original
            continue
        likely = getattr(error, '_likely_errors', None)
        if not isinstance(likely, list) or not likely:
            return error
        # with the ending .py it is read as Python first
        is_python = getattr(error, '_extension', '') == 'py'
        error = likely[0 if is_python else -1]


def _text(error: BaseException) -> str:
    if isinstance(error, SyntaxError):
        return f'{type(error).__name__}: {error.msg}'
    if isinstance(error, PlainError):
        return str(error)
    if isinstance(error, KeyError) and type(error) is not KeyError:
        # those with a text show it as if it were a key
        return f'{type(error).__name__}: {error.args[0]}'
    lines = traceback.format_exception_only(type(error), error)
    text = ''.join(lines).strip()
    name, colon, rest = text.partition(':')
    return f'{name.rpartition(".")[2]}{colon}{rest}'


def _renamed(error: BaseException, frames: list[Json]) -> str | None:
    """Return what the arguments of a node in an old file are called now."""
    named = _QUOTED.findall(str(error))
    if not isinstance(error, TypeError) or not frames:
        return None
    if {*_RENAMED, *_RENAMED.values()}.isdisjoint(named):
        return None
    lines = linecache.getlines(frames[-1]['position'][0])
    used = {
        keyword.arg
        for node in ast.walk(ast.parse(''.join(lines)))
        if isinstance(node, ast.Call)
        for keyword in node.keywords
    }
    old = [name for name in _RENAMED if name in used]
    if not old:
        return None
    new = [_RENAMED[name] for name in old]
    verb = 'is' if len(old) == 1 else 'are'
    return (
        f'{", ".join(map(repr, old))} {verb} now {", ".join(map(repr, new))}'
    )


def _hint(error: BaseException) -> str | None:
    """Return the way out of an error, if it is known."""
    if isinstance(error, PlainError):
        return error.hint
    match = _KEYWORD.search(str(error))
    if match is None or not isinstance(error, TypeError):
        return None
    # each class of `launch` passes on to the one that it derives from what
    # it does not know itself
    made = None
    for frame, _ in traceback.walk_tb(error.__traceback__):
        if frame.f_code.co_name == '__init__':
            made = frame.f_locals.get('self')
    if made is None:
        return None
    names: dict[str, None] = {}
    classes: tuple[Any, ...] = type(made).__mro__
    for cls in classes:
        with contextlib.suppress(TypeError, ValueError):
            parameters = inspect.signature(cls.__init__).parameters.values()
            names |= {
                one.name: None
                for one in parameters
                if one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY)
            }
    return did_you_mean(match[1], names)


def did_you_mean(word: str, names: Iterable[str]) -> str | None:
    """Return the nearest name as a question; as in `common.suggestions`."""
    near = difflib.get_close_matches(word, list(names), 1)
    return f"did you mean '{near[0]}'?" if near else None


def _argument(error: BaseException) -> str | None:
    if isinstance(error, ArgumentError):
        return error.argument
    match = _MISSING_ARGUMENT.search(str(error))
    if match is None or type(error) is not RuntimeError:
        return None
    return match[1] or match[2]


def frames_of_thread(thread: int, positions: Positions) -> list[Json]:
    """Return the user's frames of what a thread is doing, innermost last."""
    found: list[Json] = []
    frame = sys._current_frames().get(thread)
    while frame is not None and len(found) < MAXIMUM_FRAMES:
        code, line = frame.f_code, frame.f_lineno
        if positions.is_users(code.co_filename):
            found.append(_frame_at(code, frame.f_lasti, line, positions))
        frame = frame.f_back
    return found[::-1]


def _frames(error: BaseException, positions: Positions) -> Iterator[Json]:
    current: TracebackType | None = error.__traceback__
    while current is not None:
        code, line = current.tb_frame.f_code, current.tb_lineno
        if positions.is_users(code.co_filename):
            yield _frame_at(code, current.tb_lasti, line, positions)
        current = current.tb_next
    # not that of an expression, which has no file
    if isinstance(error, SyntaxError) and positions.is_users(
        error.filename or ''
    ):
        assert error.filename is not None
        yield _frame(
            error.filename, error.lineno or 1, error.offset or 0, None
        )


def _frame_at(
    code: CodeType, lasti: int, line: int, positions: Positions
) -> Json:
    path = positions.shown(code.co_filename)
    found = positions.in_code(code, lasti)
    if found is None or found.line != line:
        return _frame(path, line, 0, None)
    end = found.end_column if found.end_line == line else None
    return _frame(path, line, found.column, end)


def _frame(path: str, line: int, column: int, end: int | None) -> Json:
    if not column:
        source = linecache.getline(path, line).rstrip()
        column = len(source) - len(source.lstrip()) + 1
        end = len(source) + 1
    return {'position': [path, line, column], 'end_column': end}


def frame_of(made: object, positions: Positions) -> Json:
    """Return a frame for where an object was made; `position` may be None."""
    position = positions.of(made)
    return _frame_of(position, positions.end_column(made))


def _frame_of(position: list[object] | None, end: int | None) -> Json:
    if position is None:
        return {'position': None}
    path, line, column = position
    assert isinstance(path, str)
    assert isinstance(line, int)
    assert isinstance(column, int)
    return _frame(path, line, column, end)


def checked(module: Any, path: str, positions: Positions) -> None:
    """
    Check what a launch file generates when it does.

    `launch` itself would miss some attribute of it, at no place.

    :param module: What was loaded from the file
    :raises PlainError: when the file has no such function
    """
    generate = getattr(module, _GENERATE, None)
    if generate is None:
        names = [n for n, v in vars(module).items() if callable(v)]
        near = difflib.get_close_matches(_GENERATE, names, 1, 0.8)
        text = f"the launch file has no function '{_GENERATE}'"
        if not near:
            raise PlainError(text, [path, 1, 1])
        hint = f"did you mean it by '{near[0]}'?"
        position = positions.of_function(path, near[0])
        length = len(near[0]) if position[1:] != [1, 1] else 1
        raise PlainError(text, position, length, hint)

    @wraps(generate)
    def generate_checked() -> Any:
        description = generate()
        made_by = positions.of_function(path, _GENERATE)
        if not hasattr(description, 'get_launch_arguments'):
            raise PlainError(
                f'{_GENERATE}() returned {_kind(description)}, '
                'no LaunchDescription',
                made_by,
                len(_GENERATE) if made_by[1:] != [1, 1] else 1,
                "end it with 'return LaunchDescription([…])'",
            )
        _check(description, (), made_by, positions)
        return description

    setattr(module, _GENERATE, generate_checked)


def _check(
    entity: Any,
    outer: tuple[Any, ...],
    made_by: list[object],
    positions: Positions,
) -> None:
    """
    Find objects that are not actions in a description and its groups.

    :param outer: What the entity stands in, the nearest first
    :param made_by: The position of what has no position
    :raises PlainError: for the first of them
    """
    for child in entity.describe_sub_entities():
        if not hasattr(child, 'visit'):
            place = positions.place(child, entity, *outer)
            raise no_action(child, place or made_by)
        # the files of those are read in their turn
        if not hasattr(child, 'launch_description_source'):
            _check(child, (entity, *outer), made_by, positions)


def no_action(found: object, position: list[object] | None) -> PlainError:
    """Return the error about something that stands where actions stand."""
    hint = None
    if is_a(found, 'BaseEventHandler'):
        hint = f'put it into RegisterEventHandler({type(found).__name__}(…))'
    elif isinstance(found, (list, tuple)):
        hint = "put its actions into the list itself, such as by '*'"
    return PlainError(
        f'{_kind(found)} stands where an action is expected',
        position,
        hint=hint,
    )


def _kind(found: object) -> str:
    if found is None or isinstance(found, str):
        return repr(found)
    name = type(found).__name__
    return f'{"an" if name[0] in "AEIOUaeiou" else "a"} {name}'
