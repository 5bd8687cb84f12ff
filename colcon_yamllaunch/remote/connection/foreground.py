# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Lending our terminal to a command that asks the user something."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextlib import suppress
import os
import signal

_TERMINAL = '/dev/tty'


def has_terminal() -> bool:
    """Tell whether there is a user to be asked: we have a terminal, now."""
    try:
        terminal = os.open(_TERMINAL, os.O_RDWR | os.O_NOCTTY | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        return os.tcgetpgrp(terminal) == os.getpgrp()
    except OSError:
        return False
    finally:
        os.close(terminal)


@contextmanager
def foreground(group: int) -> Iterator[None]:
    """Have a process group have our terminal meanwhile, with its Ctrl-C."""
    try:
        terminal = os.open(_TERMINAL, os.O_RDWR | os.O_NOCTTY | os.O_CLOEXEC)
    except OSError:
        yield
        return
    # who takes a terminal back is in the background
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTTOU})
    try:
        with suppress(OSError):
            os.tcsetpgrp(terminal, group)
            # it may have asked before it had it
            os.killpg(group, signal.SIGCONT)
        yield
    finally:
        with suppress(OSError):
            os.tcsetpgrp(terminal, os.getpgrp())
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        os.close(terminal)
