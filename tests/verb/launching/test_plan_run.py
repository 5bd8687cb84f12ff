# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The run, from a user's side."""

from collections.abc import Callable
from pathlib import Path
import signal
import time

import pytest
from support.user import built, User


def pids(output: str) -> list[int]:
    """Return the ids of the processes that were started."""
    found = (
        line.rpartition('started, pid ')[2] for line in output.splitlines()
    )
    return [int(text) for text in found if text.isdigit()]


def test_nodes_of_the_sample_talk(
    user: User, copy_sample_ws: Callable[[], Path], ros_domain_id: int
) -> None:
    pytest.importorskip('rclpy', reason='needs the ROS wheels')
    root = copy_sample_ws()
    user.environment |= {
        'ROS_DOMAIN_ID': str(ros_domain_id),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    }
    command = ['colcon', 'launch', 'my_pkg', 'demo.yaml']
    first = user.start(*command)
    first.wait_for('Received 4 which double is 8')
    assert built(first.output) == ['flow', 'my_pkg']
    assert first.interrupt() == 0, first.output
    running = [p for p in pids(first.output) if Path(f'/proc/{p}').exists()]
    assert running == []
    double = root / 'src/my_pkg/scripts/double.py'
    text = double.read_text()
    double.write_text(text.replace('which double is', 'of which two are'))
    second = user.start(*command, 'delta:=3')
    second.wait_for('Received 4 of which two are 8')
    second.wait_for('Received 7 of which two are 14')
    assert built(second.output) == []
    assert second.interrupt() == 0, second.output
    logs = root / 'log/latest_launch'
    log = logs / 'my_double-2/stdout_stderr.log'
    assert 'Received 7 of which two are 14' in log.read_text()


def test_python_package_of_the_sample(
    user: User, copy_sample_ws: Callable[[], Path], ros_domain_id: int
) -> None:
    pytest.importorskip('rclpy', reason='needs the ROS wheels')
    copy_sample_ws()
    user.environment['ROS_DOMAIN_ID'] = str(ros_domain_id)
    command = ['colcon', 'launch', 'my_py_pkg', 'square.yaml']
    launch = user.start(*command)
    launch.wait_for(r'\[square-2\] +Received')
    assert launch.interrupt() == 0, launch.output
    again = user.start(*command)
    again.wait_for(r'\[square-2\] +Received')
    assert built(again.output) == []
    assert again.interrupt() == 0, again.output


def test_flow_of_the_sample_needs_no_ros(
    user: User, copy_sample_ws: Callable[[], Path]
) -> None:
    root = copy_sample_ws()
    build = user.start('colcon', 'build', '--paths', 'flow')
    assert build.end() == 0, build.output
    launch = user.start('colcon', 'launch', 'flow', 'flow.yaml', cwd=root)
    launch.wait_for('Pumped 2 l')
    assert launch.interrupt() == 0, launch.output


def test_failure_is_named_at_the_end(user: User) -> None:
    user.package(
        'one',
        'launch:\n'
        '  - executable: {cmd: echo fine}\n'
        "  - executable: {cmd: sh -c 'echo bad luck >&2; exit 3'}\n",
    )
    output = user.launch('one', 'one', code=1)
    end = '\n'.join(output.splitlines()[-5:])
    assert 'sh-2' in end
    assert 'exited with code 3' in end
    assert 'bad luck' in end
    assert 'one.yaml:3:' in end


def test_print_shows_at_once(user: User) -> None:
    code = "import time; print('now'); time.sleep(1000)"
    user.write(
        'a.yaml', f'launch: [executable: {{cmd: [python3, -c, "{code}"]}}]'
    )
    launch = user.start('colcon', 'launch', 'a.yaml')
    launch.wait_for(r'\[python3-1\] now')
    assert launch.interrupt() == 0, launch.output


def test_ctrl_c_stops_everything(user: User) -> None:
    user.write(
        'a.yaml',
        'launch:\n'
        '  - executable: {cmd: sleep 1000}\n'
        "  - executable: {cmd: sh -c 'sleep 1001; true'}\n"
        '  - executable: {cmd: echo ready}\n',
    )
    launch = user.start('colcon', 'launch', 'a.yaml')
    launch.wait_for(r'\] +ready')
    assert launch.interrupt() == 0, launch.output
    started = pids(launch.output)
    assert len(started) == 3
    assert [p for p in started if Path(f'/proc/{p}').exists()] == []


def test_ctrl_c_in_the_last_moment_leaves_the_exit_code(user: User) -> None:
    user.write('a.yaml', "launch: [executable: {cmd: sleep '1000'}]")
    launch = user.start('colcon', 'launch', 'a.yaml')
    launch.wait_for('started')
    while launch.process.poll() is None:
        launch.process.send_signal(signal.SIGINT)
        time.sleep(0.01)
    assert launch.end() == 0, launch.output


def test_a_refused_parameter_is_named_with_its_place(user: User) -> None:
    user.write('p.yaml', '/**:\n  ros__parameters:\n    rate: 1\n')
    user.write(
        'refuse.sh',
        "echo \"  what():  parameter 'rate' has invalid type: "
        'expected [double] got [integer]"; exit 1',
    )
    user.write(
        'a.yaml',
        'launch: [executable: {cmd: sh refuse.sh --params-file p.yaml}]',
    )
    output = user.launch('a.yaml', code=1)
    assert (
        "the node takes a double for 'rate': give it 1.0 instead of 1, at "
        'p.yaml:3:5\n'
    ) in output
