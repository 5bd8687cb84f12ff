# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Texts of others, made fit to be shown.

What is in a launch file, a manifest or the name of a file may have sequences
that steer a terminal, or characters that change the order in which a line is
read (CVE-2021-42574). Neither gets to the user.
"""

import re

#: A sequence that colours a text (ECMA-48, SGR; with colons ISO 8613-6).
COLOUR = r'\x1b\[[0-9;:]*m'
#: A sequence that steers a terminal, or a character that may be part of one
#: (ECMA-48): CSI, OSC and escape sequences whole, such as the character set
#: of `tput sgr0`, and control characters but `\t` and `\n`. The first group
#: has colours.
SEQUENCE = (
    rf'({COLOUR})'
    r'|\x1b\[[0-?]*[ -/]*[@-~]'
    r'|\x1b\][^\x07\x1b\n]*(?:\x07|\x1b\\)'
    r'|\x1b(?:[ -/]+[0-~]|[0-?])'
    r'|[\x00-\x08\x0b-\x1f\x7f-\x9f]'
)
#: Characters that end lines as `\n` does, or change the reading direction,
#: and bytes that are no UTF-8, as Python has them in names of files.
_MISLEADING = '\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff'
# compiled on use, as most launches show nothing but ASCII
_UNFIT = f'{SEQUENCE}|[{_MISLEADING}]'
_UNFIT_IN_JSON = f'[\x7f-\x9f{_MISLEADING}]'


def printable(text: str) -> str:
    """
    Return lines that do a terminal no harm, and read as they are.

    Control sequences vanish, colours included, and other characters of that
    kind become U+FFFD.
    """
    if text.isascii() and text.replace('\n', ' ').isprintable():
        return text
    return re.sub(_UNFIT, replaced, text)


def one_line(text: str) -> str:
    r"""
    Return a text as :func:`printable` does, and in one line.

    A line end becomes `\n`, two characters, and tabs a blank.
    """
    if text.isascii() and text.isprintable():
        return text
    lines = re.sub(r'\r\n|[\r\n]', r'\\n', text)
    return re.sub(r'\t+', ' ', printable(lines))


def printable_json(text: str) -> str:
    """Return JSON with the same values that does a terminal no harm."""
    # other control characters are escaped in any JSON
    return re.sub(_UNFIT_IN_JSON, lambda m: f'\\u{ord(m[0]):04x}', text)


def replaced(match: re.Match[str]) -> str:
    """Return what takes the place of a sequence or a control character."""
    return '' if len(match[0]) > 1 else '\N{REPLACEMENT CHARACTER}'
