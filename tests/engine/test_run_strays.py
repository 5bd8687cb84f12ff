# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Real launches that lose sight of what they started."""

import json
import os
from pathlib import Path
import re
import shutil
import signal
import subprocess
import sys

import colcon_yamllaunch
from colcon_yamllaunch.control.client import running_launches
from colcon_yamllaunch.engine.commands import Stop
import pytest

pytestmark = pytest.mark.hostile

LAUNCHER = Path(__file__).parents[1] / 'support/launcher.py'
ROOT = Path(colcon_yamllaunch.__file__).parents[1]
#: Seconds after which something will not happen any more.
DEADLINE = 60
ABOUT = dict.fromkeys(('title', 'package', 'file', 'folder'), 'x')
#: Leaves its group, its session and its environment.
STRAY = "env -i setsid sh -c 'echo stray $$; exec sleep 99' & "
#: The same, without an output; its parent ends before it says who it is.
HIDDEN = (
    'import os, sys, time\n'
    'if os.fork():\n'
    '    os.wait()\n'
    '    time.sleep(99 if len(sys.argv) > 1 else 0)\n'
    '    sys.exit()\n'
    'middle = os.getpid()\n'
    'if os.fork(): os._exit(0)\n'
    'while os.getppid() == middle: time.sleep(0.01)\n'
    'os.setsid()\n'
    'null = os.open("/dev/null", os.O_RDWR)\n'
    'for n in range(3): os.dup2(null, n)\n'
    'with open("new", "w") as f: f.write(f"{os.getpid()}")\n'
    'os.rename("new", "note")\n'
    f'os.execve({shutil.which("sleep")!r}, ["sleep", "99"], {{}})\n'
)
NO_CGROUP = {'COLCON_LAUNCH_CGROUP': '0'}
QUICK = {'sigterm_timeout': 0.2, 'sigkill_timeout': 0.2}


@pytest.fixture
def launch(launch):
    """Return what starts a launcher that has no control group to help it."""

    def start(*entries, environment=None, **settings):
        environment = {**NO_CGROUP, **(environment or {})}
        return launch(*entries, environment=environment, **settings)

    return start


def children(pid: int) -> set[int]:
    text = Path(f'/proc/{pid}/task/{pid}/children').read_text()
    return set(map(int, text.split()))


def hidden_of(one, wait_until) -> int:
    """Return a stray of HIDDEN, as soon as nothing tells whose it is."""
    wait_until((one.folder / 'note').exists)
    pid = int((one.folder / 'note').read_text())
    environment = Path(f'/proc/{pid}/environ')
    wait_until(lambda: b'LAUNCH' not in environment.read_bytes())
    return pid


@pytest.fixture
def hidden(python):
    """Return a function that describes a process with a hidden stray."""

    def describe(label: str, *arguments: str) -> dict:
        described = python(label, HIDDEN, cwd='.', **QUICK)
        described['argv'].extend(arguments)
        return described

    return describe


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_what_leaves_group_session_and_environment_is_stopped(
    launch, sh, is_running, number
):
    one = launch(sh('a', STRAY + 'wait', **QUICK)).shows('stray ')
    stray = int(one.screen.partition('stray ')[2].split()[0])
    assert one.sends(number).ends() == 0
    assert not is_running(stray)
    # it is told whose it was
    assert {e['label'] for e in one.events('signalled')} == {'a'}


def test_a_stray_is_stopped_with_its_process_and_no_other(
    launch, sh, is_running, wait_until
):
    one = launch(
        sh('a', STRAY + 'wait', **QUICK),
        sh('b', STRAY + 'wait', **QUICK),
        about=ABOUT,
    )
    one.shows('[a]      stray ').shows('[b]      stray ')
    found = re.findall(r'\[(.)\] +stray (\d+)', one.screen)
    strays = {label: int(pid) for label, pid in found}
    # apart from other launches of the user
    place = dict.fromkeys(('TMPDIR', 'XDG_RUNTIME_DIR'), str(one.folder))
    (client,) = wait_until(lambda: running_launches(place, pytest.fail))
    client.do(Stop('a'))
    wait_until(lambda: not is_running(strays['a']))
    assert is_running(strays['b'])
    client.close()
    assert one.sends(signal.SIGINT).ends() == 0
    assert not is_running(strays['b'])


def test_a_stray_without_a_trace_ends_with_the_launch(
    launch, hidden, sleep, is_running, wait_until
):
    one = launch(hidden('a'), sleep('b')).shows('a: finished')
    stray = hidden_of(one, wait_until)
    assert one.sends(signal.SIGINT).ends() == 0
    assert not is_running(stray)
    assert f'SIGINT to what it left running, pid {stray}' in one.screen


def test_strays_that_end_are_reaped(launch, sh, wait_until):
    script = '(env -i true &); (env -i true &); echo done; exec sleep 99'
    one = launch(sh('a', script)).shows('[a]      done')
    (guard,) = wait_until(one.guards)
    ours = {one.events('started')[0]['pid'], guard}
    wait_until(lambda: children(one.popen.pid) == ours)
    assert one.sends(signal.SIGINT).ends() == 0


def test_children_from_before_and_theirs_go_on(
    launch, sleep, is_running, wait_until
):
    # as a shell leaves them that becomes the launcher by exec
    script = (
        'while ! test -e go; do sleep 0.02; done; '
        '(sleep 98 & echo $! >new); mv new foreign; exec sleep 98'
    )

    def begin():
        environment = {'PATH': os.environ['PATH']}
        os.posix_spawnp('sh', ['sh', '-c', script], environment)

    one = launch(sleep('a'), popen={'preexec_fn': begin}).shows('a: started')
    pid = one.events('started')[0]['pid']
    (guard,) = wait_until(one.guards)
    (child,) = children(one.popen.pid) - {pid, guard}
    (one.folder / 'go').touch()
    wait_until((one.folder / 'foreign').exists)
    foreign = [child, int((one.folder / 'foreign').read_text())]
    assert set(foreign) <= children(one.popen.pid)
    assert one.sends(signal.SIGINT).ends() == 0
    alive = [n for n in foreign if is_running(n)]
    for n in alive:
        os.kill(n, signal.SIGKILL)
    assert alive == foreign


def test_the_guard_stops_strays(launch, sh, hidden, is_running, wait_until):
    one = launch(
        sh('seen', STRAY + 'wait', **QUICK),
        # by the pipe that it writes to
        sh('orphan', STRAY + 'exit 0', **QUICK),
        # by what the launcher has told
        hidden('hidden', 'stay'),
        sh('end', 'while ! test -e go; do sleep 0.02; done', cwd='.'),
    )
    one.shows('[seen]   stray ').shows('[orphan] stray ')
    one.shows('orphan: finished')
    strays = [int(n) for n in re.findall(r'stray (\d+)', one.screen)]
    strays.append(hidden_of(one, wait_until))
    # then the launcher looks whom it has adopted
    (one.folder / 'go').touch()
    one.shows('end: finished')
    (guard,) = wait_until(one.guards)
    one.sends(signal.SIGKILL)
    one.popen.wait()
    wait_until(lambda: not is_running(guard))
    left = [pid for pid in strays if is_running(pid)]
    for pid in left:
        os.kill(pid, signal.SIGKILL)
    assert left == []


def test_process_1_of_a_container_stops_and_reaps_everything(tmp_path, sh):
    if os.getuid() != 0:
        pytest.skip('a namespace for processes needs root')
    zombies = "grep -q '^State:.Z' /proc/[0-9]*/status"
    entries = [
        sh('a', '(env -i true &); ' + STRAY + 'wait', **QUICK),
        # what nobody reaps stays a zombie for ever
        sh('b', f'while {zombies}; do :; done; kill -TERM 1; sleep 99'),
    ]
    plan = tmp_path / 'plan.json'
    plan.write_text(json.dumps({'entries': entries}))
    argv = ['unshare', '--pid', '--fork', '--mount-proc', sys.executable, '-S']
    paths = {'PYTHONPATH': str(ROOT), 'TMPDIR': str(tmp_path)}
    ended = subprocess.run(
        [*argv, str(LAUNCHER), str(plan)],
        env={'PATH': os.environ['PATH'], **paths, **NO_CGROUP},
        capture_output=True,
        text=True,
        timeout=DEADLINE,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    assert 'stopping: SIGTERM received' in ended.stdout
