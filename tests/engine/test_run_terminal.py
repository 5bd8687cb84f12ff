# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launches on a terminal, and processes that get one."""

import fcntl
import os
import select
import signal
import struct
import termios
import time

import pytest

#: Seconds after which something will not be shown any more.
DEADLINE = 60.0
REPORT_SIZE = (
    'import os, signal, sys\n'
    'def report(*_):\n'
    '    for n in 1, 2: os.write(1, b"%d: %d %d\\n" % ('
    'n, *os.get_terminal_size(n)))\n'
    'signal.signal(signal.SIGWINCH, report)\n'
    'report()\n'
    'while True: signal.pause()\n'
)


class Terminal:
    """A terminal of 100 columns and 30 lines, and what it got."""

    def __init__(self):
        self.ours, self.theirs = os.openpty()
        self.resize(100, 30)
        self._shown = b''

    def resize(self, columns, lines):
        data = struct.pack('HHHH', lines, columns, 0, 0)
        fcntl.ioctl(self.ours, termios.TIOCSWINSZ, data)

    def shows(self, text):
        deadline = time.monotonic() + DEADLINE
        while text not in self._shown:
            assert time.monotonic() < deadline, self._shown.decode()
            self._read(0.1)
        return self

    def all_of(self, one):
        """Return everything that a launch shows up to its end."""
        while one.popen.poll() is None:
            self._read(0.05)
        while self._read(0):
            continue
        return self._shown

    def _read(self, seconds):
        if not select.select([self.ours], [], [], seconds)[0]:
            return False
        self._shown += os.read(self.ours, 65536)
        return True

    def close(self):
        os.close(self.ours)
        os.close(self.theirs)


@pytest.fixture
def terminal():
    made = Terminal()
    yield made
    made.close()


def test_terminals_of_processes_have_the_size_of_ours(
    launch, python, terminal
):
    one = launch(
        python('a', REPORT_SIZE, emulate_tty=True),
        popen={'stdout': terminal.theirs},
    )
    terminal.shows(b'1: 100 30').shows(b'2: 100 30')
    terminal.resize(77, 22)
    one.sends(signal.SIGWINCH)
    terminal.shows(b'1: 77 22').shows(b'2: 77 22')
    assert one.sends(signal.SIGINT).ends() == 0


def test_who_has_no_terminal_hears_nothing_of_its_size(
    launch, python, terminal
):
    told = (
        'import os, signal\n'
        'signal.signal(signal.SIGWINCH, lambda *_: os.write(1, b"told\\n"))\n'
        'os.write(1, b"up\\n")\n'
        'while True: signal.pause()\n'
    )
    one = launch(
        python('pipe', told),
        python('tty', REPORT_SIZE, emulate_tty=True),
        popen={'stdout': terminal.theirs},
    )
    terminal.shows(b'up').shows(b'2: 100 30')
    terminal.resize(77, 22)
    one.sends(signal.SIGWINCH)
    terminal.shows(b'2: 77 22')
    assert one.sends(signal.SIGINT).ends() == 0
    assert b'told' not in terminal.all_of(one)


def test_every_process_may_get_a_terminal(launch, python):
    script = 'import os; print([os.isatty(n) for n in (0, 1, 2)])'
    one = launch(python('a', script), python('b', script), tty=True)
    assert one.ends() == 0
    assert one.screen.count('[True, True, True]') == 2


def test_what_is_suspended_back_in_a_pipe_shows_at_once_on_a_terminal(
    launch, python
):
    script = 'import time; print("now"); time.sleep(99)'
    unset = {'PYTHONUNBUFFERED': None}
    one = launch(python('a', script, environment=unset), tty=True)
    one.shows('[a]      now').sends(signal.SIGINT).ends()


def rarely(*values):
    return pytest.param(*values, marks=pytest.mark.full)


@pytest.mark.parametrize(
    ('settings', 'environment', 'coloured'),
    [
        ({}, {'TERM': 'xterm'}, True),
        ({}, {'TERM': 'xterm', 'NO_COLOR': '1'}, False),
        rarely({}, {'TERM': 'xterm', 'NO_COLOR': ''}, True),
        rarely({}, {'TERM': 'dumb'}, False),
        rarely({'color': False}, {'TERM': 'xterm'}, False),
        rarely(
            {'color': False},
            {'TERM': 'xterm', 'RCUTILS_COLORIZED_OUTPUT': '1'},
            False,
        ),
    ],
)
def test_colours_on_a_terminal(
    launch, sh, terminal, settings, environment, coloured
):
    one = launch(
        sh('a', r"printf '\033[32mgreen\033[0m\n'; exit 3"),
        {'kind': 'message', 'level': 'ERROR', 'text': 'message'},
        environment=environment,
        popen={'stdout': terminal.theirs},
        **settings,
    )
    shown = terminal.all_of(one)
    assert b'green' in shown
    assert (b'\x1b[32mgreen' in shown) is coloured
    assert (b'\x1b' in shown) is coloured
    assert one.log('a/stdout.log') == b'\x1b[32mgreen\x1b[0m\n'


@pytest.mark.parametrize(
    'asked', [False, pytest.param(True, marks=pytest.mark.full)]
)
def test_colours_in_a_pipe(launch, sh, asked):
    environment = {'RCUTILS_COLORIZED_OUTPUT': '1'} if asked else {}
    one = launch(
        sh('a', r"printf '\033[32mgreen\033[0m\n'"), environment=environment
    )
    assert one.ends() == 0
    assert ('[a]      \x1b[32mgreen' in one.screen) is asked
    assert ('[a]      green\n' in one.screen) is not asked


def test_the_colours_of_nodes_are_refused_with_ours(launch, sh):
    one = launch(
        sh('a', 'echo "<$NO_COLOR|$RCUTILS_COLORIZED_OUTPUT>"'),
        color=False,
        environment={'RCUTILS_COLORIZED_OUTPUT': '1'},
    )
    assert one.ends() == 0
    assert '<1|>' in one.screen


def test_binary_output_does_not_break_a_terminal(
    launch, sh, terminal, tmp_path
):
    data = bytes(range(256)) * 40 + os.urandom(100_000)
    data += b'\x1b[?1049h\x1b[2J\x1b(0\x0e\x1bc\x1b]0;title\x07\x1bP\x9b2J\n'
    (tmp_path / 'data').write_bytes(data)
    one = launch(
        sh('a', f'cat {tmp_path}/data'),
        popen={'stdout': terminal.theirs},
        environment={'TERM': 'xterm', 'NO_COLOR': '1'},
    )
    shown = terminal.all_of(one).decode()
    controls = {c for c in shown if c < ' ' or '\x7f' <= c < '\xa0'}
    assert controls <= {'\r', '\n', '\t'}
    assert one.log('a/stdout.log') == data


def test_a_progress_display_on_a_terminal_keeps_its_lines(
    launch, sh, terminal
):
    one = launch(
        sh('a', r"printf ' 10%%\r 20%%\r 100%%\n'; printf half"),
        popen={'stdout': terminal.theirs},
        environment={'TERM': 'dumb'},
    )
    lines = terminal.all_of(one).split(b'\r\n')
    for text in (b' 10%', b' 20%', b' 100%', b'half'):
        assert b'[a]      ' + text in lines
