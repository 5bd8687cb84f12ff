# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launch shows: on a terminal, in a pipe, quietly, at length."""

from collections.abc import Callable, Iterator
import fcntl
import os
from pathlib import Path
import pty
import re
import select
import signal
import struct
import subprocess
import termios
import time

import pytest
from support.user import built, DEADLINE, User

TITLE = '\x1b[22;0t\x1b]2;a.yaml - colcon launch\x07'
RESTORED = '\x1b[23;0t'


class Terminal:
    """A `colcon launch` on a terminal, and what it wrote there."""

    def __init__(self, user: User, *words: str, **variables: str) -> None:
        columns = int(variables.pop('COLUMNS', '80'))
        self._reader, child_end = pty.openpty()
        size = struct.pack('HHHH', 24, columns, 0, 0)
        fcntl.ioctl(child_end, termios.TIOCSWINSZ, size)
        environment = user.environment | {'TERM': 'xterm'} | variables
        environment.pop('COLUMNS', None)
        environment.pop('LINES', None)
        if 'NO_COLOR' not in variables:
            environment.pop('NO_COLOR', None)
        self._popen = subprocess.Popen(
            ['colcon', 'launch', *words],
            cwd=user.root,
            env=environment,
            stdin=child_end,
            stdout=child_end,
            stderr=child_end,
            start_new_session=True,
        )
        os.close(child_end)

    def end(self) -> str:
        """Wait for the end with success, and return what was shown."""
        data = b''
        deadline = time.monotonic() + DEADLINE
        while select.select([self._reader], [], [], DEADLINE)[0]:
            assert time.monotonic() < deadline
            try:
                chunk = os.read(self._reader, 65536)
            except OSError:
                # Linux's word for the end of what a terminal's user says
                break
            data += chunk
        text = data.decode()
        assert self._popen.wait(DEADLINE) == 0, text
        return text

    def close(self) -> None:
        os.close(self._reader)
        if self._popen.poll() is None:
            os.killpg(self._popen.pid, signal.SIGKILL)
            self._popen.wait()


Show = Callable[..., str]


@pytest.fixture
def show(user: User) -> Iterator[Show]:
    """Return a function that runs a launch on a terminal."""
    terminals: list[Terminal] = []

    def run(*words: str, **variables: str) -> str:
        terminals.append(Terminal(user, *words, **variables))
        return terminals[-1].end()

    yield run
    for terminal in terminals:
        terminal.close()


def write_launch(user: User, sleepers: int = 1) -> None:
    """Write a launch file whose last process says hello."""
    commands = ['sleep 1000'] * sleepers + ['sh talk.sh']
    items = [
        f'  - executable: {{cmd: {command}, name: p{n}}}\n'
        for n, command in enumerate(commands)
    ]
    user.write('a.yaml', 'launch:\n' + ''.join(items))
    user.write('talk.sh', 'echo hello; sleep 1000')


def plain(text: str) -> list[str]:
    return re.sub(r'\x1b\[[0-9;]*m|\r', '', text).splitlines()


def test_a_terminal_gets_a_table_and_a_title(user: User, show: Show) -> None:
    write_launch(user)
    text = show('a.yaml', '--until', 'hello')
    assert text.index(TITLE) < text.index('hello') < text.index(RESTORED)
    lines = plain(text)
    start = next(n for n, s in enumerate(lines) if 'NAME' in s)
    assert lines[start].endswith('NAME  PID')
    assert re.fullmatch(r'p0-1  \d+', lines[start + 1])
    assert re.fullmatch(r'p1-2  \d+', lines[start + 2])
    assert 'started, pid' not in text
    home = Path(user.environment['HOME'])
    (log,) = home.glob('.ros/log/*/launch.log')
    assert log.read_text().count('started, pid') == 2


def test_a_hundred_processes_and_a_narrow_terminal(
    user: User, show: Show
) -> None:
    write_launch(user, 100)
    lines = plain(show('a.yaml', '--until', 'hello', COLUMNS='50'))
    start = next(n for n, s in enumerate(lines) if 'NAME' in s)
    assert lines[start + 1].startswith('p0-1 … p99-100')
    assert '  (100)  ' in lines[start + 1]
    assert lines[start + 2].startswith('p100-101 ')
    assert len(lines[start + 1]) <= 50


def test_a_dumb_terminal_gets_no_title_and_no_colour(
    user: User, show: Show
) -> None:
    write_launch(user)
    text = show('a.yaml', '--until', 'hello', TERM='dumb')
    assert '\x1b' not in text
    assert 'NAME' in text


def test_no_color_leaves_the_title(user: User, show: Show) -> None:
    write_launch(user)
    text = show('a.yaml', '--until', 'hello', '--no-status', NO_COLOR='1')
    assert '\x1b' not in text.replace(TITLE, '').replace(RESTORED, '')
    assert TITLE in text


def test_a_quiet_terminal_has_no_table(user: User, show: Show) -> None:
    write_launch(user)
    options = '--until', 'hello', '--quiet', '--no-status'
    text = show('a.yaml', *options, NO_COLOR='1')
    text = text.replace(TITLE, '').replace(RESTORED, '')
    assert {s.partition(']')[2].strip() for s in plain(text)} == {'hello'}


def test_a_pipe_gets_lines(user: User) -> None:
    write_launch(user)
    output = user.launch('a.yaml', '--until', 'hello')
    assert output.count('started, pid') == 2
    assert 'NAME' not in output
    assert '\x1b' not in output


def test_quietly_a_build_is_not_shown_unless_it_fails(user: User) -> None:
    user.package('one', "launch: [executable: {cmd: sh -c 'echo hi'}]\n")
    assert user.launch('one', 'one', '--quiet') == '[sh-1]   hi\n'
    user.write('src/one/CMakeLists.txt', 'message(FATAL_ERROR "bad luck")\n')
    output = user.launch('one', 'one', '--quiet', code=1)
    assert built(output) == ['one']
    assert 'bad luck' in output
    assert 'Failed   <<< one' in output


def test_quietly_warnings_and_failures_are_shown(user: User) -> None:
    user.write(
        'a.yaml',
        'launch:\n'
        '  - log: {level: INFO, message: for your information}\n'
        '  - log: {level: WARNING, message: mind the gap}\n'
        "  - executable: {cmd: sh -c 'exit 3'}\n",
    )
    output = user.launch('a.yaml', '--quiet', 'odd:=1', code=1)
    assert 'information' not in output
    assert 'mind the gap' in output
    assert 'odd' in output
    assert 'failed: sh-3' in output or 'failed: sh-1' in output
    assert 'started' not in output


def test_verbosely_a_process_is_described(user: User) -> None:
    user.write(
        'a.yaml',
        'launch:\n'
        '  - executable:\n'
        "      cmd: sh -c 'exit 0'\n"
        '      env: [{name: COLOUR, value: deep blue}]\n',
    )
    lines = user.launch('a.yaml', '--verbose').splitlines()
    start = next(n for n, s in enumerate(lines) if 'started, pid' in s)
    assert 'sh-1  (a.yaml:2:5)' in lines[start + 1]
    assert "COLOUR='deep blue' sh -c 'exit 0'" in lines[start + 2]
