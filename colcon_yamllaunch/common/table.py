# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Tables of texts in columns, with time spans and sizes for people."""

from collections.abc import Callable, Collection, Iterable, Sequence

_GAP = '  '
_UNITS = ('KiB', 'MiB', 'GiB', 'TiB')


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


def duration(seconds: float) -> str:
    """Return a time span with its two largest units, as `2 h 05 min`."""
    whole = int(seconds)
    if whole < 60:
        return f'{whole} s'
    minutes, rest = divmod(whole, 60)
    if minutes < 60:
        return f'{minutes} min {rest:02} s'
    hours, minutes = divmod(minutes, 60)
    if hours < 24:
        return f'{hours} h {minutes:02} min'
    days, hours = divmod(hours, 24)
    return f'{days} d {hours:02} h'


def size(number: int) -> str:
    """Return a number of bytes, as `23.1 MiB`."""
    value = number / 1024
    for unit in _UNITS[:-1]:
        if value < 1000:
            return f'{value:.1f} {unit}'
        value /= 1024
    return f'{value:.1f} {_UNITS[-1]}'


def decimal_size(number: int) -> str:
    """Return a number of bytes as options take it, such as `2 GB`."""
    for factor, unit in ((10**9, 'GB'), (10**6, 'MB'), (10**3, 'kB')):
        if number >= factor:
            return f'{number / factor:.4g} {unit}'
    return f'{number} bytes'
