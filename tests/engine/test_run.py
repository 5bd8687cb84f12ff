# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launches from start to end, with real processes."""

import gc
import io
import os
from pathlib import Path
import re
import resource
import signal
import stat
import subprocess

from colcon_yamllaunch.common import process_scan
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.run import run, RunContext
import pytest


def test_output_is_shown_with_its_label_and_all_is_well(launch, sh):
    one = launch(sh('a', 'echo one; echo two >&2'), sh('counter', 'echo 3'))
    assert one.ends() == 0
    lines = one.screen.splitlines()
    assert '[a]       one' in lines
    assert '[a]       two' in lines
    assert '[counter] 3' in lines
    assert any('a: started, pid ' in line for line in lines)
    assert any('a: finished' in line for line in lines)


def test_a_run_in_this_process_leaves_it_as_it_was(process, tmp_path):
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGCHLD)
    handlers = [signal.getsignal(n) for n in numbers]
    # what other tests left open is closed by now
    gc.collect()
    descriptors = set(os.listdir('/proc/self/fd'))
    folder = Path.cwd()
    children = _children()
    foreign = subprocess.Popen(['sh', '-c', 'exit 5'])
    stream = io.StringIO()
    code = run(
        Plan((process('a', 'sh', '-c', 'echo hello; exit 3'),)),
        RunContext(
            environment={'PATH': os.environ['PATH']},
            log_folder=tmp_path,
            stream=stream,
        ),
    )
    assert code == 1
    assert '[a]      hello' in stream.getvalue()
    assert [signal.getsignal(n) for n in numbers] == handlers
    assert set(os.listdir('/proc/self/fd')) == descriptors
    assert Path.cwd() == folder
    assert foreign.wait() == 5
    assert _children() <= children


def test_processes_older_than_the_launch_are_read_once(process, monkeypatch):
    """A sweep has many launches of one process, beside many others."""
    read = []

    def read_process(pid):
        read.append(pid)
        return original(pid)

    original = process_scan.read_process
    monkeypatch.setattr(process_scan, 'read_process', read_process)
    for _ in range(3):
        run(
            Plan((process('a', 'true'),)),
            RunContext(
                environment={'PATH': os.environ['PATH']},
                log_folder=None,
                stream=io.StringIO(),
            ),
        )
    assert read.count(1) <= 1


def test_a_crash_of_the_launcher_stops_what_it_started(
    process, tmp_path, is_running, wait_until
):
    started = []

    def spawn(*arguments, **options):
        if started:
            raise RuntimeError('a bug')
        started.append(os.posix_spawn(*arguments, **options))
        return started[0]

    with pytest.raises(RuntimeError, match='a bug'):
        run(
            Plan((process('a', 'sleep', '99'), process('b'))),
            RunContext(
                environment={'PATH': os.environ['PATH']},
                log_folder=None,
                stream=io.StringIO(),
                spawn=spawn,
            ),
        )
    wait_until(lambda: not is_running(started[0]))
    assert os.waitpid(started[0], 0)[1] == signal.SIGINT
    # the guard, too, ends with its work
    os.wait()


def test_each_process_has_a_group_of_its_own_in_the_order_of_the_plan(
    launch, sh, wait_until
):
    script = 'echo "group $(ps -o pgid= -p $$) of $$"; exec sleep 999'
    one = launch(*(sh(name, script) for name in 'abc'))
    wait_until(lambda: one.screen.count('group ') == 3)
    started = re.findall(r'(\w): started, pid (\d+)', one.screen)
    assert [label for label, _ in started] == list('abc')
    for label, pid in started:
        assert re.search(rf'\[{label}\] +group +{pid} of {pid}\n', one.screen)
    # and one thread waits for them all
    assert len(list(Path(f'/proc/{one.popen.pid}/task').iterdir())) == 1
    one.sends(signal.SIGINT)
    assert one.ends() == 0


def test_entries_run_in_order(launch, sh):
    one = launch(
        {'kind': 'message', 'level': 'INFO', 'text': 'first'},
        sh('a', 'echo done'),
        {
            'kind': 'timer',
            'period': 0.1,
            'entries': [
                {'kind': 'message', 'level': 'INFO', 'text': 'third'},
                sh('late', 'echo late'),
            ],
        },
        {'kind': 'message', 'level': 'INFO', 'text': 'second'},
    )
    assert one.ends() == 0
    places = [one.screen.index(t) for t in ('first', 'second', 'third')]
    assert places == sorted(places)
    assert '[late]   late' in one.screen


@pytest.mark.parametrize(
    ('script', 'text'),
    [
        ('echo why >&2; touch wrote; exit 3', 'exited with code 3'),
        ('echo why; touch wrote; kill -SEGV $$', 'died by SIGSEGV'),
        pytest.param(
            'echo why; touch wrote; kill -TERM $$',
            'died by SIGTERM',
            marks=pytest.mark.full,
        ),
    ],
)
def test_a_failure_is_named_last_with_its_last_lines(
    launch, sh, tmp_path, script, text
):
    # the last lines are repeated only if other output follows them
    good = 'until [ -e wrote ]; do sleep 0.01; done; sleep 0.1; echo fine'
    one = launch(
        sh('bad', script, cwd=str(tmp_path)),
        sh('good', good, cwd=str(tmp_path)),
    )
    assert one.ends() == 1
    closing = one.screen[one.screen.rindex('failed: ') :]
    assert closing.startswith(f'failed: bad {text}')
    assert '(from /ws/demo.yaml:14:5)' in closing
    assert '| why' in closing
    assert str(one.log_folder / 'bad/stdout_stderr.log') in closing


def test_programs_that_cannot_be_started_leave_the_others_alone(
    launch, sh, tmp_path
):
    script = tmp_path / 'script.py'
    script.write_text('print(1)')
    one = launch(
        {'label': 'missing', 'argv': ['no_such_program']},
        {'label': 'mode', 'argv': [str(script)]},
        {'label': 'cwd', 'argv': ['true'], 'cwd': '/no/such'},
        sh('good', 'echo fine'),
    )
    assert one.ends() == 1
    assert '[good]    fine' in one.screen
    assert 'failed: missing could not be started' in one.screen
    assert f'chmod +x {script}' in one.screen
    assert '/no/such' in one.screen
    labels = [e['label'] for e in one.events('start_failed')]
    assert labels == ['missing', 'mode', 'cwd']


def test_a_process_gets_its_environment(launch, sh):
    one = launch(
        sh(
            'a',
            'echo "$SET|${UNSET-unset}|$PYTHONUNBUFFERED|${HERE-none}"',
            environment={'SET': 'x y', 'UNSET': None},
        ),
        sh(
            'b',
            'echo "$PYTHONUNBUFFERED"',
            environment={
                'PYTHONUNBUFFERED': '0',
            },
        ),
        environment={'UNSET': 'set', 'HERE': 'yes'},
    )
    assert one.ends() == 0
    assert '[a]      x y|unset|1|yes' in one.screen
    assert '[b]      0' in one.screen


@pytest.mark.parametrize(
    ('color', 'expected'),
    [(True, '1'), pytest.param(False, '', marks=pytest.mark.full)],
)
def test_nodes_are_told_to_use_colours(launch, sh, color, expected):
    one = launch(sh('a', 'echo "<$RCUTILS_COLORIZED_OUTPUT>"'), color=color)
    assert one.ends() == 0
    assert f'<{expected}>' in one.screen


def test_no_color_wins_over_a_terminal(launch, sh):
    ours, theirs = os.openpty()
    one = launch(
        sh('a', 'echo hello'),
        environment={'NO_COLOR': '1'},
        popen={'stdout': theirs},
    )
    assert one.ends() == 0
    shown = os.read(ours, 4096)
    os.close(ours)
    os.close(theirs)
    assert b'hello' in shown
    assert b'\x1b' not in shown


def test_standard_input_is_at_its_end(launch, sh):
    ours, theirs = os.pipe()
    one = launch(sh('a', 'cat; echo end'), popen={'stdin': ours})
    assert one.ends() == 0
    os.close(ours)
    os.close(theirs)
    assert '[a]      end' in one.screen


def test_a_process_inherits_no_open_file_of_the_launcher(launch, sh):
    reader, writer = os.pipe()
    os.set_inheritable(writer, True)
    one = launch(sh('a', 'ls -l /proc/self/fd'), popen={'pass_fds': [writer]})
    assert one.ends() == 0
    os.close(reader)
    os.close(writer)
    links = [t for t in one.screen.splitlines() if ' -> ' in t]
    assert len(links) == 4
    assert sum('pipe:' in t for t in links) == 2


@pytest.mark.full
def test_a_parameter_file_lives_as_long_as_the_launch(launch, sh):
    content = 'counter:\n  ros__parameters: {text: ä}\n'
    one = launch(
        {
            'label': 'a',
            'argv': [
                'sh',
                '-c',
                'echo "path $0"; cat "$0"; sleep 99',
                {'content': content},
            ],
        }
    )
    one.shows('text: ä')
    path = Path(one.screen.partition('path ')[2].split('\n')[0])
    assert path.read_text() == content
    assert path.parent.name.startswith('colcon_launch_')
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700
    assert one.sends(signal.SIGINT).ends() == 0
    assert not path.parent.exists()


def test_a_process_that_ends_with_0_is_respawned(launch, sh):
    one = launch(
        sh(
            'a',
            'echo run',
            respawn=True,
            respawn_max_retries=2,
            respawn_delay=0.05,
        )
    )
    assert one.ends() == 0
    assert one.screen.count('[a]      run') == 3
    assert [e['attempt'] for e in one.events('respawned')] == [1, 2]
    assert one.log('a/stdout.log') == b'run\n' * 3


def test_a_process_that_fails_to_the_last_retry_failed(launch, sh):
    one = launch(sh('a', 'exit 3', respawn=True, respawn_max_retries=1))
    assert one.ends() == 1
    assert len(one.events('exited')) == 2
    assert 'failed: a exited with code 3' in one.screen


@pytest.mark.hostile
def test_a_program_that_is_missing_for_a_while_is_respawned(
    launch, tmp_path, wait_until
):
    program = tmp_path / 'program'
    program.write_text('#!/bin/sh\nsetsid sleep 999 &\nrm "$0"; exit 3\n')
    program.chmod(0o700)
    one = launch(
        {
            'label': 'a',
            'argv': [str(program)],
            'respawn': True,
            'respawn_delay': 0.05,
            'sigterm_timeout': 0.2,
        }
    )
    one.shows('a: could not be started').shows('starts again in 0.05 s')
    # what the former one left is gone before the next is tried
    assert one.processes() == []
    other = tmp_path / 'other'
    other.write_text('#!/bin/sh\necho back; exec sleep 999\n')
    other.chmod(0o700)
    other.rename(program)
    one.shows('[a]      back')
    assert one.events('start_failed')[0]['respawn_delay'] == 0.05
    assert one.sends(signal.SIGINT).ends() == 0


def test_a_failure_that_a_respawn_mends_is_shown_but_not_counted(
    launch, sh, tmp_path
):
    flag = tmp_path / 'flag'
    one = launch(
        sh(
            'a',
            f'test -e {flag} && exit 0; touch {flag}; exit 3',
            respawn=True,
            respawn_max_retries=1,
        )
    )
    assert one.ends() == 0
    assert 'a: exited with code 3' in one.screen
    assert 'failed:' not in one.screen


@pytest.mark.parametrize(
    ('script', 'code'),
    [pytest.param('exit 0', 0, marks=pytest.mark.full), ('exit 4', 1)],
)
def test_the_end_of_a_required_process_ends_the_launch(
    launch, sleep, sh, script, code
):
    one = launch(
        sleep('other'),
        sh('required', f'sleep 0.1; {script}', on_exit_shutdown=True),
    )
    assert one.ends() == code
    assert 'stopping: required ended' in one.screen
    assert [e['reason'] for e in one.events('shutdown')]


def test_a_shutdown_entry_stops_everything(launch, sleep, sh):
    one = launch(
        sleep('a'),
        {
            'kind': 'timer',
            'period': 0.1,
            'entries': [
                {'kind': 'shutdown', 'reason': 'enough'},
                sh('never', 'echo never'),
            ],
        },
    )
    assert one.ends() == 0
    assert 'stopping: enough' in one.screen
    assert 'never' not in one.screen


def test_events_tell_the_whole_story(launch, sleep):
    one = launch(sleep('a')).shows('a: started')
    assert one.sends(signal.SIGINT).ends() == 0
    kinds = ['started', 'shutdown', 'signalled', 'exited', 'ended']
    for kind in kinds:
        assert len(one.events(kind)) == 1
    pid = one.events('started')[0]['pid']
    assert one.events('signalled')[0]['pid'] == pid
    exited = one.events('exited')[0]
    assert (exited['pid'], exited['signal']) == (pid, 'SIGINT')
    assert exited['asked']
    assert not exited['failed']
    assert 'a: started' in one.log('launch.log').decode()


def test_a_log_folder_that_cannot_be_made_does_not_stop_the_launch(
    launch, sh, tmp_path
):
    (tmp_path / 'file').write_text('')
    one = launch(
        sh('a', 'echo hello'), log_folder=str(tmp_path / 'file' / 'log')
    )
    assert one.ends() == 0
    assert '[a]      hello' in one.screen
    assert one.screen.count('cannot be written') == 1


@pytest.mark.full
def test_many_processes_run_with_few_allowed_files(launch, sh):
    # and each has the limit that the launcher was started with
    script = 'until test $(ulimit -Sn) = 80; do sleep 0.05; done; echo fine'
    one = launch(
        *(sh(f'p{n}', script) for n in range(60)),
        popen={'preexec_fn': _allow_few_files},
    )
    assert one.ends() == 0
    assert one.screen.count('] fine\n') + one.screen.count('  fine\n') == 60


def _children():
    return set(Path('/proc/thread-self/children').read_text().split())


def _allow_few_files():
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (80, hard))
