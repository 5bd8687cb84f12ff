# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files in Python give the same processes as with `ros2 launch`."""

from pathlib import Path

import pytest
from support.ros_setup import RosSetup

from tests.python_launch.comparison import differences, FILES, Launches

#: The launch files, each with the arguments of its launches.
CASES = {
    'conditions.launch.py': ['', 'use:=false robot:=large'],
    'containers.launch.py': [''],
    'exits.launch.py': [''],
    'extras.launch.py': [''],
    'extras.launch.xml': [''],
    'extras.launch.yaml': ['word:=loud'],
    'frontends.launch.py': ['side:=all'],
    'functions.launch.py': ['count:=3'],
    'groups.launch.py': ['a:=given'],
    'includes.launch.py': ['side:=right'],
    'lifecycle.launch.py': [''],
    'mixed.launch.yaml': ['robot:=digger'],
    'nodes.launch.py': [''],
    'output_handlers.launch.py': [''],
    'outputs.launch.py': [''],
    'parameters.launch.py': [''],
    'prints.launch.py': [''],
    'processes.launch.py': ['', 'emulate_tty:=true'],
    'reaching.launch.py': [''],
    'respawn.launch.py': [''],
    'scope.launch.py': ['rate:=12.5'],
    'shutdowns.launch.py': [''],
    'signals.launch.py': [''],
    'substitutions.launch.py': ['side:=right'],
    'timers.launch.py': [''],
}
#: Those that use what Humble does not have: `LifecycleTransition`,
#: `respawn_max_retries`, `EqualsSubstitution`.
NEWER_THAN_HUMBLE = {
    'lifecycle.launch.py',
    'respawn.launch.py',
    'substitutions.launch.py',
}
LAUNCHES = [(name, words) for name, all_ in CASES.items() for words in all_]


@pytest.fixture
def launches(
    ros_setup: RosSetup, ros_domain_id: int, tmp_path: Path
) -> Launches:
    environment = {
        **ros_setup.environment,
        'ROS_DOMAIN_ID': str(ros_domain_id),
    }
    return Launches(tmp_path, environment, ros_setup.python)


def test_that_each_file_is_launched() -> None:
    files = [path.name for path in FILES.iterdir() if path.is_file()]
    assert sorted(files) == sorted(CASES)


@pytest.mark.parametrize(('name', 'words'), LAUNCHES)
def test_same_processes(name: str, words: str, launches: Launches) -> None:
    distribution = launches.environment.get('ROS_DISTRO')
    if distribution == 'humble' and name in NEWER_THAN_HUMBLE:
        pytest.skip('Humble lacks what it uses')
    theirs = launches.ros2(name, *words.split())
    assert theirs.processes, theirs.output
    ours = launches.colcon(name, *words.split())
    assert not differences(ours, theirs), ours.output + theirs.output
    assert ours.printed == theirs.printed
    assert 'Traceback' not in ours.output
