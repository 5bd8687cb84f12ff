# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Searching lines of output for a regular expression, many at once."""

import re
import warnings

# What may match across a line end, or look over one, needs each line by
# itself; all else finds in a text what it finds in one of its lines. An
# expression that is refused here without need is only slower.
_MAY_SEE_LINE_ENDS = re.compile(
    r'\[\^'  # all characters but some
    r'|\\[^.+*?()\[\]{}|/"\'\-dwSb ]'  # \s, \W, \D, \A, \B, \n, \1, …
    r'|\(\?(?!:|P<|i\))'  # looking around, flags
    r'|[*+?}]\+'  # possessive: does not give a line end back
    r'|[\x00-\x1f\x7f]'  # a line end itself
)


class LinePattern:
    """
    A regular expression that a line is searched for.

    `^` and `$` are the start and the end of the line.

    :param text: The expression, in Python's syntax
    :raises re.error: when it is none
    """

    def __init__(self, text: str) -> None:
        self.text = text
        with warnings.catch_warnings():
            # what a later Python may read in another way is valid today
            warnings.simplefilter('ignore')
            self._line = re.compile(text)
            self._whole = (
                None
                if _MAY_SEE_LINE_ENDS.search(text)
                else re.compile(text, re.MULTILINE)
            )

    def is_in(self, lines: str) -> bool:
        r"""
        Tell whether one of some lines matches.

        :param lines: The lines; `\n` is their only line end
        """
        lines = lines.removesuffix('\n')
        if self._whole is not None:
            return self._whole.search(lines) is not None
        return any(map(self._line.search, lines.split('\n')))
