# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launch says about its builds, --why and --force."""

from collections.abc import Callable
from pathlib import Path
import re

import pytest
from support.user import built, User

USES_BOTH = """\
launch:
- executable: {cmd: $(find-pkg-prefix one)/lib/one/hello.sh}
- executable: {cmd: $(find-pkg-prefix two)/lib/two/hello.sh}
"""


@pytest.fixture
def two(user: User) -> Path:
    """Write two packages, the second of which the first one needs."""
    user.package('two')
    folder = user.package('one', USES_BOTH)
    user.manifest('one', '<depend>two</depend>')
    return folder


def test_each_launch_says_in_one_line_what_was_built(
    user: User, two: Path
) -> None:
    output = user.launch('one', 'one')
    assert '2 packages built (two, one: never built)\n' in output
    output = user.launch('one', 'one')
    assert output.startswith('2 packages up to date\n')
    assert output.count('up to date') == 1
    cmake = two / 'CMakeLists.txt'
    cmake.write_text(f'{cmake.read_text()}# changed\n')
    output = user.launch('one', 'one')
    line = '(one: CMakeLists.txt changed), 1 up to date'
    assert f'building 1 package {line}…\n' in output
    assert f'\n1 package built {line}\n' in output


def test_packages_that_turn_up_late_are_in_the_same_line(user: User) -> None:
    # what is included is known only when the first package is built
    user.package('two')
    user.package(
        'one',
        'launch:\n'
        '- include:\n'
        '    file: $(find-pkg-share two)/launch/two.yaml\n'
        '    if: $(command $(find-pkg-prefix one)/lib/one/hello.sh)\n',
    )
    answer = '#!/bin/sh\nprintf true\n'
    user.write('src/one/scripts/hello.sh', answer, 0o755)
    output = user.launch('one', 'one')
    assert 'hello from two' in output
    assert '\n2 packages built (one, two: never built)\n' in output
    output = user.launch('one', 'one', '--force')
    assert sorted(built(output)) == ['one', 'two']
    assert '\n2 packages built (one, two: asked for)\n' in output


def test_failed_build_says_what_failed(user: User, two: Path) -> None:
    cmake = user.root / 'src/two/CMakeLists.txt'
    cmake.write_text(f'{cmake.read_text()}nonsense()\n')
    output = user.launch('one', 'one', code=1)
    assert '\ntwo failed to build; not built: one\n' in output


def test_mistake_says_nothing_of_builds(user: User) -> None:
    user.package('one', 'launch: [oops: {}]\n')
    output = user.launch('one', 'one', code=1)
    assert 'up to date' not in output
    assert 'needed' not in output


def test_why_tells_each_decision(user: User, two: Path) -> None:
    cmake = two / 'CMakeLists.txt'
    # what only installs its own files needs no other package for that
    cmake.write_text(f'{cmake.read_text()}find_package(two QUIET)\n')
    user.launch('one', 'one')
    (user.root / 'src/two/new.txt').touch()
    output = user.launch('one', 'one', '--why')
    assert (
        'two: to be built, as new file new.txt [configured anew]; '
        'needed by one.yaml\n'
    ) in output
    assert 'one: to be built, as two is built' in output
    output = user.launch('one', 'one', '--why')
    pattern = (
        r'^two: up to date since its build at \d{4}-\d\d-\d\d \d\d:\d\d:\d\d; '
        r'needed by one\.yaml$'
    )
    assert re.search(pattern, output, re.MULTILINE)


def test_why_tells_the_way_to_a_package(user: User) -> None:
    user.package('three')
    user.package('two')
    user.manifest('two', '<exec_depend>three</exec_depend>')
    user.package('one')
    user.manifest('one', '<exec_depend>two</exec_depend>')
    output = user.launch('one', 'one', '--why')
    assert 'three: to be built, as never built; ' in output
    assert 'needed by one.yaml → one → two\n' in output


@pytest.mark.parametrize('option', ['--no-build', '--plan'])
def test_why_without_a_build(user: User, two: Path, option: str) -> None:
    user.launch('one', 'one')
    (two / 'new.txt').touch()
    output = user.launch('one', 'one', '--why', option)
    assert 'one: to be built, as new file new.txt' in output
    assert built(output) == []
    assert 'new file new.txt' in user.launch('one', 'one')


def test_shell_that_sourced_the_workspace_builds_nothing(
    user: User, make_user: Callable[[], User]
) -> None:
    underlay = make_user()
    underlay.package('base')
    underlay.launch('base', 'base')
    user.package('top')
    user.manifest('top', '<depend>base</depend>')
    below = underlay.root / 'install/setup.bash'
    own = user.root / 'install/setup.bash'
    launch = 'colcon launch top top'
    for sourced in (f'source {below} && ', '', f'source {own} && '):
        done = user.start('bash', '-c', sourced + launch)
        assert done.end() == 0, done.output
    assert '1 package up to date' in done.output


def test_two_launches_at_once_build_once(user: User, tmp_path: Path) -> None:
    user.package('one')
    go_on = tmp_path / 'go_on'
    cmake = user.root / 'src/one/CMakeLists.txt'
    wait = f'until test -e {go_on}; do sleep 0.05; done'
    wait = f'execute_process(COMMAND sh -c "{wait}")\n'
    cmake.write_text(cmake.read_text() + wait)
    first = user.start('colcon', 'launch', 'one', 'one')
    first.wait_for('Starting >>> one')
    second = user.start('colcon', 'launch', 'one', 'one')
    second.wait_for(
        "waiting for 'colcon launch one one' "
        rf'\(process {first.process.pid}\), which builds one…'
    )
    go_on.touch()
    assert first.end() == 0, first.output
    assert second.end() == 0, second.output
    assert built(first.output) == ['one']
    assert built(second.output) == []
    assert '1 package up to date' in second.output
    assert 'hello from one' in second.output
