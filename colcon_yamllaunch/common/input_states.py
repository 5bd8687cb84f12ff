# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Whether files and folders are still the same, at a look or by their contents.

A look is fast. A build writes many files anew that are the same as before,
which only their contents tell.
"""

from array import array
from collections.abc import Iterable
import os
import stat

from colcon_yamllaunch.common.digest import digest
from colcon_yamllaunch.common.frozen import dataclass

#: How much later than the last change one has to look, so that another change
#: gets another time (ns). Linux counts file times in ticks of up to 10 ms,
#: some file systems in seconds.
TICK = 20_000_000
COARSE_TICK = 2_000_000_000
#: Of files that are larger (bytes), which are programs, a look has to do.
MAXIMUM_CONTENT = 1 << 18

_SECOND = 1_000_000_000
_MASK = (1 << 64) - 1
_ABSENT = (0, 0, 0, 0)


@dataclass(frozen=True, slots=True)
class InputState:
    """
    The state of files and folders.

    :param digest: Is another one when one of them was changed
    :param settled: From when on another change shows in it (ns)
    """

    digest: str
    settled: int


def look(paths: Iterable[str]) -> InputState:
    """Return the state that times and sizes tell."""
    numbers = array('Q')
    settled = 0
    for path in paths:
        try:
            s = os.stat(path)
        except OSError:
            numbers.extend(_ABSENT)
            continue
        numbers.extend(_numbers(s))
        settled = max(settled, _settled(s))
    return InputState(digest(numbers.tobytes()), settled)


def read(paths: Iterable[str]) -> InputState:
    """Return the state that contents and the names in folders tell."""
    parts = []
    settled = 0
    for path in paths:
        try:
            s = os.stat(path)
            if stat.S_ISDIR(s.st_mode):
                names = sorted(map(os.fsencode, os.listdir(path)))
                content = b'\0'.join(names)
            elif stat.S_ISREG(s.st_mode) and s.st_size <= MAXIMUM_CONTENT:
                with open(path, 'rb') as file:
                    content = file.read()
            else:
                content = array('Q', _numbers(s)).tobytes()
                settled = max(settled, _settled(s))
        except OSError:
            parts.append('')
            continue
        parts.append(f'{s.st_mode:o} {digest(content)}')
    return InputState(digest('\n'.join(parts).encode()), settled)


def _numbers(s: os.stat_result) -> tuple[int, int, int, int]:
    times = s.st_mtime_ns & _MASK, s.st_ctime_ns & _MASK
    return (s.st_ino, s.st_size, *times)


def _settled(s: os.stat_result) -> int:
    at = s.st_ctime_ns
    return at + (TICK if at % _SECOND else COARSE_TICK)
