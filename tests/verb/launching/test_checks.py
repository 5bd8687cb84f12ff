# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The mistakes that a guide warns of: each has a message with its cure."""

from pathlib import Path

from colcon_yamllaunch.common.suggestions import on_debian
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.verb.prepare import missing_programs
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator
import pytest
from support.user import User

AT = Position('a.yaml', 3, 5)
NO_PACKAGES = PackageLocator((), Path('/install'), False, {})

NODE = 'launch:\n  - node: {pkg: {name}, exec: hello.sh}\n'


def test_first_item_is_indented_otherwise(user: User) -> None:
    user.package(
        'one',
        'launch:\n\n'
        '    - node:\n        pkg: one\n        exec: hello.sh\n\n'
        '  - node:\n      pkg: one\n      exec: hello.sh\n',
    )
    output = user.launch('one', 'one', code=1)
    assert 'src/one/launch/one.yaml:7:3: error: this list item' in output
    assert 'by 2 spaces' in output
    assert '(line 3) by 4 spaces' in output


def test_script_is_not_executable(user: User) -> None:
    folder = user.package('one', NODE)
    (folder / 'scripts/hello.sh').chmod(0o644)
    output = user.launch('one', 'one', code=1)
    assert 'chmod +x scripts/hello.sh' in output
    assert 'src/one/launch/one.yaml:2:' in output
    # what the source tells is said first
    assert not (user.root / 'install').exists()
    # the cure cures it
    (folder / 'scripts/hello.sh').chmod(0o755)
    assert 'hello from one --ros-args' in user.launch('one', 'one')


def test_script_is_not_installed(user: User) -> None:
    user.package('one', NODE.replace('hello.sh', 'new.sh'))
    user.write('src/one/scripts/new.sh', '#!/bin/sh\n', 0o755)
    output = user.launch('one', 'one', code=1)
    cure = 'install(PROGRAMS scripts/new.sh DESTINATION lib/${PROJECT_NAME})'
    assert cure in output
    assert not (user.root / 'install').exists()


def test_script_that_may_be_installed_after_all(user: User) -> None:
    folder = user.package('one', NODE.replace('hello.sh', 'new.sh'))
    user.write('src/one/scripts/new.sh', '#!/bin/sh\necho new\n', 0o755)
    cmake = folder / 'CMakeLists.txt'
    rule = 'install(PROGRAMS ${SCRIPTS} DESTINATION lib/${PROJECT_NAME})'
    cmake.write_text(
        f'{cmake.read_text()}\nfile(GLOB SCRIPTS scripts/*)\n{rule}\n'
    )
    assert '] new\n' in user.launch('one', 'one')


def test_program_without_its_extension(user: User) -> None:
    user.package('one', NODE.replace('hello.sh', 'hello'))
    output = user.launch('one', 'one', code=1)
    assert "did you mean 'hello.sh'?" in output


def test_unknown_program_lists_those_there_are(user: User) -> None:
    user.package('one', NODE.replace('hello.sh', 'goodbye'))
    output = user.launch('one', 'one', code=1)
    assert "error: one has no executable 'goodbye'\n" in output
    assert '\n  help: it has hello.sh\n' in output


def test_launch_folder_is_not_installed(user: User) -> None:
    folder = user.package('one')
    cmake = folder / 'CMakeLists.txt'
    cmake.write_text(
        cmake.read_text().replace('DIRECTORY launch', 'DIRECTORY')
    )
    output = user.launch('one', 'one')
    assert 'launch/one.yaml of one is not installed' in output
    cure = 'install(DIRECTORY launch DESTINATION share/${PROJECT_NAME})'
    assert cure in output
    # what is in the source runs all the same
    assert 'hello from one' in output
    assert cure in user.launch('one', 'one')


def test_config_folder_is_not_installed(user: User) -> None:
    folder = user.package(
        'one',
        'launch:\n'
        '  - node: {pkg: one, exec: hello.sh,\n'
        '           args: -c $(dirname)/../config/hello.txt}\n',
    )
    cmake = folder / 'CMakeLists.txt'
    cmake.write_text(cmake.read_text().replace('launch config', 'launch'))
    output = user.launch('one', 'one')
    cure = 'install(DIRECTORY config DESTINATION share/${PROJECT_NAME})'
    assert cure in output
    assert 'src/one/launch/one.yaml:2:' in output


def test_parameter_file_is_not_installed(user: User) -> None:
    folder = user.package(
        'one',
        'launch:\n'
        '  - node: {pkg: one, exec: hello.sh,\n'
        '           param: [{from: $(dirname)/../config/hello.txt}]}\n',
    )
    # before a build it is to be expected that it is not there
    output = user.launch('one', 'one', '--plan')
    assert 'one/launch/../config/hello.txt' in output
    assert 'warning' not in output
    cmake = folder / 'CMakeLists.txt'
    cmake.write_text(cmake.read_text().replace('launch config', 'launch'))
    output = user.launch('one', 'one')
    assert output.count('warning') == 1
    assert 'does not exist; it is skipped' in output
    cure = 'install(DIRECTORY config DESTINATION share/${PROJECT_NAME})'
    assert f"\n  help: add '{cure}' to CMakeLists.txt\n" in output


def test_parameter_file_for_other_nodes_is_reported_before_a_build(
    user: User,
) -> None:
    user.package(
        'one',
        'launch:\n'
        '  - node: {pkg: one, exec: hello.sh, name: talker, param: [\n'
        '      {from: $(find-pkg-share one)/config/p.yaml}]}\n',
    )
    user.write('src/one/config/p.yaml', 'x: {ros__parameters: {a: 1}}\n')
    output = user.launch('one', 'one')
    assert output.startswith('src/one/launch/one.yaml:3:14: warning: no sec')
    assert output.count('warning') == 1
    assert 'hello from one' in output
    assert "is for the node '/talker'" in user.launch('one', 'one')


def test_file_is_looked_for_in_its_folder(user: User) -> None:
    folder = user.package(
        'one',
        'launch:\n'
        '  - node: {pkg: one, exec: hello.sh, param: [\n'
        '      {from: $(find-pkg-share one)/config/ones.yaml}]}\n',
    )
    # what is near is a launch file
    output = user.launch('one', 'one', '--plan')
    assert 'ones.yaml' in output
    assert 'did you mean' not in output
    (folder / 'config/onse.yaml').write_text('{}')
    output = user.launch('one', 'one', '--plan')
    assert "did you mean 'onse.yaml'?" in output


def test_package_name_is_misspelled(user: User) -> None:
    user.package('my_camera', NODE.replace('{name}', 'my_camrea'))
    output = user.launch('my_camera', 'my_camera', code=1)
    assert "did you mean 'my_camera'?" in output


def test_dirname_is_not_affected_by_find_pkg_share(user: User) -> None:
    user.package('other')
    user.package(
        'one',
        'launch:\n'
        '  - include: {file: $(find-pkg-share other)/launch/other.yaml}\n'
        '  - executable: {cmd: echo $(find-pkg-share other) $(dirname)}\n',
    )
    install = user.root / 'install'
    wanted = f'{install}/other/share/other {install}/one/share/one/launch'
    assert wanted in user.launch('one', 'one')


def test_component_that_is_not_registered(user: User) -> None:
    folder = user.package(
        'one',
        'launch:\n'
        '  - node_container:\n'
        '      pkg: one\n'
        '      exec: hello.sh\n'
        '      name: box\n'
        '      composable_node:\n'
        "        - {pkg: one, plugin: 'one::Talkr', name: talker}\n"
        "        - {pkg: oen, plugin: 'one::Talker', name: other}\n",
    )
    cmake = folder / 'CMakeLists.txt'
    index = 'share/ament_index/resource_index/rclcpp_components'
    user.write('src/one/listed/one', 'one::Talker;lib/libone.so\n')
    cmake.write_text(
        cmake.read_text()
        + f'\ninstall(FILES listed/one DESTINATION {index})\n'
    )
    # what no build brings is said before one
    output = user.launch('one', 'one', code=1)
    assert "there is no package 'oen'" in output
    assert "did you mean 'one'?" in output
    assert 'building' not in output
    launch = folder / 'launch/one.yaml'
    launch.write_text(launch.read_text().replace('oen', 'one'))
    output = user.launch('one', 'one', code=1)
    assert "no component 'one::Talkr': did you mean 'one::Talker'?" in output
    assert 'src/one/launch/one.yaml:7:' in output
    assert 'hello from one' not in output
    # who only looks is shown the rest as well
    output = user.launch('one', 'one', '--plan')
    assert 'talker, node /talker, package one, plugin one::Talkr' in output


def test_launch_goes_on_without_commands_that_this_machine_lacks(
    user: User,
) -> None:
    user.write(
        'a.yaml',
        'launch:\n'
        '- executable: {cmd: no_such_broker -v}\n'
        '- executable: {cmd: ./start_app.sh}\n'
        '- executable: {cmd: echo, launch-prefix: "no_such_terminal -e"}\n'
        '- executable: {cmd: echo all the rest}\n',
    )
    output = user.launch('a.yaml', code=1)
    assert (
        "a.yaml:2:21: warning: there is no executable 'no_such_broker' on "
        'the PATH, so no_such_broker-1 cannot be started\n'
    ) in output
    assert f'help: install it ({on_debian("no_such_broker")})' in output
    assert "a.yaml:3:21: warning: there is no executable './star" in output
    assert f'create the program {user.root}/start_app.sh' in output
    assert "a.yaml:4:42: warning: there is no executable 'no_such_te" in output
    assert 'install no_such_terminal), or correct the name' in output
    assert output.index('warning') < output.index('started, pid')
    assert 'all the rest\n' in output
    assert 'then failed: echo-3 could not be started' in output
    # the same plan, saved
    (user.root / 'plan').write_text(user.launch('a.yaml', '--plan=json'))
    plan = (user.root / 'plan').read_text()
    (user.root / 'plan').write_text(plan[plan.index('\n{') :])
    output = user.launch('--from-plan', 'plan', code=1)
    assert "a.yaml:2:3: warning: there is no executable 'no_such_br" in output
    assert 'all the rest\n' in output
    # a check has them as errors
    output = user.launch('a.yaml', '--check', code=1)
    assert output.count(': error: there is no executable') == 3


def test_program_of_a_package_stays_an_error(user: User) -> None:
    user.package(
        'one',
        'launch:\n'
        '  - executable: {cmd: $(find-pkg-prefix one)/lib/one/no_such}\n'
        '  - executable: {cmd: echo all the rest}\n',
    )
    output = user.launch('one', 'one', code=1)
    assert "error: there is no executable '" in output
    assert 'all the rest' not in output


@pytest.mark.parametrize(
    ('argv', 'path', 'hint'),
    [
        (('no_such',), None, f'install it ({on_debian("no_such")})'),
        (('gzserver',), '/nowhere', f'install it ({on_debian("gazebo")})'),
        (('./no_such',), None, 'create the program {}/no_such'),
        (('./data',), None, 'make it executable: chmod +x {}/data'),
        (('/bin',), None, 'create the program /bin'),
        (('sh',), '/nowhere', f'install it ({on_debian("sh")})'),
    ],
)
def test_missing_command_has_a_way_out(
    tmp_path: Path, argv: tuple[str, ...], path: str | None, hint: str
) -> None:
    (tmp_path / 'data').write_text('')
    own = () if path is None else (('PATH', path),)
    process = Process('a', argv, str(tmp_path), AT, environment=own)
    (found,) = missing_programs([process], {}, NO_PACKAGES, {'PATH': '/bin'})
    assert (found.severity, found.position) == ('warning', AT)
    assert (found.hint or '').startswith(hint.format(tmp_path))


def test_command_on_the_path_of_its_own_environment_is_found(
    tmp_path: Path,
) -> None:
    (tmp_path / 'tool').write_text('#!/bin/sh\n')
    (tmp_path / 'tool').chmod(0o755)
    own = (('PATH', str(tmp_path)),)
    found = Process('a', ('tool',), '/', AT, environment=own)
    by_path = Process('b', ('./tool',), str(tmp_path), AT)
    assert not list(missing_programs([found, by_path], {}, NO_PACKAGES, {}))
