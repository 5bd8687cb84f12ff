# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The cells of a terminal that a text takes."""

import re

from colcon_yamllaunch.common.printable import COLOUR

_COLOUR = re.compile(COLOUR)
_RESET = '\x1b[0m'


def width(text: str) -> int:
    """Return the cells that a text takes; colours take none."""
    if '\x1b' in text:
        text = _COLOUR.sub('', text)
    return len(text) if text.isascii() else sum(map(_cells, text))


def cut(text: str, cells: int) -> str:
    """
    Cut a text that takes more than so many cells at its end.

    A colour that is on there is ended.
    """
    if width(text) <= cells:
        return text
    kept: list[str] = []
    left = cells - 1
    end = 0
    while end < len(text):
        colour = _COLOUR.match(text, end)
        if colour is not None:
            kept.append(colour[0])
            end = colour.end()
            continue
        left -= width(text[end])
        if left < 0:
            break
        kept.append(text[end])
        end += 1
    reset = _RESET if '\x1b' in text else ''
    return ''.join((*kept, '…' if cells > 0 else '', reset))


def cut_inside(text: str, cells: int, kept: int) -> str:
    """
    Cut a text that takes too many cells before its end.

    :param kept: The cells of its end, of which the colours are lost
    """
    if width(text) <= cells:
        return text
    bare = _COLOUR.sub('', text)
    start = len(bare)
    while start and width(bare[start - 1 :]) <= min(kept, cells - 1):
        start -= 1
    end = bare[start:]
    return cut(text, cells - width(end)) + end


def _cells(character: str) -> int:
    if character < '\u0300':
        return 1
    # few names have more than ASCII
    import unicodedata

    if unicodedata.category(character) in ('Mn', 'Me', 'Cf'):
        return 0
    return 1 + (unicodedata.east_asian_width(character) in 'WF')
