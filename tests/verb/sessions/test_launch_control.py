# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Running launches, from a user's second terminal."""

from collections.abc import Callable
import json
import os
from pathlib import Path
import re
import signal
import time

import pytest
from support.terminal import Terminal
from support.user import Launch, User

TICKING = """\
launch:
  - executable: {cmd: sleep 1000}
  - executable:
      cmd: sh -c 'echo first; while sleep 0.1; do echo tick; done'
  - executable:
      cmd: cat -v
      emulate_tty: true
"""


@pytest.fixture
def second(second: User) -> User:
    """Return a user with something to launch, who sees no other launches."""
    second.write('ticking.yaml', TICKING)
    return second


def begin(user: User, *words: str) -> Launch:
    launch = user.start('colcon', 'launch', *(words or ('ticking.yaml',)))
    launch.wait_for(r'\] +tick')
    return launch


def status(user: User) -> dict[str, dict[str, object]]:
    (launch,) = json.loads(user.launch('--status=json'))['launches']
    return {p['label']: p for p in launch['processes']}


@pytest.mark.parametrize(
    'words', [['--status'], ['--stop'], ['--logs', 'a'], ['--restart', 'a']]
)
def test_there_is_no_launch(
    second: User, words: list[str], tmp_path: Path
) -> None:
    output = second.launch(*words, cwd=tmp_path, code=1)
    assert output == 'colcon launch: error: no launch is running\n'


def test_a_launch_is_listed_from_any_folder(
    second: User, tmp_path: Path
) -> None:
    launch = begin(second)
    elsewhere = tmp_path / 'elsewhere'
    elsewhere.mkdir()
    output = second.launch('--status', cwd=elsewhere)
    assert output.startswith('ticking.yaml: running for ')
    for label in ('sleep-1', 'sh-2', 'cat-3'):
        assert label in output
    assert list(elsewhere.iterdir()) == []
    assert launch.interrupt() == 0, launch.output


def test_looking_leaves_the_logs_of_the_launch_the_latest(
    second: User,
) -> None:
    second.package('one')
    second.write('src/one/launch/ticking.yaml', TICKING)
    launch = begin(second, 'one', 'ticking')
    latest = second.root / 'log/latest_launch'
    before = latest.resolve()
    second.launch('--status')
    second.launch('--logs', 'sh')
    assert latest.resolve() == before
    assert launch.interrupt() == 0, launch.output


def test_a_process_is_stopped_and_started_anew(second: User) -> None:
    launch = begin(second)
    before = status(second)
    output = second.launch('--stop', 'sle*')
    assert 'sleep-1: stopped' in output
    assert status(second)['sleep-1']['phase'] == 'ended'
    output = second.launch('--restart', 'sleep')
    now = status(second)
    assert f'sleep-1: started anew, pid {now["sleep-1"]["pid"]}' in output
    assert now['sleep-1']['restarts'] == 1
    assert now['sh-2']['pid'] == before['sh-2']['pid']
    assert launch.interrupt() == 0, launch.output


def test_a_node_is_known_by_all_of_its_names(second: User) -> None:
    second.write(
        'a.yaml',
        'launch:\n'
        '  - node: {exec: sh, args: t.sh, name: kitchen}\n'
        '  - node: {exec: sh, args: t.sh, name: camera, namespace: left}\n'
        '  - node: {exec: sh, args: t.sh, name: camera, namespace: right}\n',
    )
    second.write('t.sh', 'echo tick; exec sleep 99')
    launch = begin(second, 'a.yaml')
    launch.wait_for(r'\[left/camera\]  tick')
    known = {label: p['name'] for label, p in status(second).items()}
    assert known == {
        'kitchen': 'sh-1',
        'left/camera': 'sh-2',
        'right/camera': 'sh-3',
    }
    output = second.launch('--logs', '/left/camera')
    assert output == 'tick\n'
    output = second.launch('--stop', 'sh-1', 'right/camera')
    assert output == 'kitchen: stopped\nright/camera: stopped\n'
    output = second.launch('--restart', 'kichen', code=1)
    assert "has no process 'kichen': did you mean 'kitchen'?" in output
    assert launch.interrupt() == 0, launch.output


def test_a_restart_that_fails_is_told(second: User, tmp_path: Path) -> None:
    program = second.write('program', '#!/bin/sh\necho tick\nsleep 99', 0o755)
    second.write(
        'a.yaml',
        'launch:\n'
        f'  - executable: {{cmd: {program}}}\n'
        '  - executable: {cmd: sleep 1000}\n',
    )
    launch = begin(second, 'a.yaml')
    program.unlink()
    output = second.launch('--restart', 'program', code=1)
    assert 'program-1: could not be started: there is no file' in output
    assert launch.interrupt() == 1


def test_the_whole_launch_is_stopped(second: User) -> None:
    launch = begin(second)
    output = second.launch('--stop')
    assert 'stopped ticking.yaml' in output
    assert launch.process.poll() == 0, launch.output


def test_of_several_launches_one_is_chosen(second: User) -> None:
    first = begin(second)
    second.write('other.yaml', TICKING.replace('sleep 1000', 'tail -f'))
    other = begin(second, 'other.yaml')
    output = second.launch('--stop', code=1)
    assert 'more than one launch is running' in output
    assert 'ticking.yaml (pid ' in output
    assert 'other.yaml (pid ' in output
    assert second.launch('--status').count('running for') == 2
    # only one of them has such a process
    assert 'tail-1: stopped' in second.launch('--stop', 'tail')
    assert 'more than one' in second.launch('--stop', 'sh', code=1)
    nothing = second.launch('--stop', '--of', 'nothing', code=1)
    assert "no running launch is 'nothing'" in nothing
    second.launch('--stop', '--of', 'other.yaml')
    assert other.process.poll() == 0
    second.launch('--stop', '--of', str(first.process.pid))
    assert first.process.poll() == 0


def test_all_launches_are_stopped_at_once(second: User) -> None:
    first, other = begin(second), begin(second)
    output = second.launch('--stop', 'sleep', '--of', '*')
    assert output.count('sleep-1: stopped') == 2
    unknown = second.launch('--stop', 'slep', '--of', '*', code=1)
    assert "did you mean 'sleep'?" in unknown
    output = second.launch('--stop', '--of', '*')
    assert output.count('stopped ticking.yaml') == 2
    assert (first.process.poll(), other.process.poll()) == (0, 0)


def test_an_unknown_process_names_the_nearest(second: User) -> None:
    launch = begin(second)
    output = second.launch('--stop', 'slep', code=1)
    assert "no process 'slep': did you mean 'sleep'?" in output
    assert launch.interrupt() == 0


def test_logs_are_shown(second: User) -> None:
    launch = begin(second)
    lines = second.launch('--logs', 'sh').splitlines()
    assert lines[:2] == ['first', 'tick']
    lines = second.launch('--logs', 's*').splitlines()
    assert lines[0] == '[sh-2] first'
    assert launch.interrupt() == 0


def test_logs_are_followed_to_the_end_of_the_launch(second: User) -> None:
    launch = begin(second)
    logs = second.start('colcon', 'launch', '--logs', '-f', 'sh')
    logs.wait_for('(?s)tick.*tick.*tick')
    assert launch.interrupt() == 0
    assert logs.end() == 0


def test_a_follower_ends_with_ctrl_c(second: User) -> None:
    launch = begin(second)
    logs = second.start('colcon', 'launch', '--logs', '-f', 'sh')
    logs.wait_for('tick')
    assert logs.interrupt() == 130
    assert 'Traceback' not in logs.output
    assert launch.process.poll() is None
    assert launch.interrupt() == 0


def test_a_launch_without_logs_says_so(second: User) -> None:
    launch = second.start(
        *('colcon', '--log-base', '/dev/null', 'launch', 'ticking.yaml')
    )
    launch.wait_for('tick')
    output = second.launch('--logs', 'sh', code=1)
    assert 'ticking.yaml writes no logs' in output
    assert launch.interrupt() == 0


def test_a_killed_launch_is_not_listed(second: User) -> None:
    launch = begin(second)
    launch.process.send_signal(signal.SIGKILL)
    launch.process.wait()
    output = second.launch('--status', code=1)
    assert 'no launch is running' in output
    sockets = Path(second.environment['XDG_RUNTIME_DIR'], 'colcon-launch')
    assert list(sockets.iterdir()) == []


def test_a_second_terminal_attaches_and_detaches(
    second: User, terminal: Callable[..., Terminal]
) -> None:
    launch = begin(second)
    t = terminal('--attach', 'cat').shows('Ctrl-] detaches')
    t.types('hi \x1b[A\r').shows('hi ^[[A\r\n', times=1)
    t.types('\x1d').shows('cat-3: detached')
    assert t.ends() == 0
    assert t.modes() == t.modes_before
    launch.wait_for(r'\[cat-3\] +hi \^\[\[A')
    assert launch.interrupt() == 0


@pytest.mark.parametrize('ending', ['ctrl-c', 'process', 'launch', 'SIGTERM'])
def test_the_second_terminal_is_restored(
    second: User, terminal: Callable[..., Terminal], ending: str
) -> None:
    launch = begin(second)
    t = terminal('--attach', 'cat').shows('Ctrl-] detaches')
    if ending == 'ctrl-c':
        t.types('\x03')
    elif ending == 'process':
        t.types('\x04').shows('cat-3: finished')
    elif ending == 'SIGTERM':
        t.process.terminate()
    else:
        launch.interrupt()
    assert t.ends() == 0
    assert t.modes() == t.modes_before
    assert launch.process.poll() == (0 if ending == 'launch' else None)
    if ending != 'launch':
        assert launch.interrupt() == 0


def test_ctrl_z_suspends_the_second_terminal_only(
    second: User, terminal: Callable[..., Terminal]
) -> None:
    launch = begin(second)
    t = terminal('--attach', 'cat').shows('Ctrl-] detaches')
    t.types('before\r').shows('before', times=2).types('\x1a')
    while _state(t.process.pid) != 'T':
        time.sleep(0.01)
    assert t.modes() == t.modes_before
    assert status(second)['cat-3']['phase'] == 'running'
    t.process.send_signal(signal.SIGCONT)
    t.types('after\r').shows('after', times=2).types('\x1d')
    assert t.ends() == 0
    assert launch.interrupt() == 0


def test_what_cannot_be_attached_to(
    second: User, terminal: Callable[..., Terminal]
) -> None:
    launch = begin(second)
    output = second.launch('--attach', 'cat', code=1)
    assert 'standard input is no terminal' in output
    assert 'no terminal' in second.launch('--attach', 'a', 'b', 'c', code=1)
    t = terminal('--attach', 'sh')
    assert t.ends() == 1
    assert 'start the launch with --attach sh-2' in t.screen.replace(
        '\r\n', ''
    )
    t = terminal('--attach', 's*')
    assert t.ends() == 1
    assert 'takes one process, not sh-2, sleep-1' in t.screen
    assert launch.interrupt() == 0


@pytest.mark.parametrize(
    ('words', 'hint'),
    [([], 'Ctrl-] goes back'), (['--no-status'], 'Ctrl-] detaches')],
)
def test_a_launch_with_the_keyboard_at_a_process(
    second: User,
    terminal: Callable[..., Terminal],
    words: list[str],
    hint: str,
) -> None:
    second.write('one.yaml', 'launch: [executable: {cmd: cat -v}]')
    t = terminal('--attach', 'c?t', 'one.yaml', *words).shows(hint)
    t.types('héllo\r').shows('hM-CM-)llo').types('\x04')
    assert t.ends() == 0
    assert t.modes() == t.modes_before


def test_a_launch_has_no_process_to_have_the_keyboard(
    second: User, terminal: Callable[..., Terminal]
) -> None:
    second.write('one.yaml', 'launch: [executable: {cmd: cat -v}]')
    t = terminal('--attach', 'dog', 'one.yaml')
    assert t.ends() == 1
    assert "there is no process 'dog'; there is cat-1" in t.screen


def test_a_stubborn_process_is_waited_for(second: User) -> None:
    second.write(
        'a.yaml',
        'launch:\n'
        '  - executable:\n'
        '      cmd: sh -c \'trap "" INT; echo tick; sleep 99; sleep 99\'\n'
        "      sigterm_timeout: '1.5'\n"
        '  - executable: {cmd: sleep 1000}\n',
    )
    launch = begin(second, 'a.yaml')
    output = second.launch('--stop', 'sh')
    assert output == 'waiting for sh-1\nsh-1: stopped\n'
    assert launch.interrupt() == 0


def test_a_launch_that_is_suspended_does_not_answer(second: User) -> None:
    launch = begin(second)
    launch.process.send_signal(signal.SIGSTOP)
    output = second.launch('--status', code=1)
    assert f'pid {launch.process.pid} does not answer' in output
    assert 'error: no launch answers' in output
    launch.process.send_signal(signal.SIGCONT)
    assert launch.interrupt() == 0


def test_the_keyboard_drives_a_node_of_the_sample(
    second: User,
    copy_sample_ws: Callable[[], Path],
    terminal: Callable[..., Terminal],
    ros_domain_id: int,
) -> None:
    pytest.importorskip('rclpy', reason='needs the ROS wheels')
    (second.root / 'ticking.yaml').unlink()
    copy_sample_ws()
    second.environment['ROS_DOMAIN_ID'] = str(ros_domain_id)
    first = terminal('--attach', 'throttle', 'my_pkg', 'throttle.yaml')
    first.shows('up or + for more').types('\x1b[A++\x1b[B')
    for value in (10, 20, 30, 20):
        first.shows(f'Throttle at {value} %')
    first.types('\x1d').shows('throttle: detached')
    again = terminal('--attach', 'throttle').shows('Ctrl-] detaches')
    again.types('0').shows('Throttle at 0 %').types('q')
    assert again.ends() == 0
    assert again.modes() == again.modes_before
    assert first.ends() == 0
    assert first.modes() == first.modes_before


def test_prefix_options(second: User) -> None:
    second.write(
        'two.yaml',
        'launch:\n'
        '  - executable: {cmd: echo one}\n'
        '  - executable: {cmd: printf two}\n',
    )
    output = second.launch('--launch-prefix', 'echo with', 'two.yaml')
    assert 'with echo one' in output
    assert 'with printf two' in output
    output = second.launch(
        *('two.yaml', '--launch-prefix', 'echo with'),
        *('--launch-prefix-filter', 'pri', 'launch-prefix:=nothing'),
    )
    assert 'with echo one' not in output
    assert 'with printf two' in output


def _state(pid: int) -> str:
    stat = Path(f'/proc/{pid}/stat').read_text()
    return stat.rpartition(') ')[2][0]


@pytest.mark.hostile
def test_what_lost_its_launcher_is_listed_and_stopped(second: User) -> None:
    second.write('ticking.yaml', TICKING + TICKING.partition('\n')[2])
    launch = begin(second)
    pid = launch.process.pid
    guard = next(
        int(path.parent.name)
        for path in Path('/proc').glob('[0-9]*/stat')
        if path.read_text().rpartition(') ')[2].split()[1] == str(pid)
        and b'GUARD=' in (path.parent / 'environ').read_bytes()
    )
    # the launcher would start another guard
    for number, target in (
        (signal.SIGSTOP, pid),
        (signal.SIGKILL, guard),
        (signal.SIGKILL, pid),
    ):
        os.kill(target, number)
    launch.process.wait()
    output = second.launch('--status', code=1)
    assert output.count('was killed') == 1, output
    assert output.startswith(f'ticking.yaml: launcher {pid} was killed, these')
    assert re.search(r'^  sleep-1 +running +\d+', output, re.M)
    (state,) = json.loads(second.launch('--status=json', code=1))['launches']
    assert state['orphaned']
    output = second.launch('--restart', 'sleep', code=1)
    assert 'error: ticking.yaml: its launcher was killed; all that' in output
    assert 'sleep-1: stopped' in second.launch('--stop', 'sleep-1')
    assert 'stopped ticking.yaml' in second.launch('--stop')
    output = second.launch('--status', code=1)
    assert output == 'colcon launch: error: no launch is running\n'
