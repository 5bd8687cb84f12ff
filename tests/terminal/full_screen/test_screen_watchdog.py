# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A full screen that is killed leaves the terminal as it was."""

import os
import subprocess
import sys
import termios
from typing import Any

import pytest

#: Has a screen, until it is killed or told to leave.
SCREEN = """\
import os, sys, tty
from colcon_yamllaunch.terminal.full_screen.session import ScreenWatchdog
with ScreenWatchdog(0) as keeper:
    tty.setraw(0)
    for word in sys.argv[1:]:
        keeper.note(is_shown=word == 'on')
    os.write(1, b'up')
    os.read(0, 1)
"""
OTHER_SCREEN_ENDS = b'\x1b[?1049l'


class Screen:
    """A process with a screen in a terminal of its own."""

    def __init__(self, *words: str) -> None:
        self.ours, theirs = os.openpty()
        self.before = self.modes
        self.process = subprocess.Popen(
            [sys.executable, '-c', SCREEN, *words],
            stdin=theirs,
            stdout=theirs,
        )
        os.close(theirs)
        self.seen = b''
        while not self.seen.endswith(b'up'):
            self.seen += os.read(self.ours, 100)
        assert self.modes != self.before

    @property
    def modes(self) -> list[Any]:
        return termios.tcgetattr(self.ours)

    def is_left(self) -> bytes:
        """Wait until nobody has the terminal; return what was written."""
        self.process.wait()
        seen = b''
        try:
            while True:
                seen += os.read(self.ours, 1000)
        except OSError:
            return seen


@pytest.mark.parametrize('words', [('on',), ('on', 'off', 'on')])
def test_a_screen_that_is_killed_is_gone(words: tuple[str, ...]) -> None:
    screen = Screen(*words)
    screen.process.kill()
    assert OTHER_SCREEN_ENDS in screen.is_left()
    assert screen.modes == screen.before
    os.close(screen.ours)


@pytest.mark.parametrize('words', [(), ('on', 'off')])
def test_one_that_is_suspended_touches_nothing(words: tuple[str, ...]) -> None:
    screen = Screen(*words)
    screen.process.kill()
    assert screen.is_left() == b''
    assert screen.modes != screen.before
    os.close(screen.ours)


def test_who_leaves_has_done_it_himself() -> None:
    screen = Screen('on')
    os.write(screen.ours, b'q')
    assert screen.is_left() == b''
    assert screen.process.returncode == 0
    os.close(screen.ours)
