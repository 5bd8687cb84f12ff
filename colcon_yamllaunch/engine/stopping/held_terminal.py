# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The terminal of a launch whose launcher was killed."""

from contextlib import suppress
import os
import termios
from typing import Any

from colcon_yamllaunch.common.frozen import dataclass

# the status block is below the cursor; it may have been cut off in the middle
# of a line, where the terminal wraps none (DECAWM), and output in the middle
# of a scroll region (DECSTBM), whose end moves the cursor
_ERASE = b'\x1b7\x1b[r\x1b8\x1b[?7h\x1b[0m\x1b[J'
# to where the output ends, which was saved with each drawing (DECRC)
_BACK = b'\x1b8'


@dataclass(frozen=True, slots=True)
class HeldTerminal:
    """
    A terminal, as the launcher has left it.

    :param descriptor: To write to; writing to it never waits
    :param before: The modes that it had before, as :mod:`termios` has them,
      but for numbers in the place of characters; or None
    :param now: Those that the launcher gave it, or None
    """

    descriptor: int
    before: list[Any] | None
    now: list[Any] | None

    def restore(self, *, goes_back: bool = False) -> None:
        """
        Leave the terminal as it was.

        A shell may be at its prompt already: what it has shown is before the
        cursor, and modes that it has set are left alone.

        :param goes_back: Whether the cursor is in the last line of the status
          block, as somebody types there, and not yet where a shell shows more
        """
        with suppress(OSError, termios.error):
            start = _BACK if goes_back else b''
            os.write(self.descriptor, start + _ERASE)
            modes = termios.tcgetattr(self.descriptor)
            if self.before is not None and as_numbers(modes) == self.now:
                termios.tcsetattr(
                    self.descriptor, termios.TCSANOW, self.before
                )


def as_numbers(modes: list[Any]) -> list[Any]:
    """Return modes of :mod:`termios` with numbers for their characters."""
    *numbers, characters = modes
    codes = [c if isinstance(c, int) else ord(c) for c in characters]
    return [*numbers, codes]
