# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A full screen ends whose terminal is gone, or takes nothing."""

from collections.abc import Iterator
import os
from pathlib import Path
import signal
import subprocess
import sys
import termios
import time

import pytest

#: Shows a launch that is none.
SCREEN = """\
import sys
from colcon_yamllaunch.verb.sessions.full_screen import OuterTerminal
from colcon_yamllaunch.verb.sessions.full_screen import show
from support.shown_launch import process
from support.shown_launch import ShownLaunch

class Launch:
    def subscribe(self, _):
        return ShownLaunch(process('kitchen'))

sys.exit(128 + (show(Launch(), OuterTerminal(0, {})) or 0))
"""
#: Seconds after which it will not end any more.
DEADLINE = 60.0

pytestmark = pytest.mark.full


class Screen:
    """A full screen in a terminal that nobody reads."""

    def __init__(self) -> None:
        self.ours, self._theirs = os.openpty()
        # all that it starts has this, too
        self._alive, held = os.pipe()
        self.process = subprocess.Popen(
            [sys.executable, '-c', SCREEN],
            stdin=self._theirs,
            stdout=self._theirs,
            stderr=self._theirs,
            env={
                **os.environ,
                'TERM': 'xterm',
                'PYTHONPATH': str(Path(__file__).parents[2]),
            },
            # nor does the system send it a SIGHUP
            start_new_session=True,
            pass_fds=[held],
        )
        os.close(held)

    def is_shown(self) -> 'Screen':
        """Wait until it has the terminal."""
        deadline = time.monotonic() + DEADLINE
        while termios.tcgetattr(self._theirs)[3] & termios.ISIG:
            assert time.monotonic() < deadline
            assert self.process.poll() is None
            time.sleep(0.02)
        return self

    def fill(self) -> None:
        """Have the terminal take nothing more."""
        path = os.ttyname(self._theirs)
        flags = os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY
        descriptor = os.open(path, flags)
        try:
            while True:
                os.write(descriptor, b'x' * 1000)
        except BlockingIOError:
            os.close(descriptor)

    def hang_up(self) -> None:
        """Close the terminal."""
        if self.ours != -1:
            os.close(self.ours)
            self.ours = -1

    def leaves_nothing(self) -> bool:
        """Wait until nothing runs that it has started."""
        return os.read(self._alive, 1) == b''

    def close(self) -> None:
        """Leave nothing behind."""
        self.process.kill()
        self.process.wait()
        self.hang_up()
        os.close(self._theirs)
        os.close(self._alive)


@pytest.fixture
def screen() -> Iterator[Screen]:
    one = Screen()
    yield one
    one.close()


def test_one_ends_whose_terminal_is_closed(screen: Screen) -> None:
    screen.is_shown().hang_up()
    assert screen.process.wait(DEADLINE) == 128 + signal.SIGHUP
    assert screen.leaves_nothing()


def test_one_ends_whose_terminal_takes_nothing(screen: Screen) -> None:
    screen.fill()
    screen.is_shown().process.terminate()
    assert screen.process.wait(DEADLINE) == 128 + signal.SIGTERM
    screen.hang_up()
    assert screen.leaves_nothing()


def test_what_cannot_be_written_any_more_does_not_count() -> None:
    # as the screen leaves it when it could still close
    script = """\
import sys
from colcon_yamllaunch.verb.sessions import full_screen

sys.stdin.read()
for stream in (sys.stdout, sys.stderr):
    try:
        stream.write('more\\n')
        stream.flush()
    except OSError:
        pass
full_screen._drop_unwritten()
sys.exit(129)
"""
    ours, theirs = os.openpty()
    with subprocess.Popen(
        [sys.executable, '-c', script],
        stdin=subprocess.PIPE,
        stdout=theirs,
        stderr=theirs,
        env={n: v for n, v in os.environ.items() if n != 'PYTHONUNBUFFERED'},
        start_new_session=True,
    ) as process:
        os.close(theirs)
        os.close(ours)
    assert process.returncode == 129
