# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Plans as scripts that run without colcon."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
import signal
import subprocess

from colcon_yamllaunch.plan.plan import (
    ChangeState,
    Component,
    Entry,
    Message,
    Plan,
    Process,
    Shutdown,
    SignalProcess,
    Timer,
)
from colcon_yamllaunch.plan.plan_script import plan_to_script
from colcon_yamllaunch.plan.position import Position
import pytest

HERE = Position('/ws/demo\n.yaml', 14, 9)
DEADLINE = 60.0
#: What takes SIGINT for a failure, and says so.
LOOP = 'echo runs; while :; do sleep 0.1; done'
UNRULY = f"trap 'echo stops; exit 3' INT; {LOOP}"


def shell(text: str, **fields: object) -> Process:
    """Return a process that runs a line of sh."""
    values = {'label': 'a', 'cwd': '/', 'position': HERE} | fields
    return Process(argv=('sh', '-c', text), **values)  # type: ignore[arg-type]


@contextmanager
def start(
    folder: Path, *entries: Entry, setup: str | None = None
) -> Iterator[subprocess.Popen[str]]:
    """Run the script of a plan, and end it."""
    script = folder / 'run.sh'
    script.write_text(plan_to_script(Plan(entries), '/ws', setup))
    with subprocess.Popen(
        ['bash', str(script)], stdout=subprocess.PIPE, text=True
    ) as started:
        try:
            yield started
        finally:
            started.send_signal(signal.SIGINT)


def test_all_of_a_plan_runs(tmp_path: Path) -> None:
    setup = tmp_path / "it's.bash"
    setup.write_text('export SOURCED=yes')
    tmp_path.joinpath('a b').mkdir()
    with start(
        tmp_path,
        Message('INFO', "it's on"),
        shell(
            'echo "$SOURCED $A; $PWD"',
            environment=(('A', 'it\'s "1"'), ('B', None)),
            cwd=str(tmp_path / 'a b'),
        ),
        Timer(0.1, (shell('echo later'), Timer(0.1, (shell('exit 3'),)))),
        shell('echo again', respawn=True, respawn_max_retries=1),
        setup=str(setup),
    ) as script:
        output, _ = script.communicate(timeout=DEADLINE)
    assert sorted(output.splitlines()) == [
        "INFO: it's on",
        *('again', 'again', 'later'),
        f'yes it\'s "1"; {tmp_path}/a b',
    ]
    # as one of them failed
    assert script.returncode == 1


@pytest.mark.parametrize(
    ('end', 'code'),
    [
        (Timer(0.1, (Shutdown('enough'),)), 0),
        (shell('exit 0', on_exit_shutdown=True), 0),
        (shell('exit 3', on_exit_shutdown=True), 1),
    ],
)
def test_shutdown_ends_all(tmp_path: Path, end: Entry, code: int) -> None:
    endless = shell('sleep 0.01', respawn=True)
    with start(tmp_path, shell('sleep 1000'), endless, end) as script:
        script.communicate(timeout=DEADLINE)
    assert script.returncode == code


def test_ctrl_c_ends_all(tmp_path: Path) -> None:
    with start(tmp_path, shell(UNRULY), shell(UNRULY)) as script:
        assert script.stdout is not None
        for _ in range(2):
            assert script.stdout.readline() == 'runs\n'
        script.send_signal(signal.SIGINT)
        output, _ = script.communicate(timeout=DEADLINE)
    assert output == 'stops\n' * 2
    assert script.returncode == 0


def test_what_ignores_sigint_is_killed(tmp_path: Path) -> None:
    deaf = shell(
        f"trap '' INT TERM; {LOOP}",
        sigterm_timeout=0.1,
        sigkill_timeout=0.1,
    )
    with start(tmp_path, deaf) as script:
        assert script.stdout is not None
        assert script.stdout.readline() == 'runs\n'
        script.send_signal(signal.SIGINT)
        script.communicate(timeout=DEADLINE)
    assert script.returncode == 0


def test_empty_plan(tmp_path: Path) -> None:
    with start(tmp_path) as script:
        assert script.wait(DEADLINE) == 0


#: A `ros2` that knows a container from its second call on, and refuses one
#: component.
ROS2 = """\
#!/bin/sh
case "$*" in
'component list /box') mkdir "$0.asked" 2> /dev/null && exit 1 ;;
*refused*) echo "refused $*"; exit 1 ;;
'lifecycle get '*) ;;
*) echo "ros2 $*" ;;
esac
exit 0
"""


@pytest.fixture
def ros2(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Make a program that stands for `ros2`."""
    program = tmp_path / 'ros2'
    program.write_text(ROS2)
    program.chmod(0o755)
    monkeypatch.setenv('PATH', str(tmp_path), prepend=':')


def component(name: str, **fields: object) -> Component:
    """Return a component for the container `/box`."""
    values = {
        'label': name or 'anonymous',
        'package': 'demo',
        'plugin': 'demo::Node',
        'container': '/box',
        'position': HERE,
        'name': name,
    } | fields
    return Component(**values)  # type: ignore[arg-type]


@pytest.mark.usefixtures('ros2')
def test_components_are_loaded_in_order(tmp_path: Path) -> None:
    with start(
        tmp_path,
        component('one', remaps=("a:=it's",)),
        component('refused'),
        component('two', is_lifecycle=True, autostart=True),
        component('', is_lifecycle=True, autostart=True),
    ) as script:
        output, _ = script.communicate(timeout=DEADLINE)
    load = 'component load /box demo demo::Node'
    assert output.splitlines() == [
        f"ros2 {load} -n one -r a:=it's",
        f'refused {load} -n refused',
        f'ros2 {load} -n two',
        'ros2 lifecycle set /two configure',
        'ros2 lifecycle set /two activate',
        f'ros2 {load}',
    ]
    assert script.returncode == 1
    text = (tmp_path / 'run.sh').read_text()
    assert '# not activated: only the program knows' in text


@pytest.mark.usefixtures('ros2')
def test_lifecycle_nodes_are_activated(tmp_path: Path) -> None:
    node = shell('true', is_lifecycle=True, node_name='/arm')
    timer = Timer(0.0, (replace(node, autostart=True),), on_ros_time=True)
    with start(tmp_path, node, timer) as script:
        output, _ = script.communicate(timeout=DEADLINE)
    assert output.splitlines() == [
        'ros2 lifecycle set /arm configure',
        'ros2 lifecycle set /arm activate',
    ]
    assert script.returncode == 0
    assert 'not those of /clock' in (tmp_path / 'run.sh').read_text()


@pytest.mark.usefixtures('ros2')
def test_transitions_are_asked_for_in_order(tmp_path: Path) -> None:
    with start(
        tmp_path,
        ChangeState('/arm', 'configure', HERE),
        SignalProcess('arm-1', 2, HERE),
        ChangeState('/arm', 'cleanup', HERE),
    ) as script:
        output, _ = script.communicate(timeout=DEADLINE)
    assert output.splitlines() == [
        'ros2 lifecycle set /arm configure',
        'ros2 lifecycle set /arm cleanup',
    ]
    text = (tmp_path / 'run.sh').read_text()
    assert ':14:9: not done, as only a launch can' in text


def test_ros2_is_needed_for_components_only(tmp_path: Path) -> None:
    plan = Plan((component('one'),))
    script = tmp_path / 'run.sh'
    script.write_text(plan_to_script(plan, '/ws'))
    ended = subprocess.run(
        ['/bin/bash', script],
        env={'PATH': str(tmp_path)},
        stderr=subprocess.PIPE,
        text=True,
        timeout=DEADLINE,
        check=False,
    )
    assert ended.stderr == 'the command ros2 is needed, and not there\n'
    assert ended.returncode == 1
    assert 'ros2' not in plan_to_script(Plan((shell('true'),)), '/ws')
