# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launches whose launcher was killed together with its guard."""

import os
from pathlib import Path
import signal

from colcon_yamllaunch.control.client import ControlError, LaunchEndedError
from colcon_yamllaunch.control.orphaned_launches import orphaned_launches
from colcon_yamllaunch.engine import commands
from colcon_yamllaunch.engine.cgroup import process_folder
import pytest
from support.controlled import ABOUT
from support.hostile import needs_control_group

pytestmark = pytest.mark.hostile

QUICK = {'sigterm_timeout': 0.2, 'sigkill_timeout': 0.2}


def found(one, **place):
    """Return a launch as another terminal finds it, if it does."""
    place = {'TMPDIR': str(one.folder), **place}
    pid = one.popen.pid
    launches = orphaned_launches(place)
    return [launch for launch in launches if launch.refresh().pid == pid]


class Orphaned:
    """A launch that lost its launcher and its guard."""

    def __init__(self, one, wait_until):
        self.one = one
        self.folder = one.folder / f'colcon-launch-{os.getuid()}'
        (guard,) = wait_until(one.guards)
        wait_until(lambda: list(self.folder.glob('*.json')))
        # the launcher would start another guard
        one.sends(signal.SIGSTOP)
        os.kill(guard, signal.SIGKILL)
        one.sends(signal.SIGKILL)
        one.popen.wait()

    def found(self):
        (launch,) = found(self.one)
        return launch


@pytest.fixture
def orphaned(launch, wait_until):
    """Return a function that orphans a launch which shows a text."""

    def make(text, *entries):
        one = launch(*entries, about=ABOUT).shows(text)
        return Orphaned(one, wait_until)

    return make


def test_orphans_are_found_and_stopped_by_name_and_all_together(
    orphaned, sleep, sh, wait_until
):
    ignoring = 'trap "" INT TERM; echo "ready $0"; while :; do sleep 1; done'
    parameters = sh('c', ignoring, **QUICK)
    parameters['argv'].append({'content': 'x'})
    o = orphaned(
        '[c]      ready',
        sleep('a', node_name='/demo/a', name='sleep-1'),
        sh('b', 'setsid sleep 99 & sleep 99', **QUICK),
        parameters,
        sh('d', 'exit 0'),
    )
    path = Path(o.one.screen.partition('ready ')[2].split('\n')[0])
    launch = o.found()
    state = launch.refresh()
    assert (state.title, state.folder) == ('my_pkg demo.yaml', '/ws')
    assert (state.pid, state.stopping) == (o.one.popen.pid, False)
    pids = {e['label']: e['pid'] for e in o.one.events('started')}
    listed = {p.label: (p.phase, p.pid) for p in state.processes}
    assert listed == {n: ('running', pids[n]) for n in ('a', 'b', 'c')}
    a = state.processes[0]
    assert (a.name, a.node) == ('sleep-1', '/demo/a')
    assert a.log == str(o.one.log_folder / 'a-1/stdout_stderr.log')
    launch.do(commands.Stop('b'))

    def phases():
        return [p.phase for p in launch.refresh().processes]

    wait_until(lambda: phases() == ['running', 'ended', 'running'])
    assert path.exists()
    with pytest.raises(ControlError, match='launcher was killed'):
        launch.do(commands.Restart('a'))
    # another terminal knows as much
    again = o.found()
    again.do(commands.Shutdown())
    again.wait_for_end(0)
    assert o.one.processes() == []
    with pytest.raises(LaunchEndedError):
        launch.refresh()
    assert not path.parent.exists()
    assert list(o.folder.glob('*.json')) == []
    assert found(o.one) == []


def test_what_loses_its_parent_by_the_stop_is_stopped_too(
    launch, sh, wait_until, is_running
):
    # as a job in the background, it ignores SIGINT
    lost = "env -i setsid sh -c 'echo lost $$; exec sleep 99' & wait"
    environment = {'COLCON_LAUNCH_CGROUP': '0'}
    one = launch(sh('a', lost, **QUICK), about=ABOUT, environment=environment)
    one.shows('lost ')
    pid = int(one.screen.partition('lost ')[2].split()[0])
    o = Orphaned(one, wait_until)
    assert is_running(pid)
    orphan = o.found()
    orphan.do(commands.Shutdown())
    orphan.wait_for_end(0)
    assert not is_running(pid)


@needs_control_group
def test_what_their_group_alone_tells_of_is_stopped_too(
    orphaned, sh, is_running
):
    lost = 'sh -c "trap \'\' INT TERM; echo lost \\$\\$; while :; do :; done"'
    o = orphaned(
        'lost ', sh('a', f'(env -i setsid {lost} &) ; sleep 999', **QUICK)
    )
    pid = int(o.one.screen.partition('lost ')[2].split()[0])
    folder = Path(process_folder(pid)).parent
    launch = o.found()
    launch.do(commands.Shutdown())
    launch.wait_for_end(0)
    assert not is_running(pid)
    assert not folder.exists()


def test_the_mark_alone_is_enough(orphaned, sleep):
    o = orphaned('a: started', sleep('a'))
    (record,) = o.folder.glob('*.json')
    record.write_text('{"identity": [')
    launch = o.found()
    state = launch.refresh()
    assert (state.title, state.pid) == ('a launch', o.one.popen.pid)
    assert [p.label for p in state.processes] == ['sleep-1']
    # who uses other folders does not see it
    assert found(o.one, TMPDIR=str(o.folder)) == []
    launch.do(commands.Shutdown())
    launch.wait_for_end(0)
    assert o.one.processes() == []


def test_what_the_guard_stops_is_left_to_it(launch, python, wait_until):
    # a second SIGINT would end it in the middle of what it does
    script = (
        'import time\n'
        'try:\n'
        '    print("ready", flush=True); time.sleep(99)\n'
        'except KeyboardInterrupt:\n'
        '    open("begun", "w").close()\n'
        '    while not __import__("os").path.exists("go"): time.sleep(0.01)\n'
        '    open("done", "w").close()\n'
    )
    more = {'sigterm_timeout': 900.0, 'cwd': '.'}
    one = launch(python('a', script, **more), about=ABOUT).shows('ready')
    wait_until(one.guards)
    assert found(one) == []
    one.sends(signal.SIGKILL)
    one.popen.wait()
    wait_until((one.folder / 'begun').exists)
    (orphaned,) = found(one)
    orphaned.do(commands.Shutdown())
    state = orphaned.refresh()
    assert state.stopping
    assert [p.phase for p in state.processes] == ['stopping']
    (one.folder / 'go').touch()
    orphaned.wait_for_end(0)
    wait_until((one.folder / 'done').exists)
