# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A full screen gives its terminal back, or ends where that is gone."""

from collections.abc import Iterator
import os
from pathlib import Path
import select
import signal
import subprocess
import sys
import termios
import time
from typing import Any

import pytest

#: Shows a launch that is none.
SCREEN = """\
import sys
from colcon_yamllaunch.terminal.full_screen.session import OuterTerminal
from colcon_yamllaunch.terminal.full_screen.session import show
from support.shown_launch import process
from support.shown_launch import ShownLaunch

{defect}
try:
    launch = ShownLaunch(process('kitchen'))
    sys.exit(128 + (show(launch, OuterTerminal(0, {}))[0] or 0))
except ValueError as e:
    sys.exit(f'defect: {e}')
"""
#: Has keys raise what no key does.
DEFECT = """\
from textual.drivers.linux_driver import LinuxDriver

def raise_error(_):
    raise ValueError('of a key')

LinuxDriver.run_input_thread = raise_error
"""
TAKEN = b'\x1b[?1049h'
GIVEN_BACK = b'\x1b[?1049l'
#: Seconds after which it will not end any more.
DEADLINE = 60.0

pytestmark = pytest.mark.full


class Screen:
    """A full screen in a terminal that nobody reads."""

    def __init__(self, defect: str = '') -> None:
        self.ours, self._theirs = os.openpty()
        self.before = self.modes
        self.written = b''
        # all that it starts has this, too
        self._alive, held = os.pipe()
        self.process = subprocess.Popen(
            [sys.executable, '-c', SCREEN.replace('{defect}', defect)],
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

    @property
    def modes(self) -> list[Any]:
        return termios.tcgetattr(self._theirs)

    def writes(self, text: bytes) -> None:
        """Wait until it has written a text, from now on."""
        deadline = time.monotonic() + DEADLINE
        self.written = b''
        while text not in self.written:
            assert time.monotonic() < deadline, self.written
            if select.select([self.ours], [], [], 0.1)[0]:
                self.written += os.read(self.ours, 4096)

    def leaves(self) -> int:
        """Wait until it has given the terminal back; return its code."""
        self.writes(GIVEN_BACK)
        return self.process.wait(DEADLINE)

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


def test_a_key_that_is_no_utf_8_is_none(screen: Screen) -> None:
    screen.writes(b'kitchen')
    os.write(screen.ours, b'\xff?')
    screen.writes(b'kill it with all')
    os.write(screen.ours, b'q')
    screen.writes(b'kitchen')
    os.write(screen.ours, b'q')
    assert screen.leaves() == 128
    assert screen.modes == screen.before


def test_a_screen_that_was_stopped_goes_on(screen: Screen) -> None:
    screen.writes(b'kitchen')
    screen.process.send_signal(signal.SIGSTOP)
    screen.writes(GIVEN_BACK)
    # the modes come after that
    while screen.modes != screen.before:
        time.sleep(0.02)
    screen.process.send_signal(signal.SIGCONT)
    screen.writes(TAKEN)
    screen.writes(b'kitchen')
    assert screen.modes != screen.before
    os.write(screen.ours, b'q')
    assert screen.leaves() == 128
    assert screen.modes == screen.before


def test_one_goes_on_that_was_stopped_for_a_moment_only(
    screen: Screen,
) -> None:
    screen.writes(b'kitchen')
    screen.process.send_signal(signal.SIGSTOP)
    screen.process.send_signal(signal.SIGCONT)
    screen.writes(TAKEN)
    screen.writes(b'kitchen')
    os.write(screen.ours, b'q')
    assert screen.leaves() == 128
    assert screen.modes == screen.before


def test_a_defect_ends_it_in_one_line() -> None:
    screen = Screen(DEFECT)
    screen.writes(b'defect: of a key')
    assert screen.process.wait(DEADLINE) == 1
    assert b'Traceback' not in screen.written
    assert screen.modes == screen.before
    screen.close()


def test_what_cannot_be_written_any_more_does_not_count() -> None:
    # as the screen leaves it when it could still close
    script = """\
import sys
from colcon_yamllaunch.common.messages import flush_or_drop

sys.stdin.read()
for stream in (sys.stdout, sys.stderr):
    try:
        stream.write('more\\n')
        stream.flush()
    except OSError:
        pass
flush_or_drop(sys.stdout)
flush_or_drop(sys.stderr)
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
