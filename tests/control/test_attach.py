# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A launch in a real terminal whose keyboard goes to one of its processes."""

import json
import os
from pathlib import Path
import signal
import sys
import termios

import pytest
from support.terminal import Terminal

LAUNCHER = Path(__file__).parents[1] / 'support/launcher.py'
ROOT = Path(__file__).parents[2]
#: Shows each key that it gets, as a program for single keys does.
KEYS = (
    'import os, signal, tty\n'
    'signal.signal(signal.SIGINT, signal.SIG_DFL)\n'
    'tty.setraw(0)\n'
    'os.write(1, b"keys please> ")\n'
    'while (key := os.read(0, 1)) != b"q":\n'
    '    os.write(1, b"<%s>" % key.hex().encode())\n'
)
#: Runs a job as an interactive shell does, and says `fg` after Enter.
SHELL = ('bash', '-c', 'set -m; "$@"; echo back in the shell; read; fg', 'job')
ASK = (
    'import signal\n'
    'signal.signal(signal.SIGINT, signal.SIG_DFL)\n'
    'print("hello", input("Name: "))\n'
)
CRASH = (
    'import sys\n'
    'sys.argv[0] = {launcher!r}\n'
    'sys.path.insert(0, {folder!r})\n'
    'from colcon_yamllaunch.terminal import attachment\n'
    'def crash(*arguments): raise ZeroDivisionError\n'
    'attachment.LocalAttachment._typed = crash\n'
    'import launcher\n'
    'launcher.main()\n'
)


@pytest.fixture
def attached(tmp_path, is_running, wait_until):
    """Return a function that launches with a process at the keyboard."""
    terminals = []

    def start(label, *entries, program=None, shell=(), **settings):
        plan = {
            'entries': list(entries),
            'attach': label,
            'log_folder': str(tmp_path / 'log'),
            'color': False,
            **settings,
        }
        path = tmp_path / 'plan.json'
        path.write_text(json.dumps(plan))
        code = ['-c', program] if program else [str(LAUNCHER)]
        environment = {
            'PATH': os.environ['PATH'],
            'PYTHONPATH': str(ROOT),
            'TMPDIR': str(tmp_path),
            'TERM': 'xterm',
            'TEST_LAUNCH': str(tmp_path),
        }
        argv = [*shell, sys.executable, '-S', *code, str(path)]
        terminals.append(Terminal(argv, tmp_path, environment))
        return terminals[-1]

    yield start
    for terminal in terminals:
        terminal.close()
    mark = f'TEST_LAUNCH={tmp_path}\0'.encode()
    wait_until(lambda: not _marked(mark))


def _marked(mark):
    found = []
    for entry in Path('/proc').iterdir():
        if entry.name.isdigit():
            try:
                environment = (entry / 'environ').read_bytes()
            except OSError:
                continue
            if mark in environment:
                found.append(entry.name)
    return found


def log_of(tmp_path, name):
    return (tmp_path / 'log' / name).read_bytes()


def restored(terminal):
    return terminal.modes() == terminal.modes_before


def test_each_key_arrives_as_it_is(attached, python, tmp_path):
    keys = '\x1b[A\r\n\t\x11\x13\x1c\x7fä'
    t = attached('a', python('a', KEYS, emulate_tty=True))
    t.shows('Ctrl-] detaches, Ctrl-C stops the launch').shows('keys please> ')
    t.types(keys)
    shown = ''.join(f'<{byte:02x}>' for byte in keys.encode())
    t.shows(shown).types('q')
    assert t.ends() == 0
    assert restored(t)
    assert shown.encode() in log_of(tmp_path, 'a/stdout.log')


def test_a_prompt_is_shown_and_lines_are_echoed(attached, python, tmp_path):
    t = attached('a', python('a', ASK, emulate_tty=True))
    t.shows('Name: ').types('Bob').shows('Bob').types('\r').shows('hello Bob')
    assert t.ends() == 0
    assert restored(t)
    # what is echoed is not what the process wrote
    assert log_of(tmp_path, 'a/stdout.log') == b'hello Bob\n'
    assert log_of(tmp_path, 'a/stderr.log') == b'Name: '


def test_others_begin_their_lines_at_the_start(attached, python, sh):
    t = attached(
        'a',
        python('a', ASK, emulate_tty=True),
        sh('b', 'while sleep 0.05; do echo tick; done'),
    )
    t.shows('Name: \r\n[b]      tick').types('\x03')
    assert t.ends() == 0


def test_the_table_comes_before_the_hint(attached, python, sleep):
    t = attached('a', python('a', KEYS, emulate_tty=True), sleep('b'))
    t.shows('keys please> ')
    lines = t.screen.replace('\r', '').splitlines()
    assert [line.split()[0] for line in lines[:4]] == [
        'NAME',
        'a',
        'b',
        '[launch]',
    ]
    assert 'Ctrl-] detaches' in lines[3]
    t.types('\x03')
    assert t.ends() == 0


def test_quiet_goes_with_a_keyboard(attached, python, sleep):
    t = attached(
        'a',
        python('a', KEYS, emulate_tty=True),
        sleep('b'),
        verbosity='quiet',
    )
    t.shows('keys please> ').types('x').shows('<78>').types('\x03')
    assert t.ends() == 0
    # the shell's prompt begins a line of its own
    assert t.screen == 'keys please> <78>\r\n'


def test_ctrl_c_stops_the_launch(attached, python, sleep):
    t = attached('a', python('a', KEYS, emulate_tty=True), sleep('b'))
    t.shows('keys please> ').types('\x03')
    assert t.ends() == 0
    assert 'stopping: interrupted' in t.screen
    assert '<03>' not in t.screen
    assert restored(t)


def test_the_escape_key_detaches(attached, python, sleep, wait_until):
    t = attached('a', python('a', KEYS, emulate_tty=True), sleep('b'))
    t.shows('keys please> ').types('x').shows('<78>')
    t.types('y\x1dq').shows('a: detached')
    wait_until(lambda: restored(t))
    assert 'a: finished' not in t.screen
    t.types('\x03')
    assert t.ends() == 0


def test_the_terminal_is_free_when_the_process_ends(
    attached, python, sleep, wait_until
):
    t = attached('a', python('a', KEYS, emulate_tty=True), sleep('b'))
    t.shows('keys please> ').types('q').shows('a: finished')
    wait_until(lambda: restored(t))
    t.types('\x03')
    assert t.ends() == 0


def test_a_process_that_is_respawned_gets_the_keyboard_again(attached, python):
    t = attached('a', python('a', KEYS, emulate_tty=True, respawn=True))
    t.shows('keys please> ').types('q').shows('keys please> ', times=2)
    t.types('z').shows('<7a>').types('\x03')
    assert t.ends() == 0
    assert restored(t)


def test_ctrl_z_gives_the_terminal_back_until_it_goes_on(
    attached, python, wait_until
):
    t = attached('a', python('a', KEYS, emulate_tty=True), shell=SHELL)
    t.shows('keys please> ').types('\x1a').shows('back in the shell')
    assert restored(t)
    t.types('\n')
    wait_until(lambda: not restored(t))
    t.types('z').shows('<7a>').types('q')
    assert t.ends() == 0
    assert restored(t)


def test_what_a_shell_set_meanwhile_is_undone(attached, python, wait_until):
    t = attached('a', python('a', KEYS, emulate_tty=True))
    t.shows('keys please> ')
    t.process.send_signal(signal.SIGSTOP)
    wait_until(lambda: _state(t.process.pid) == 'T')
    termios.tcsetattr(t._theirs, termios.TCSANOW, t.modes_before)
    t.process.send_signal(signal.SIGCONT)
    wait_until(lambda: not restored(t))
    t.types('z').shows('<7a>').types('q')
    assert t.ends() == 0
    assert restored(t)


@pytest.mark.parametrize(
    'number',
    [signal.SIGTERM, pytest.param(signal.SIGHUP, marks=pytest.mark.full)],
)
def test_a_signal_restores_the_terminal(attached, python, number):
    t = attached('a', python('a', KEYS, emulate_tty=True))
    t.shows('keys please> ').process.send_signal(number)
    assert t.ends() == 0
    assert restored(t)


def test_a_crash_restores_the_terminal(attached, python):
    program = CRASH.format(launcher=str(LAUNCHER), folder=str(LAUNCHER.parent))
    t = attached('a', python('a', KEYS, emulate_tty=True), program=program)
    t.shows('keys please> ').types('x')
    assert t.process.wait() == 1
    assert 'ZeroDivisionError' in t.screen
    assert restored(t)


@pytest.mark.full
def test_a_flood_of_keys_is_no_harm(attached, python, sleep):
    t = attached('a', sleep('a', emulate_tty=True))
    t.shows('attached')
    for _ in range(100):
        t.types('x' * 1000)
        assert 'Traceback' not in t.screen
    t.types('\x03')
    assert t.ends() == 0
    assert restored(t)


def _state(pid):
    stat = Path(f'/proc/{pid}/stat').read_text()
    return stat.rpartition(') ')[2][0]
