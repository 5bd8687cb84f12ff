# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What CI runs, and what docs/ci.md tells others to run, works."""

from collections.abc import Callable
from pathlib import Path
import re

import pytest
from support.user import User
import yaml

ROOT = Path(__file__).parents[2]


@pytest.fixture
def workspace(
    user: User, copy_sample_ws: Callable[[], Path], ros_domain_id: int
) -> User:
    """Return a user with the sample workspace and the ROS wheels."""
    pytest.importorskip('rclpy', reason='needs the ROS wheels')
    copy_sample_ws()
    user.environment |= {
        'ROS_DOMAIN_ID': str(ros_domain_id),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    }
    return user


def blocks(language: str) -> list[str]:
    text = (ROOT / 'docs/ci.md').read_text(encoding='utf-8')
    return re.findall(rf'^```{language}\n(.*?)^```$', text, re.M | re.S)


def run(user: User, *command: str) -> None:
    launch = user.start(*command)
    assert launch.end() == 0, launch.output


def test_the_plain_example(workspace: User) -> None:
    (script,) = blocks('bash')
    assert script.count('colcon launch') == 4
    run(workspace, 'bash', '-c', script)
    reports = workspace.root / 'reports'
    names = sorted(path.name for path in reports.iterdir())
    assert names == ['my_pkg.xml', 'my_py_pkg.xml']


def test_the_example_for_github(workspace: User) -> None:
    # the other one is a piece of such a file
    (text,) = [text for text in blocks('yaml') if 'jobs:' in text]
    steps = yaml.safe_load(text)['jobs']['launch']['steps']
    scripts = [step['run'] for step in steps if 'run' in step]
    workspace.environment |= {
        'GITHUB_ACTIONS': 'true',
        'GITHUB_WORKSPACE': str(workspace.root),
    }
    assert scripts[0].startswith('pip install')
    for script in scripts[1:]:
        run(workspace, 'bash', '-e', '-c', script)
    assert (workspace.root / 'reports/my_pkg.xml').exists()


def test_the_script_of_our_own_ci(workspace: User) -> None:
    run(workspace, 'bash', str(ROOT / '.ci/launch_sample_ws'))
    reports = sorted((workspace.root / 'log/reports').iterdir())
    assert [report.stem for report in reports] == [
        'demo',
        'flow',
        'gauge',
        'square',
    ]
    for report in reports:
        assert 'failures="0" errors="0"' in report.read_text()
