# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The nodes of sample_ws, started by hand from the sourced workspace."""

from pathlib import Path
import re
import signal

import pytest
from support.ros_talk import talking

from .conftest import Environment
from .conftest import Start
from .conftest import Workspace

# One build serves all tests here when they run on one worker.
pytestmark = [pytest.mark.full, pytest.mark.xdist_group('sample_ws')]

COUNTER = 'install/my_pkg/lib/my_pkg/counter.py'
DOUBLE = 'install/my_pkg/lib/my_pkg/double.py'
GAUGE = 'install/my_pkg/lib/my_pkg/gauge.py'
SQUARE = 'install/my_py_pkg/lib/my_py_pkg/square'
#: Only the last ten numbers are kept, and a loaded machine is slow.
DOUBLED = r'Received \d+ which double is \d+'


def test_messages_cross_until_signals_end_the_nodes(
    workspace: Workspace, ros_environment: Environment, start: Start
) -> None:
    double = start(ros_environment, workspace.root / DOUBLE)
    counter = start(ros_environment, workspace.root / COUNTER)
    double.wait_for('Received 1 which double is 2')
    double.wait_for('Received 4 which double is 8')
    assert counter.stop(signal.SIGINT) == 0
    assert double.stop(signal.SIGTERM) == 0
    assert 'Publishing 4' in counter.lines
    assert 'Traceback' not in '\n'.join(counter.lines + double.lines)


def test_late_listener_hears_what_was_sent_before(
    workspace: Workspace, ros_environment: Environment, start: Start
) -> None:
    counter = start(ros_environment, workspace.root / COUNTER)
    counter.wait_for('Publishing 2')
    double = start(ros_environment, workspace.root / DOUBLE)
    double.wait_for('Received 1 which double is 2')
    assert counter.stop(signal.SIGTERM) == 0
    assert double.stop(signal.SIGINT) == 0


def test_parameters_are_read_and_the_count_wraps(
    workspace: Workspace, ros_environment: Environment, start: Start
) -> None:
    counter = start(
        ros_environment,
        workspace.root / COUNTER,
        '--ros-args',
        *('--params-file', workspace.root / 'src/my_pkg/config/counter.yaml'),
        *('-p', 'my_array:=[1.0, 2.0]'),
        *('-p', 'delta:=65534'),
    )
    counter.wait_for('Publishing 65533')
    assert counter.stop(signal.SIGINT) == 0
    assert counter.lines[:6] == [
        'my_int: 7',
        'my_array: [1.0, 2.0]',
        'delta: 65534',
        'Publishing 1',
        'Publishing 65535',
        'Publishing 65533',
    ]


def test_parameter_of_another_type_is_one_clear_line(
    workspace: Workspace, ros_environment: Environment, start: Start
) -> None:
    argv = (workspace.root / COUNTER, '--ros-args', '-p', 'delta:=0.5')
    counter = start(ros_environment, *argv)
    assert counter.end() == 1
    [line] = counter.lines
    assert line.startswith("counter: Trying to set parameter 'delta'")


def test_double_reads_its_own_arguments(
    workspace: Workspace,
    ros_environment: Environment,
    start: Start,
    tmp_path: Path,
) -> None:
    text = tmp_path / 'text.txt'
    text.write_text('Hello\n')
    argv = (workspace.root / DOUBLE, '-d', text, '--ros-args')
    double = start(ros_environment, *argv, '-r', '__node:=other')
    double.wait_for('Hello')
    counter = start(ros_environment, workspace.root / COUNTER)
    double.wait_for_match(DOUBLED)
    assert counter.stop(signal.SIGINT) == 0
    assert double.stop(signal.SIGINT) == 0


def test_double_says_that_its_file_is_missing(
    workspace: Workspace, ros_environment: Environment, start: Start
) -> None:
    argv = (workspace.root / DOUBLE, '-d', workspace.root / 'no.txt')
    double = start(ros_environment, *argv)
    assert double.end() == 1
    [line] = double.lines
    assert line.startswith('double: ')
    assert 'no.txt' in line


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_signal_right_behind_a_message_is_a_clean_end(
    workspace: Workspace,
    ros_environment: Environment,
    start: Start,
    number: signal.Signals,
) -> None:
    counter = start(ros_environment, workspace.root / COUNTER)
    doubles = [
        start(ros_environment, workspace.root / DOUBLE) for _ in range(3)
    ]
    for double in doubles:
        double.wait_for_match(DOUBLED)
        assert double.stop(number) == 0, double.lines
    counter.wait_for('Publishing 2')
    assert counter.stop(number) == 0, counter.lines


def test_entry_point_hears_the_counter_through_a_remapping(
    workspace: Workspace, ros_environment: Environment, start: Start
) -> None:
    argv = (workspace.root / SQUARE, '--ros-args', '-r', 'number:=count')
    square = start(ros_environment, *argv)
    counter = start(ros_environment, workspace.root / COUNTER)
    # nothing is kept for it, and the first numbers may come too early
    square.wait_for_match(r'Received \d+ whose square is \d+')
    number, result = map(int, re.findall(r'\d+', square.lines[-1]))
    assert result == number**2 > 0
    assert square.stop(signal.SIGTERM) == 0
    assert counter.stop(signal.SIGTERM) == 0


@pytest.mark.parametrize(
    ('installed', 'source'),
    [
        (COUNTER, 'src/my_pkg/scripts/counter.py'),
        (
            'install/my_pkg/share/my_pkg/launch/demo.yaml',
            'src/my_pkg/launch/demo.yaml',
        ),
        (
            'install/my_pkg/share/my_pkg/config/counter.yaml',
            'src/my_pkg/config/counter.yaml',
        ),
        (
            'install/my_py_pkg/share/my_py_pkg/launch/square.yaml',
            'src/my_py_pkg/launch/square.yaml',
        ),
    ],
)
def test_installed_files_are_links_to_the_sources(
    workspace: Workspace, installed: str, source: str
) -> None:
    assert (workspace.root / installed).samefile(workspace.root / source)


def test_gauge_measures_only_while_it_is_active(
    workspace: Workspace, ros_environment: Environment, start: Start
) -> None:
    def change(transition: str) -> bool:
        node = {'node': '/gauge', 'transition': transition}
        return talk.result('change_state', **node)['ok']

    with talking(ros_environment, ('rclpy', 'lifecycle_msgs')) as talk:
        argv = (workspace.root / GAUGE, '--ros-args', '-p', 'period:=0.01')
        gauge = start(ros_environment, *argv)
        assert not change('activate')
        assert change('configure')
        gauge.wait_for('Configured for a measurement every 0.01 s')
        assert change('activate')
        gauge.wait_for('Measured 2')
        assert change('deactivate')
        assert change('cleanup')
        gauge.wait_for('Cleaned up')
        assert gauge.stop(signal.SIGINT) == 0
    assert gauge.lines.index('Activated') < gauge.lines.index('Measured 1')
    assert gauge.lines[-2:] == ['Deactivated', 'Cleaned up']


def test_gauge_refuses_a_period_that_is_none(
    workspace: Workspace, ros_environment: Environment, start: Start
) -> None:
    with talking(ros_environment, ('rclpy', 'lifecycle_msgs')) as talk:
        argv = (workspace.root / GAUGE, '--ros-args', '-p', 'period:=0.0')
        gauge = start(ros_environment, *argv)
        assert talk.result(
            'change_state', node='/gauge', transition='configure'
        ) == {
            'ok': False,
            'reason': "'configure' failed, the node is 'unconfigured'",
        }
        gauge.wait_for('The period is 0.0 s, which is none')
        assert gauge.stop(signal.SIGTERM) == 0
