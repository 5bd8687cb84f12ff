# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Looking at a launch runs nothing of the workspace, as of a fresh clone."""

from collections.abc import Callable
import json
from pathlib import Path

from colcon_yamllaunch.workspace.environment.hooks import described_environment
from colcon_yamllaunch.workspace.environment.sourcing import source
import pytest
from support.completion import complete
from support.manifest import manifest
from support.user import User

pytestmark = [pytest.mark.hostile, pytest.mark.full]

DEMO = """\
launch:
  - arg: {name: who, default: nobody}
  - executable: {cmd: $(find-pkg-prefix one)/lib/one/hello.sh $(var who)}
"""
COMMANDS = """\
launch:
  - arg:
      name: who
      default: $(command 'touch {trap}')
  - arg:
      name: age
      default: $(eval '[open("{trap}", "w"), 0][1]')
  - arg:
      name: sum
      default: $(eval '1 + 2')
  - executable:
      cmd: echo $(var who) $(var age) $(var sum)
"""


@pytest.fixture
def trap(user: User) -> Path:
    """Set traps in whatever a launch runs; the file is there when one did."""
    path = user.root / 'ran'
    in_python = f'open({str(path)!r}, "w")\n'
    in_shell = f'touch {path}\n'
    user.package('one', DEMO)
    commands = COMMANDS.replace('{trap}', str(path))
    user.write('src/one/launch/commands.yaml', commands)
    user.write(
        'src/py/setup.py',
        f'{in_python}from setuptools import setup\nsetup(name="p" + "y")\n',
    )
    user.write('src/cfg/setup.py', 'from setuptools import setup\nsetup()\n')
    user.write(
        'src/cfg/setup.cfg', '[metadata]\nname = cfg\nversion = attr: m.v\n'
    )
    user.write('src/cfg/m.py', f'{in_python}v = str(1)\n')
    user.write('src/ros/package.xml', manifest('ros', 'ament_python', ''))
    user.write('src/ros/setup.py', in_python)
    underlay = user.root.parent / 'underlay'
    user.write('../underlay/local_setup.bash', in_shell)
    user.write('install/.colcon_install_layout', 'isolated\n')
    user.write('install/local_setup.bash', in_shell)
    user.write(
        'install/setup.bash',
        f'COLCON_CURRENT_PREFIX="{underlay}"\n'
        '. "$COLCON_CURRENT_PREFIX/local_setup.bash"\n' + in_shell,
    )
    return path


@pytest.mark.parametrize(
    ('words', 'code'),
    [
        (('demo.yaml', '--check'), 0),
        (('commands.yaml', '--check'), 0),
        (('commands.yaml', '-s'), 0),
        (('demo.yaml', '--plan'), 0),
        (('demo.yaml', '--plan', '--why'), 0),
        (('commands.yaml', '--plan=json'), 0),
    ],
)
def test_looking_runs_nothing(
    user: User, trap: Path, words: tuple[str, ...], code: int
) -> None:
    user.write('src/one/launch/demo.yaml', DEMO)
    output = user.launch('one', *words, code=code)
    assert not trap.exists()
    assert (
        'src/py/setup.py:1:1: warning: the name of this package is taken to '
        "be 'py'" in output
    )
    assert output.count('is taken to be') == 1
    if '--plan=json' in words:
        assert f"$(command 'touch {trap}') may do anything" in output
        assert 'and is left open in this plan' in output
        assert 'add --run-commands' in output
        assert output.count('warning: $(') == 2


def test_a_plan_that_leaves_something_open_is_not_run(
    user: User, trap: Path
) -> None:
    output = user.launch('one', 'commands.yaml', '--plan=json')
    # the warnings may stand on both sides
    start = output.index('{\n')
    plan, _ = json.JSONDecoder().raw_decode(output[start:])
    user.write('plan.json', json.dumps(plan))
    output = user.launch('--from-plan', 'plan.json', code=1)
    assert f"$(command 'touch {trap}') was left open in it" in output


def test_completion_runs_nothing(user: User, trap: Path) -> None:
    for line, expected in (
        ('colcon launch ', 'py'),
        ('colcon launch one ', 'commands.yaml'),
        ('colcon launch one commands.yaml ', 'who:='),
        ('colcon run one ', 'hello.sh'),
    ):
        assert expected in complete(line, user.root, user.environment)
    assert not trap.exists()


def test_plan_of_who_trusts_the_launch_file(user: User, trap: Path) -> None:
    output = user.launch('one', 'commands.yaml', '--plan', '--run-commands')
    assert trap.exists()
    assert "echo '' 0 3" in output


def test_what_is_described_is_what_sourcing_makes(
    user: User, make_user: Callable[[], User]
) -> None:
    underlay = make_user()
    underlay.package('base')
    underlay.manifest('base')
    underlay.launch('base', 'base')
    for name in ('a', 'b'):
        cmake = user.package(name) / 'CMakeLists.txt'
        with cmake.open('a', encoding='utf-8') as file:
            file.write('install(PROGRAMS scripts/hello.sh DESTINATION bin)\n')
    # against the order of the names
    user.manifest('a', '<exec_depend>b</exec_depend>')
    user.manifest('b', '<exec_depend>base</exec_depend>')
    user.environment['COLCON_PREFIX_PATH'] = str(underlay.root / 'install')
    user.launch('a', 'a')
    setup = user.root / 'install/setup.bash'
    before = {'PATH': '/usr/bin:/bin', 'CMAKE_PREFIX_PATH': '/x'}
    sourced = source(setup, before).variables
    described = described_environment(setup, before).variables
    assert described == sourced
    install = user.root / 'install'
    assert described['PATH'].startswith(f'{install}/a/bin:{install}/b/bin:')
    assert str(underlay.root) in described['COLCON_PREFIX_PATH']
