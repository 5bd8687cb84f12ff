# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launches in a terminal that keeps the state of all below the output."""

import signal
import subprocess
import termios

import pytest

#: Runs a job as an interactive shell does.
SHELL = (
    'bash',
    '-c',
    'set -m; "$@"; echo in the shell; read; fg; bg; echo again; read; fg',
    'job',
)
#: Asks for a name, half a line.
ASK = (
    'import signal\n'
    'signal.signal(signal.SIGINT, signal.SIG_DFL)\n'
    'print("hello", input("Name: "))\n'
    'signal.pause()\n'
)
#: Takes a while to stop.
STUBBORN = 'trap "" INT TERM; echo up; while :; do sleep 99; done'
#: Ends when the test says so.
UNTIL = 'until [ -e $TMPDIR/go ]; do sleep 0.05; done; '


def test_the_states_of_three_processes(status, sh):
    one = status(
        sh('talker', 'echo 1; ' + UNTIL + 'echo 2; exec sleep 99'),
        sh('crasher', UNTIL + 'echo bad; exit 3'),
        sh('worker', UNTIL, respawn=True, respawn_delay=99.0),
    )
    block = ' 1 ● talker  2 ● crasher  3 ● worker'
    one.shows('[talker]  1', block)
    assert one.screen.colour_of('● talker') == 'green'
    (one.launch.folder / 'go').touch()
    one.shows(' 1 ● talker  2 ✗ crasher exit 3  3 ↻ worker')
    assert one.screen.colour_of('✗') == 'red'
    assert one.screen.colour_of('↻') == 'brown'
    said = {'[talker]  2', '[crasher] bad'}
    one.screen.shows(lambda _: said < set(one.screen.all_lines))
    assert one.types('\x03').ends() == 1
    # the block is gone, and all else is there
    text = '\n'.join(one.screen.all_lines)
    assert '●' not in text
    assert 'failed: crasher exited with code 3' in text
    assert text.count('[talker]  1') == 1


def test_two_hundred_processes_in_terminals_of_any_width(status, sleep, sh):
    one = status(
        *(sleep(f'node_{n}') for n in range(198)),
        sh('crasher', 'exit 4'),
        sh('talker', 'n=0; while :; do echo $((n+=1)); sleep 0.05; done'),
        size=(40, 20),
    )
    for columns in (40, 80, 200, 40):
        one.screen.resize(columns, 20)
        # there is nobody who tells the launcher but the terminal
        one.launch.sends(signal.SIGWINCH)
        lines = one.shows(' ✗ crasher exit 4  ● 199 running')
        assert lines[-1].startswith(' ? help')
        assert not any('●' in line for line in lines[:-2])
    one.types('\x03').ends()
    numbers = [
        line.split()[-1]
        for line in one.screen.all_lines
        if line.startswith('[talker]')
    ]
    assert numbers == [str(n + 1) for n in range(len(numbers))]


def test_stopping_is_counted_down_in_the_block(status, sh):
    one = status(sh('mule', STUBBORN, sigterm_timeout=90.0))
    one.shows('[mule]', ' 1 ● mule')
    one.types('\x03')
    one.shows(' 1 ◍ mule', ' stopping, SIGTERM in 8')
    one.types('\x03')
    # a signal that follows at once would be taken for the same one
    one.shows(' 1 ◍ mule', ' stopping, SIGKILL in 4 s')
    one.types('\x03').ends()
    text = '\n'.join(one.screen.all_lines)
    assert 'waiting for' not in text
    assert 'SIGTERM in' not in text
    assert 'mule: stopped, died by SIGKILL' in text


def test_another_job_has_the_terminal(status, sh):
    one = status(sh('a', 'echo up; exec sleep 99'), shell=SHELL)
    one.shows('[a]      up', ' 1 ● a')
    lines = one.types('\x1a').shows('in the shell')
    assert not any('●' in line for line in lines)
    assert termios.tcgetattr(one.screen.theirs)[3] & termios.ECHO
    one.types('\r').shows(' 1 ● a')
    assert not termios.tcgetattr(one.screen.theirs)[3] & termios.ECHO
    one.types('\x1a').shows('again')
    one.types('\r').shows(' 1 ● a')
    one.types('\x03').ends()


def test_who_types_at_a_launch_without_keyboard_disturbs_nothing(status, sh):
    one = status(
        sh('a', 'echo up; ' + UNTIL + 'echo on; exec sleep 99'),
        stdin=subprocess.DEVNULL,
    )
    one.shows('[a]      up', ' 1 ● a')
    one.types('x\r\r')
    (one.launch.folder / 'go').touch()
    one.shows('[a]      up', '[a]      on', ' 1 ● a')
    one.types('\x03').ends()


@pytest.mark.parametrize('keys', ['', '/b'])
def test_a_killed_launcher_leaves_a_sane_terminal(
    status, sleep, is_running, keys
):
    one = status(sleep('a'), sleep('b'))
    one.shows(' 1 ● a  2 ● b')
    (guard,) = one.launch.guards()
    if keys:
        one.types(keys).screen.shows(lambda lines: lines[-1] == keys)
    one.launch.sends(signal.SIGKILL)
    one.screen.shows(lambda lines: not any('●' in line for line in lines))
    one.screen.shows(lambda _: not is_running(guard))
    one.ends()


def test_a_half_line_of_who_has_the_keyboard(status, python, sh):
    one = status(
        python('asker', ASK, emulate_tty=True),
        sh('talker', UNTIL + 'echo done; exec sleep 99'),
        attach='asker',
    )
    block = ' 1 ● asker  2 ● talker'
    back = ' Ctrl-] goes back'
    one.shows('Name:', block, back, 'asker>')
    one.types('Ada').shows('Name:', block, back, 'asker> Ada')
    line, column = one.screen.cursor
    assert one.screen.lines[line][:column] == 'asker> Ada'
    (one.launch.folder / 'go').touch()
    one.shows('Name:', '[talker] done', block, back, 'asker> Ada')
    lines = ('Ada L.', 'hello Ada L.', block, back, 'asker>')
    one.types(' L.\r').shows(*lines)
    one.types('\x03').ends()


@pytest.mark.parametrize(
    'variables', [{'TERM': 'dumb'}, {'TERM': ''}, {'CI': 'true'}]
)
def test_a_terminal_that_only_prints(status, sh, variables):
    one = status(sh('a', 'echo up'), variables=variables)
    assert one.ends() == 0
    line, end = one.screen.all_lines[-2:]
    assert line == '[a]      up'
    assert end.startswith('[launch] a: finished after ')
    assert one.screen.received < 200
