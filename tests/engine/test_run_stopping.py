# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Stopping real launches by real signals; nothing is ever left behind."""

import os
from pathlib import Path
import re
import signal
import subprocess
import time

from colcon_yamllaunch.engine import limits
import pytest

STUBBORN = (
    'import signal, sys, time\n'
    'def note(number, frame):\n'
    '    print(signal.Signals(number).name, flush=True)\n'
    'signal.signal(signal.SIGINT, note)\n'
    'signal.signal(signal.SIGTERM, note)\n'
    'print("ready", flush=True)\n'
    'while True: time.sleep(1)\n'
)


QUICK = {'sigterm_timeout': 0.2, 'sigkill_timeout': 0.2}
PATIENT = {'sigterm_timeout': 900.0, 'sigkill_timeout': 900.0}


@pytest.mark.parametrize(
    'number',
    [
        signal.SIGINT,
        signal.SIGTERM,
        pytest.param(signal.SIGHUP, marks=pytest.mark.full),
    ],
)
def test_a_signal_to_the_launcher_stops_everything(launch, sleep, sh, number):
    one = launch(sleep('a'), sh('b', 'echo b; exec sleep 99'))
    one.shows('[b]      b').sends(number)
    assert one.ends() == 0
    assert 'stopping: ' in one.screen
    assert one.processes() == []


def test_a_node_that_cleans_up_on_sigint_is_waited_for(launch, python):
    script = (
        'import time\n'
        'try:\n'
        '    print("ready", flush=True); time.sleep(99)\n'
        'except KeyboardInterrupt:\n'
        '    time.sleep(0.2); print("cleaned up", flush=True)\n'
    )
    one = launch(python('a', script)).shows('ready')
    assert one.sends(signal.SIGINT).ends() == 0
    assert '[a]      cleaned up' in one.screen


def test_signals_are_sent_again_harder_until_the_process_ends(launch, python):
    one = launch(python('a', STUBBORN, **QUICK)).shows('ready')
    assert one.sends(signal.SIGINT).ends() == 0
    assert one.log('a/stdout.log') == b'ready\nSIGINT\nSIGTERM\n'
    sent = [e['signal'] for e in one.events('signalled')]
    assert sent == ['SIGINT', 'SIGTERM', 'SIGKILL']


@pytest.mark.full
def test_ctrl_c_again_goes_one_step_further(launch, python, wait_until):
    one = launch(python('a', STUBBORN, **PATIENT)).shows('ready')
    one.sends(signal.SIGINT)
    # a line about what is waited for is later than an echo of the signal
    one.shows('[a]      SIGINT').shows('waiting for a after SIGINT')
    one.sends(signal.SIGINT).shows('[a]      SIGTERM')
    one.shows('waiting for a after SIGTERM; SIGKILL in 900 s')
    shown = time.monotonic()
    wait_until(
        lambda: time.monotonic() - shown > 2 * limits.SIGNAL_ECHO_INTERVAL
    )
    assert one.sends(signal.SIGINT).ends() == 0
    assert one.processes() == []


@pytest.mark.full
def test_two_signals_at_once_are_one(launch, python):
    one = launch(python('a', STUBBORN, **PATIENT)).shows('ready')
    # as `timeout` does it: to the process, and to its group
    for number in (signal.SIGSTOP, signal.SIGINT, signal.SIGTERM):
        one.sends(number)
    one.sends(signal.SIGCONT)
    one.shows('waiting for a after SIGINT')
    assert b'SIGTERM' not in one.log('a/stdout.log')


def test_the_children_of_a_shell_are_stopped_with_it(launch, sh, wait_until):
    one = launch(sh('a', 'sleep 99; true')).shows('started')
    wait_until(lambda: len(one.processes()) == 2)
    assert one.sends(signal.SIGINT).ends() == 0
    assert one.processes() == []


def test_a_child_that_left_the_group_is_stopped_too(launch, sh):
    script = 'setsid sh -c "echo child; exec sleep 99" & wait'
    one = launch(sh('a', script, sigterm_timeout=0.1)).shows('child')
    assert one.sends(signal.SIGINT).ends() == 0
    assert one.processes() == []
    assert any(not e['group'] for e in one.events('signalled'))


def test_what_a_process_leaves_running_lives_as_long_as_the_launch(
    launch, sleep, sh, is_running
):
    script = 'setsid sh -c "echo child \\$\\$; exec sleep 99" &'
    one = launch(sh('a', script, sigterm_timeout=0.1), sleep('b'))
    one.shows('a: finished').shows('child ')
    child = int(one.screen.partition('child ')[2].split()[0])
    assert is_running(child)
    assert one.sends(signal.SIGINT).ends() == 0
    assert not is_running(child)
    (shutdown,) = one.events('shutdown')
    assert min(e['time'] for e in one.events('signalled')) >= shutdown['time']


def test_a_launch_that_ends_by_itself_leaves_nothing_running(launch, sh):
    one = launch(
        sh('a', 'sleep 99 & setsid sleep 99 & exit 0', sigterm_timeout=0.1)
    )
    assert one.ends() == 0
    assert one.processes() == []


def test_a_stopped_process_can_be_stopped_for_good(launch, sh, wait_until):
    one = launch(sh('a', 'kill -STOP $$; sleep 99')).shows('a: started')
    pid = one.events('started')[0]['pid']
    wait_until(lambda: _state(pid) == 'T')
    assert one.sends(signal.SIGINT).ends() == 0
    assert one.events('exited')[0]['signal'] == 'SIGINT'


def test_a_process_that_is_suspended_is_told_and_can_be_continued(launch, sh):
    one = launch(sh('a', 'kill -TSTP $$; echo again; exec sleep 99'))
    one.shows('a: held by SIGTSTP')
    command = one.screen.partition('go on: ')[2].split('\n')[0]
    subprocess.run(command.split(), check=True)
    one.shows('a: goes on').shows('[a]      again')
    assert one.sends(signal.SIGINT).ends() == 0
    assert one.events('held')[0]['signal'] == 'SIGTSTP'
    assert len(one.events('continued')) == 1


@pytest.mark.full
def test_ctrl_z_holds_everything_and_fg_lets_it_go_on(
    launch, python, sh, wait_until
):
    script = 'import time\nwhile not time.sleep(0.05): print("x")'
    one = launch(
        python('a', script),
        sh('b', 'setsid sleep 99 & sleep 99 & exec sleep 99'),
        sh('c', 'sleep 99 & exit 0'),
        # as a shell with job control starts a job
        popen={'start_new_session': False, 'preexec_fn': os.setpgrp},
    )
    one.shows('[a]      x').shows('c: finished')
    wait_until(lambda: len(one.processes()) == 5)
    pids = one.processes()
    one.sends(signal.SIGTSTP)
    wait_until(lambda: {_state(p) for p in (one.popen.pid, *pids)} == {'T'})
    before = one.screen.count('x')
    one.sends(signal.SIGCONT)
    wait_until(lambda: one.screen.count('x') > before + 5)
    wait_until(lambda: 'T' not in {_state(p) for p in pids})
    # that is known to who typed it
    assert one.events('held') == one.events('continued') == []
    # one after that line is no echo of the first
    one.sends(signal.SIGTERM).shows('after SIGINT')
    assert one.sends(signal.SIGTERM).ends() == 0


def test_ctrl_z_does_nothing_where_nobody_could_go_on(
    launch, python, wait_until
):
    script = 'import time\nwhile not time.sleep(0.01): print("x")'
    # the leader of a session has no shell above it
    one = launch(python('a', script)).shows('[a]      x')
    one.sends(signal.SIGTSTP)
    before = one.screen.count('x')
    wait_until(lambda: one.screen.count('x') > before + 5)
    assert one.sends(signal.SIGINT).ends() == 0


def test_nohup_keeps_the_launch_running(launch, sleep):
    def ignore() -> None:
        signal.signal(signal.SIGHUP, signal.SIG_IGN)

    one = launch(sleep('a'), popen={'preexec_fn': ignore})
    one.shows('a: started').sends(signal.SIGHUP)
    assert one.sends(signal.SIGTERM).ends() == 0
    assert 'stopping: SIGTERM received' in one.screen


def test_nothing_survives_a_killed_launcher(launch, sh, python, wait_until):
    parameters = sh('parameters', 'echo "path $0"; sleep 99', **QUICK)
    parameters['argv'].append({'content': 'x'})
    one = launch(
        sh('plain', 'sleep 99; true', **QUICK),
        python('stubborn', STUBBORN, **QUICK),
        sh('daemon', 'setsid sleep 99 & sleep 99', **QUICK),
        sh('bare', "env -i sh -c 'echo bare $$; sleep 99'", **QUICK),
        sh('left', 'setsid sleep 99 & exit 0', **QUICK),
        parameters,
    )
    one.shows('ready').shows('left: finished').shows('path ').shows('bare ')
    path = Path(one.screen.partition('path ')[2].split('\n')[0])
    bare = int(re.search(r' bare (\d+)', one.screen)[1])
    guard = wait_until(one.guards)[0]
    assert path.exists()
    one.sends(signal.SIGKILL)
    one.popen.wait()
    wait_until(lambda: not one.processes())
    wait_until(lambda: not path.parent.exists())
    wait_until(lambda: not Path(f'/proc/{bare}').exists())
    wait_until(lambda: _state(guard) in ('Z', None))


def test_a_killed_launcher_gives_processes_time_to_clean_up(
    launch, python, wait_until, tmp_path
):
    note = tmp_path / 'note'
    script = (
        'import time\n'
        'try:\n'
        '    print("ready", flush=True); time.sleep(99)\n'
        'except KeyboardInterrupt:\n'
        '    time.sleep(0.1)\n'
        f'    open({str(note)!r}, "w").close()\n'
    )
    one = launch(python('a', script)).shows('ready')
    one.sends(signal.SIGKILL)
    one.popen.wait()
    wait_until(note.exists)
    wait_until(lambda: not one.processes())


def test_pkill_of_all_that_is_called_colcon_leaves_the_guard(
    launch, sleep, wait_until
):
    one = launch(sleep('a')).shows('a: started')
    (guard,) = wait_until(one.guards)
    words = Path(f'/proc/{guard}/cmdline').read_bytes().split(b'\0')
    # the path of Python may be any
    assert b'colcon' not in b' '.join(words[1:])


def test_a_guard_that_dies_is_replaced(launch, sleep, wait_until):
    one = launch(sleep('a')).shows('a: started')
    first = wait_until(one.guards)[0]
    os.kill(first, signal.SIGKILL)
    second = wait_until(lambda: set(one.guards()) - {first})
    assert second
    one.sends(signal.SIGKILL)
    one.popen.wait()
    wait_until(lambda: not one.processes())


@pytest.mark.full
def test_a_guard_that_dies_again_and_again_is_given_up(
    launch, sleep, wait_until
):
    one = launch(sleep('a')).shows('a: started')
    killed = set()
    for _ in range(limits.GUARD_RESTARTS + 1):
        guard = wait_until(lambda: set(one.guards()) - killed).pop()
        killed.add(guard)
        os.kill(guard, signal.SIGKILL)
    one.shows('warning: the guard ended too often')
    assert one.sends(signal.SIGINT).ends() == 0


def test_a_guard_ignores_the_signals_that_stop_a_session(
    launch, sleep, wait_until
):
    one = launch(sleep('a')).shows('a: started')
    guard = wait_until(one.guards)[0]
    ignored = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    for number in ignored:
        os.kill(guard, number)
    assert os.getsid(guard) == guard
    # they wait for ever
    status = Path(f'/proc/{guard}/status').read_text()
    pending = int(status.partition('ShdPnd:')[2].split()[0], 16)
    assert pending == sum(1 << (number - 1) for number in ignored)
    assert one.guards() == [guard]
    assert one.sends(signal.SIGINT).ends() == 0
    assert _state(guard) is None


def _state(pid):
    try:
        stat = Path(f'/proc/{pid}/stat').read_text()
    except (FileNotFoundError, ProcessLookupError):
        return None
    return stat.rpartition(') ')[2][0]


def test_ended_process_is_reaped_without_sigchld(launch, sleep):
    # such as with a library that blocks it for a while
    def block() -> None:
        signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGCHLD])

    one = launch(sleep('a', **QUICK), popen={'preexec_fn': block})
    one.shows('a: started').sends(signal.SIGTERM)
    assert one.ends() == 0
    assert 'cannot be stopped' not in one.screen
