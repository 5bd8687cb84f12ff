# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Problems in launch files, and how they are shown."""

import codecs
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Literal
import unicodedata

from colcon_yamllaunch.common.files import content_of
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.plan.position import Position, shown_position, Span

Severity = Literal['error', 'warning']

#: The longest piece of a source line that is shown, in characters.
MAXIMUM_LINE_WIDTH = 160
#: How many includes, or calls, of a chain are shown.
MAXIMUM_INCLUDES = 8


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """
    One problem.

    :param severity: Whether the launch can go on
    :param message: What is wrong, in one line
    :param position: Where it is written, or None for the command line
    :param hint: The way out, if there is one to name
    :param length: How many characters the caret underlines
    :param includes: The positions of the includes that led there, innermost
      first
    :param origins: Where the value that is wrong was set, and what it was
      made of, nearest first
    :param calls: The calls that led there in Python, innermost first
    :param may_pass_after_build: Whether building the workspace may fix it, as
      for a program of a package in the workspace
    """

    severity: Severity
    message: str
    position: Position | None = None
    hint: str | None = None
    length: int = 1
    includes: tuple[Position, ...] = ()
    may_pass_after_build: bool = False
    origins: tuple[Position, ...] = ()
    calls: tuple[Position, ...] = ()


class LaunchError(Exception):
    """
    A launch file, or an argument to it, cannot be used.

    :param diagnostics: What is wrong, at least one
    """

    def __init__(self, *diagnostics: Diagnostic) -> None:
        super().__init__(diagnostics[0].message)
        self.diagnostics = diagnostics

    def included_from(self, *positions: Position) -> 'LaunchError':
        """Return the same error with more includes in its chain."""
        diagnostics = (
            replace(d, includes=(*d.includes, *positions))
            for d in self.diagnostics
        )
        return type(self)(*diagnostics)

    def as_warning(self) -> 'LaunchError':
        """Return the same as warnings."""
        warnings = (replace(d, severity='warning') for d in self.diagnostics)
        return LaunchError(*warnings)

    def of(self, what: str) -> 'LaunchError':
        """Return the same with something in front of its messages."""
        return LaunchError(
            *(replace(d, message=what + d.message) for d in self.diagnostics)
        )


def error(
    message: str,
    at: Span | None = None,
    *,
    hint: str | None = None,
    length: int | None = None,
    may_pass_after_build: bool = False,
    origins: tuple[Position, ...] = (),
) -> LaunchError:
    """
    Make an error of one diagnostic; see :class:`Diagnostic`.

    :param at: What is wrong, or None for the command line
    :param length: How many characters of it are, if not all
    """
    if length is None:
        length = 1 if at is None else at.length
    return LaunchError(
        Diagnostic(
            'error',
            message,
            None if at is None else at.position,
            hint,
            length,
            may_pass_after_build=may_pass_after_build,
            origins=origins,
        )
    )


def render(
    diagnostics: Iterable[Diagnostic],
    cwd: str,
    command: str = 'colcon launch',
) -> str:
    """
    Lay the problems out as a compiler does, without a line end at the end.

    :param cwd: The folder that paths are shown relative to
    :param command: What is wrong where no file is
    """
    return '\n'.join(
        line
        for diagnostic in diagnostics
        for line in _render_one(diagnostic, cwd, command)
    )


def _render_one(
    diagnostic: Diagnostic, cwd: str, command: str
) -> Sequence[str]:
    position = diagnostic.position
    text = f'{diagnostic.severity}: {_within(diagnostic.message)}'
    lines = []
    if position is None:
        lines.append(f'{command}: {text}')
    else:
        lines.append(f'{shown_position(position, cwd)}: {text}')
        lines.extend(_excerpt(position, diagnostic.length))
    if diagnostic.hint is not None:
        lines.append(f'  help: {_within(diagnostic.hint)}')
    for number, origin in enumerate(diagnostic.origins):
        verb = 'passed by' if number else 'its value was set at'
        lines.append(f'  {verb} {shown_position(origin, cwd)}')
    lines.extend(_chain('called from', diagnostic.calls, cwd))
    lines.extend(_chain('included from', diagnostic.includes, cwd))
    return lines


def _within(text: str) -> str:
    """Return a text whose further lines are not taken for lines of ours."""
    return text.replace('\n', '\n    ')


def _chain(how: str, positions: Sequence[Position], cwd: str) -> Iterator[str]:
    hidden = len(positions) - MAXIMUM_INCLUDES
    for number, position in enumerate(positions):
        if 0 <= number - MAXIMUM_INCLUDES // 2 < hidden:
            if number == MAXIMUM_INCLUDES // 2:
                yield f'  … {hidden} more'
            continue
        yield f'  {how} {shown_position(position, cwd)}'


def _excerpt(position: Position, length: int) -> Sequence[str]:
    line = _line_of(position)
    if line is None:
        return ()
    start = position.column - 1
    first = max(0, start - MAXIMUM_LINE_WIDTH // 2)
    text = _printable(line[first : first + MAXIMUM_LINE_WIDTH])
    before = _printable(line[first:start])
    length = max(1, min(length, MAXIMUM_LINE_WIDTH // 2))
    marked = _printable(line[start : start + length])
    number = str(position.line)
    return (
        f'  {number} | {text}',
        f'  {" " * len(number)} | {" " * _width(before)}'
        + '^' * max(1, _width(marked)),
    )


def _line_of(position: Position) -> str | None:
    try:
        data = content_of(position.path)
    except (OSError, ValueError):
        return None
    is_utf_16 = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    encoding = 'utf-16' if is_utf_16 else 'utf-8-sig'
    text = data.decode(encoding, errors='replace')
    lines = text.split('\n')
    if position.line > len(lines):
        return None
    return lines[position.line - 1].rstrip('\r')


def _printable(text: str) -> str:
    return ''.join(
        c
        if c.isprintable()
        else ' '
        if c == '\t'
        else '\N{REPLACEMENT CHARACTER}'
        for c in text
    )


def _width(text: str) -> int:
    wide = sum(unicodedata.east_asian_width(c) in 'WF' for c in text)
    combining = sum(unicodedata.combining(c) != 0 for c in text)
    return len(text) + wide - combining
