# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Tables of texts in columns."""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Sequence

_GAP = '  '


def column_widths(rows: Iterable[Sequence[str]]) -> list[int]:
    """Return the characters that each column needs."""
    return [max(map(len, column)) for column in zip(*rows, strict=True)]


def table_width(widths: Sequence[int]) -> int:
    """Return the characters that a row of columns takes."""
    return sum(widths) + len(_GAP) * (len(widths) - 1)


def without_end(text: str, width: int) -> str:
    """Leave out the end of a text that is too long."""
    return text if len(text) <= width else text[: width - 1] + '…'


def without_middle(text: str, width: int) -> str:
    """Leave out the middle of a text that is too long."""
    if len(text) <= width:
        return text
    end = width // 2
    return f'{text[: width - end - 1]}…{text[len(text) - end :]}'


def table_lines(
    rows: Iterable[Sequence[str]],
    widths: Sequence[int],
    shorten: Callable[[str, int], str],
    to_the_right: Collection[int] = (),
) -> list[str]:
    """
    Return rows as lines.

    :param widths: The characters of each column; columns beyond are left out
    :param shorten: Makes a text fit
    :param to_the_right: The columns whose texts are aligned at their end
    """
    lines = []
    for row in rows:
        cells = []
        for number, width in enumerate(widths):
            text = shorten(row[number], width)
            right = number in to_the_right
            cells.append(text.rjust(width) if right else text.ljust(width))
        lines.append(_GAP.join(cells).rstrip())
    return lines
