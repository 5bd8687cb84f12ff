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


def run_here(*entries, **settings):
    """Run a plan in this process, and return the exit code."""
    known = {'log_folder': None, 'stream': io.StringIO(), **settings}
    environment = {'PATH': os.environ['PATH']}
    return run(Plan(entries), RunContext(environment=environment, **known))


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
    one = process('a', 'sh', '-c', 'echo hello; exit 3')
    code = run_here(one, log_folder=tmp_path, stream=stream)
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
        run_here(process('a', 'true'))
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
        run_here(process('a', 'sleep', '99'), process('b'), spawn=spawn)
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
    script = 'echo "$SET|${UNSET-unset}|$PYTHONUNBUFFERED|${HERE-none}"'
    buffered = {'PYTHONUNBUFFERED': '0'}
    one = launch(
        sh('a', script, environment={'SET': 'x y', 'UNSET': None}),
        sh('b', 'echo "$PYTHONUNBUFFERED"', environment=buffered),
        environment={'UNSET': 'set', 'HERE': 'yes'},
    )
    assert one.ends() == 0
    assert '[a]      x y|unset|1|yes' in one.screen
    assert '[b]      0' in one.screen


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
    described = sh('a', 'echo "path $0"; cat "$0"; sleep 99')
    described['argv'].append({'content': content})
    one = launch(described).shows('text: ä')
    path = Path(one.screen.partition('path ')[2].split('\n')[0])
    assert path.read_text() == content
    assert path.parent.name.startswith('colcon_launch_')
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700
    assert one.sends(signal.SIGINT).ends() == 0
    assert not path.parent.exists()


@pytest.mark.hostile
def test_a_program_that_is_missing_for_a_while_is_respawned(
    launch, tmp_path, wait_until
):
    program = tmp_path / 'program'
    program.write_text('#!/bin/sh\nsetsid sleep 999 &\nrm "$0"; exit 3\n')
    program.chmod(0o700)
    respawn = {'respawn': True, 'respawn_delay': 0.05, 'sigterm_timeout': 0.2}
    one = launch({'label': 'a', 'argv': [str(program)], **respawn})
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
    script = f'test -e {flag} && exit 0; touch {flag}; exit 3'
    one = launch(sh('a', script, respawn=True, respawn_max_retries=1))
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
    shutdown = {'kind': 'shutdown', 'reason': 'enough'}
    entries = [shutdown, sh('never', 'echo never')]
    one = launch(
        sleep('a'), {'kind': 'timer', 'period': 0.1, 'entries': entries}
    )
    assert one.ends() == 0
    assert 'stopping: enough' in one.screen
    assert 'never' not in one.screen


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
