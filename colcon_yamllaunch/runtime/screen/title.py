# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The title of a terminal's window, in the sequences of xterm."""

# XTWINOPS 22 and 23: the terminal keeps the titles that it had on a stack
_SAVE = b'\x1b[22;0t'
#: Gives a window the title back that it had before.
RESTORE_TITLE = b'\x1b[23;0t'
#: The values of TERM of terminals that have no window of their own.
_WITHOUT_WINDOW = frozenset((None, '', 'dumb', 'linux', 'vt100', 'unknown'))


def has_title(kind: str | None) -> bool:
    """
    Tell whether a terminal understands :func:`title_sequence`.

    :param kind: The value of TERM, or None
    """
    return kind not in _WITHOUT_WINDOW


def title_sequence(title: str) -> bytes:
    """
    Return what keeps the title of a window and sets another.

    :param title: The new one; what cannot be printed is left out
    """
    text = ''.join(c for c in title if c.isprintable())
    return _SAVE + f'\x1b]2;{text}\x07'.encode(errors='replace')
