# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What goes wrong in launch files, as their authors see it."""

from __future__ import annotations

from collections.abc import Iterator
import contextlib
import linecache
import re
import sys
import traceback
from typing import Any
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from types import CodeType
    from types import TracebackType

    from host_positions import Positions

    # as code, this needs 3.9
    Json = dict[str, Any]

#: How many frames are shown of a recursion without end, the innermost ones.
MAXIMUM_FRAMES = 20
#: Keeps the entity that was visited, or the position of what went wrong.
_ENTITY = '_launch_host_entity'
#: How `launch` says that an included file is not given an argument.
_MISSING_ARGUMENT = re.compile(
    r"missing required argument '([^']+)'|"
    r'[Rr]equired launch argument "([^"]+)"'
)


class Refused(BaseException):
    """Only `ros2 launch` can run it, with the reason."""


class Failed(BaseException):
    """The launcher has told the user of errors."""


class ToldError(Exception):
    """
    An error in a launch file that is not in Python.

    :param message: What is wrong
    :param position: Where, None when that is not known
    :param length: How many characters are meant
    """

    def __init__(
        self,
        message: str,
        position: list[object] | None = None,
        length: int = 1,
    ) -> None:
        super().__init__(message)
        self.position = position
        self.length = length


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
        # what stands in YAML or XML has it done
        frames.insert(0, _frame_of(positions.otherwise, None))
    if isinstance(error, ToldError) and error.position is not None:
        column: Any = error.position[2]
        frames = [_frame_of(error.position, column + error.length)]
    frames = [frame for frame in frames if frame['position'] is not None]
    argument = _argument(error)
    package = None
    if argument is None and not isinstance(error, SyntaxError):
        package = packages.missing(error)
    return {
        'text': _text(error),
        'hint': None,
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
    if isinstance(error, ToldError):
        return str(error)
    if isinstance(error, KeyError) and type(error) is not KeyError:
        # those with a text show it as if it were a key
        return f'{type(error).__name__}: {error.args[0]}'
    lines = traceback.format_exception_only(type(error), error)
    text = ''.join(lines).strip()
    name, colon, rest = text.partition(':')
    return f'{name.rpartition(".")[2]}{colon}{rest}'


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
