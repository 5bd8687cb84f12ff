# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`--timeline`: how a launch that has ended has started."""

from support.user import User

LAUNCH = """\
launch:
  - executable: {cmd: sh -c 'sleep 0.2; touch up; sleep 60', name: driver}
  - executable: {cmd: sleep 60, name: nav}
"""
ROBOT = """\
processes:
  - {match: driver, ready: {file: up}}
  - {match: nav, after: driver}
"""


def test_page_of_the_latest_launch_is_written(user: User) -> None:
    user.package('demo', LAUNCH)
    user.write('robot.yaml', ROBOT)
    words = ('demo', 'demo', '--deploy', 'robot.yaml', '--until-ready')
    user.launch(*words, '--timeout', '60')
    output = user.launch('--timeline').splitlines()
    assert output[1].startswith('nav-2 @')
    assert output[2].startswith('└─driver-1 @')
    page = user.root / output[-1]
    assert page.parent == (user.root / 'log/latest_launch').resolve()
    assert 'nav-2: waiting' in page.read_text()
    # a second time, of this folder
    again = user.launch('--timeline', f'log/{page.parent.name}')
    assert again.splitlines() == output


def test_log_that_is_none_is_an_error(user: User) -> None:
    output = user.launch('--timeline', 'nowhere', code=1)
    assert "cannot read '" in output
    assert 'a log folder is log/launch_…' in output
    output = user.launch('--timeline', 'a', 'b', code=1)
    assert "--timeline takes one log folder, not 'b', too" in output
