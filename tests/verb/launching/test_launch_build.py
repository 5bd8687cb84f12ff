# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The build and the environment, from a user's side."""

from collections.abc import Callable
import os
from pathlib import Path
import shutil
import signal
import subprocess
import time

import pytest
from support.user import built, User

BROKEN = 'launch:\n  - nod: {pkg: {name}, exec: x}\n'


def test_mistake_is_reported_before_anything_is_built(user: User) -> None:
    user.package('one', BROKEN)
    output = user.launch('one', 'one', code=1)
    place = 'src/one/launch/one.yaml:2:5: error: '
    assert f"{place}unknown action 'nod'" in output
    assert "did you mean 'node'?" in output
    assert not (user.root / 'build').exists()


@pytest.mark.parametrize(
    ('action', 'message'),
    [
        ('node: {pkg: neo, exec: x}', "did you mean 'one'?"),
        (
            'include: {file: $(find-pkg-share one)/launch/no.yaml}',
            'does not exist',
        ),
    ],
)
def test_what_does_not_exist_is_reported_before_anything_is_built(
    user: User, action: str, message: str
) -> None:
    user.package('one', f'launch:\n  - {action}\n')
    assert message in user.launch('one', 'one', code=1)
    assert not (user.root / 'build').exists()


def test_edits_run_without_a_build(user: User) -> None:
    folder = user.package('one')
    user.launch('one', 'one')
    script = folder / 'scripts/hello.sh'
    script.write_text('#!/bin/sh\necho edited script "$@"\n')
    launch = folder / 'launch/one.yaml'
    launch.write_text(launch.read_text().replace('.sh', '.sh edited launch'))
    output = user.launch('one', 'one')
    assert 'edited script edited launch' in output
    assert built(output) == []


def test_edits_of_what_is_compiled_are_built(user: User) -> None:
    folder = user.package('one')
    user.launch('one', 'one')
    cmake = folder / 'CMakeLists.txt'
    cmake.write_text(cmake.read_text() + '# changed\n')
    output = user.launch('one', 'one')
    assert built(output) == ['one']
    assert 'CMakeLists.txt changed' in output


def test_failed_build_starts_nothing(user: User) -> None:
    folder = user.package('one')
    cmake = folder / 'CMakeLists.txt'
    good = cmake.read_text()
    cmake.write_text(good + 'message(FATAL_ERROR "broken on purpose")\n')
    output = user.launch('one', 'one', code=1)
    assert 'broken on purpose' in output
    assert 'hello from one' not in output
    cmake.write_text(good)
    assert 'hello from one' in user.launch('one', 'one')


def test_ctrl_c_stops_the_build(user: User, tmp_path: Path) -> None:
    folder = user.package('one')
    started = tmp_path / 'started'
    cmake = folder / 'CMakeLists.txt'
    cmake.write_text(
        f'{cmake.read_text()}'
        f'execute_process(COMMAND sh -c "echo \\$\\$ > {started}; '
        'exec sleep 1000")\n'
    )
    launch = user.start('colcon', 'launch', 'one', 'one')
    launch.wait_for('Starting >>> one')
    deadline = time.monotonic() + 60
    while not (started.exists() and started.read_text().strip()):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    # a terminal sends Ctrl-C to the whole process group
    os.killpg(launch.process.pid, signal.SIGINT)
    assert launch.end() == 130, launch.output
    assert 'hello from one' not in launch.output
    assert 'Traceback' not in launch.output
    sleeper = int(started.read_text())
    deadline = time.monotonic() + 60
    while Path(f'/proc/{sleeper}').exists():
        assert time.monotonic() < deadline, 'the build is still running'
        time.sleep(0.02)


def test_logs_are_where_colcon_keeps_them(user: User) -> None:
    user.package('one')
    user.launch('one', 'one')
    latest = user.root / 'log/latest_launch'
    assert latest.resolve().name.startswith('launch_')
    log = latest / 'hello.sh-1/stdout_stderr.log'
    assert log.read_text() == 'hello from one\n'
    assert (latest / 'one/command.log').is_file()


def test_ros_log_dir_is_set_for_nodes(user: User) -> None:
    show = "launch: [executable: {cmd: 'printenv ROS_LOG_DIR'}]\n"
    user.package('one', show)
    output = user.launch('one', 'one')
    latest = (user.root / 'log/latest_launch').resolve()
    assert str(latest) in output
    user.environment['ROS_LOG_DIR'] = '/where/the/user/wants/it'
    assert '/where/the/user/wants/it' in user.launch('one', 'one')


def package_with_a_tool(user: User) -> None:
    """Write a package whose program is found by the PATH."""
    folder = user.package('one', 'launch: [executable: {cmd: my-tool}]\n')
    user.write('src/one/my-tool', '#!/bin/sh\necho from the PATH\n', 0o755)
    cmake = folder / 'CMakeLists.txt'
    text = cmake.read_text()
    cmake.write_text(f'{text}install(PROGRAMS my-tool DESTINATION bin)\n')


def test_environment_is_the_sourced_one(user: User) -> None:
    package_with_a_tool(user)
    # the program is on the PATH only once the package is built and sourced
    assert 'from the PATH' in user.launch('one', 'one')
    assert 'from the PATH' in user.launch('one', 'one')


def test_sourcing_that_fails_silently_is_noticed(user: User) -> None:
    package_with_a_tool(user)
    user.launch('one', 'one')
    (user.root / 'install/_local_setup_util_sh.py').write_text('oops(\n')
    setup = ['bash', '-c', 'source install/setup.bash']
    done = subprocess.run(setup, cwd=user.root, capture_output=True)
    assert done.returncode == 0
    output = user.launch('one', 'one', '--no-build', code=1)
    assert 'did not bring in one' in output
    assert 'from the PATH' not in output


def test_chained_underlay_survives_the_build(
    user: User, make_user: Callable[[], User]
) -> None:
    underlay = make_user()
    underlay.package('base')
    underlay.launch('base', 'base')
    user.package(
        'top',
        'launch:\n'
        '- executable: {cmd: $(find-pkg-prefix base)/lib/base/hello.sh}\n',
    )
    setup = underlay.root / 'install/setup.bash'
    script = f'source {setup} && colcon launch top top'
    first = user.start('bash', '-c', script)
    assert first.end() == 0, first.output
    assert 'hello from base' in first.output
    # now from a shell that has nothing sourced
    cmake = user.root / 'src/top/CMakeLists.txt'
    cmake.write_text(cmake.read_text() + '# changed\n')
    output = user.launch('top', 'top')
    assert built(output) == ['top']
    assert 'hello from base' in output
    assert 'nothing is sourced in this shell' in output
    setup = (user.root / 'install/setup.bash').read_text()
    assert str(underlay.root / 'install') in setup


def test_workspace_that_was_copied(user: User, tmp_path: Path) -> None:
    user.package('one')
    user.launch('one', 'one')
    copy = tmp_path / 'copy'
    shutil.copytree(user.root, copy, symlinks=True)
    script = copy / 'src/one/scripts/hello.sh'
    script.write_text('#!/bin/sh\necho from the copy\n')
    output = user.launch('one', 'one', cwd=copy)
    assert 'was moved or copied' in output
    assert 'from the copy' in output
    assert 'hello from one' in user.launch('one', 'one')


def test_invalid_manifest(user: User) -> None:
    user.package('one')
    user.manifest('one', mail='nonsense')
    for words in ([], ['--check']):
        output = user.launch('one', 'one', *words, code=1)
        assert 'src/one/package.xml is invalid' in output
        assert 'nonsense' in output
    assert not (user.root / 'build').exists()


def test_invalid_manifest_of_a_folder_that_is_nothing_else(
    user: User,
) -> None:
    user.package('other')
    user.manifest('one', mail='nonsense')
    output = user.launch('one', 'one', code=1)
    assert 'src/one/package.xml: error: ' in output
    assert 'Invalid email "nonsense"' in output


def test_undeclared_package_is_built_and_named(user: User) -> None:
    user.package('used')
    include = '$(find-pkg-share used)/launch/used.yaml'
    user.package('top', f'launch:\n  - include: {{file: {include}}}\n')
    user.manifest('top')
    output = user.launch('top', 'top')
    assert 'add <exec_depend>used</exec_depend>' in output
    assert 'src/top/launch/top.yaml:2:' in output
    assert built(output) == ['top', 'used']
    user.manifest('top', '<exec_depend>used</exec_depend>')
    assert 'exec_depend' not in user.launch('top', 'top')
