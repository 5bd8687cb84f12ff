# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What build tools would overlook, and what others built, with real builds."""

import os
import signal
import subprocess
import time

import pytest

#: Seconds.
HOUR = 3600
C_PROGRAM = """\
cmake_minimum_required(VERSION 3.16)
project(prog C)
set(LEVEL 1 CACHE STRING "")
add_executable(prog main.c)
target_compile_definitions(prog PRIVATE LEVEL=${LEVEL})
install(TARGETS prog DESTINATION lib/prog)
"""
MAIN = """\
#include <stdio.h>
int main(void) { return printf("%d %d\\n", LEVEL, TEXT) < 0; }
"""
#: As rosidl does it: a hash of an interface with all that it contains, made
#: again only when an interface of the own package changes.
INTERFACES = """\
cmake_minimum_required(VERSION 3.16)
project({name} NONE)
find_package(base QUIET)
set(own ${{CMAKE_CURRENT_SOURCE_DIR}}/msg/{name}.msg)
add_custom_command(OUTPUT hash DEPENDS ${{own}}
  COMMAND cat ${{own}} {contained} > hash)
add_custom_target(interfaces ALL DEPENDS hash)
{further}
install(FILES ${{own}} ${{CMAKE_CURRENT_BINARY_DIR}}/hash
  DESTINATION share/{name})
"""


class Program:
    """A compiled package."""

    def __init__(self, workspace, update) -> None:
        self.root = workspace.root
        self.folder = workspace.root / 'src/prog'
        self._update = update
        workspace.write('src/prog/CMakeLists.txt', C_PROGRAM)
        self.edit('main.c', MAIN.replace('TEXT', '1'))

    def edit(self, name, text, age=0.0) -> None:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        moment = time.time() - age
        os.utime(path, (moment, moment))

    def run(self, **options) -> str:
        (returncode, _, _), output = self._update('prog', **options)
        assert returncode == 0, output
        program = self.root / 'install/prog/lib/prog/prog'
        done = subprocess.run([program], capture_output=True, text=True)
        return done.stdout.strip()


@pytest.fixture
def program(workspace, update):
    made = Program(workspace, update)
    assert made.run() == '1 1'
    return made


def test_older_time_does_not_hide_an_edit(program):
    program.edit('main.c', MAIN.replace('TEXT', '2'), age=HOUR)
    assert program.run() == '1 2'


def test_earlier_arguments_and_flags_are_forgotten(program):
    assert program.run(arguments=('--cmake-args', '-DLEVEL=5')) == '5 1'
    assert program.run() == '1 1'
    flags = '-include stdio.h -DTEXT=9'
    program.edit('main.c', MAIN)
    assert program.run(CFLAGS=flags) == '1 9'
    assert program.run(CFLAGS=flags.replace('9', '8')) == '1 8'


def test_changed_default_of_an_option_counts(program):
    program.edit('CMakeLists.txt', C_PROGRAM.replace('LEVEL 1', 'LEVEL 3'))
    assert program.run() == '3 1'


def test_header_from_outside_the_package_counts(program):
    program.edit('main.c', f'#include "../common/x.h"\n{MAIN}')
    program.edit('../common/x.h', '#define TEXT 1\n', age=HOUR)
    assert program.run() == '1 1'
    program.edit('../common/x.h', '#define TEXT 2\n')
    assert program.run() == '1 2'


def test_what_is_not_installed_any_more_is_removed(workspace, program):
    renamed = C_PROGRAM.replace('(prog main.c)', '(other main.c)').replace(
        'definitions(prog ', 'definitions(other '
    )
    renamed = renamed.replace('TARGETS prog', 'TARGETS other')
    program.edit('CMakeLists.txt', renamed)
    with pytest.raises(FileNotFoundError):
        program.run()
    installed = workspace.root / 'install/prog/lib/prog'
    assert [path.name for path in installed.iterdir()] == ['other']


def test_links_survive_a_build_that_fails(workspace, update):
    folder = workspace.cmake('flow')
    assert update('flow')[0][0] == 0
    good = (folder / 'CMakeLists.txt').read_text()
    (folder / 'CMakeLists.txt').write_text(good + 'nonsense()\n')
    assert update('flow')[0][0] != 0
    link = workspace.root / 'install/flow/share/flow/launch/flow.yaml'
    assert link.read_text() == 'launch: []\n'


def test_same_build_by_others_is_no_reason_to_build(workspace, update):
    workspace.cmake('flow')
    assert update('flow')[0][0] == 0
    build = ['colcon', 'build', '--symlink-install']
    environment = workspace.environment()
    subprocess.run(
        build,
        cwd=workspace.root,
        env=environment,
        check=True,
        capture_output=True,
    )
    assert update('flow')[0] == [0, {}, ['flow']]


def test_build_that_was_cut_off_is_repeated_from_scratch(workspace, update):
    folder = workspace.cmake('flow')
    text = (folder / 'CMakeLists.txt').read_text()
    (folder / 'CMakeLists.txt').write_text(
        f'{text}file(WRITE ${{CMAKE_BINARY_DIR}}/left "")\n'
        'execute_process(COMMAND sleep 600)\n'
    )
    left = workspace.root / 'build/flow/left'
    code = (
        f'colcon = CachedColcon(Path({str(workspace.root)!r}))\n'
        'bring_up_to_date(colcon, ["flow"], dict(os.environ), print)\n'
    )
    with workspace.start(code) as process:
        end = time.monotonic() + 60
        while not left.exists() and time.monotonic() < end:
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGKILL)
    (folder / 'CMakeLists.txt').write_text(text)
    result, _ = update('flow')
    assert result[1] == {
        'flow': 'no successful build: the last one was cut off'
    }
    assert not left.exists()
    assert update('flow')[0] == [0, {}, ['flow']]


def test_dependents_see_what_a_dependency_configures(workspace, update):
    workspace.cmake('base')
    folder = workspace.cmake('user', needs=('base',))
    text = (folder / 'CMakeLists.txt').read_text()
    value = workspace.root / 'install/base/share/base/value'
    (folder / 'CMakeLists.txt').write_text(
        f'{text}file(READ {value} v)\n'
        'file(WRITE ${CMAKE_BINARY_DIR}/v ${v})\n'
        'install(FILES ${CMAKE_BINARY_DIR}/v DESTINATION share/user)\n'
    )
    for number in (1, 2):
        workspace.cmake(
            'base',
            install='file(WRITE ${CMAKE_BINARY_DIR}/value '
            f'{number})\ninstall(FILES ${{CMAKE_BINARY_DIR}}/value '
            'DESTINATION share/base)\n',
        )
        assert update('user')[0][0] == 0
        installed = workspace.root / 'install/user/share/user/v'
        assert installed.read_text() == str(number)


def write_interfaces(workspace, name, contained='', further='') -> None:
    text = INTERFACES.format(name=name, contained=contained, further=further)
    workspace.write(f'src/{name}/CMakeLists.txt', text)
    workspace.write(f'src/{name}/msg/{name}.msg', f'{name}\n')


def test_hashes_of_interfaces_follow_what_these_contain(workspace, update):
    contained = workspace.root / 'install/base/share/base/base.msg'
    write_interfaces(workspace, 'base')
    write_interfaces(workspace, 'pair', contained)
    made = workspace.root / 'install/pair/share/pair/hash'
    assert update('pair')[0][0] == 0
    assert made.read_text() == 'pair\nbase\n'
    workspace.write('src/base/msg/base.msg', 'other\n')
    assert update('pair')[0][0] == 0
    assert made.read_text() == 'pair\nother\n'
    # also when that was built before, by another launch
    workspace.write('src/base/msg/base.msg', 'third\n')
    assert update('base')[0][0] == 0
    assert update('pair')[0][1] == {'pair': 'base was rebuilt'}
    assert made.read_text() == 'pair\nthird\n'
    assert update('pair')[0] == [0, {}, ['base', 'pair']]


def test_interfaces_of_a_failed_build_are_not_kept(workspace, update):
    contained = workspace.root / 'install/base/share/base/base.msg'
    write_interfaces(workspace, 'base')
    late = workspace.root / 'late'
    further = f'add_custom_target(t ALL COMMAND cat {late} DEPENDS hash)'
    write_interfaces(workspace, 'pair', contained, further)
    assert update('pair')[0][0] != 0
    late.touch()
    workspace.write('src/base/msg/base.msg', 'other\n')
    assert update('pair')[0][0] == 0
    made = workspace.root / 'install/pair/share/pair/hash'
    assert made.read_text() == 'pair\nother\n'


def test_merged_files_are_known_after_a_second_build(workspace, update):
    install = 'install(FILES tool.txt DESTINATION share)\n'
    folder = workspace.cmake('flow', install=install)
    (folder / 'tool.txt').write_text('tool\n')
    assert update('flow', arguments=('--merge-install',))[0][0] == 0
    (folder / 'flow.in').write_text('')
    assert update('flow')[0][1] == {'flow': 'new file flow.in'}
    (folder / 'flow.in').write_text('1')
    assert update('flow')[0][1] == {'flow': 'flow.in changed'}
    installed = workspace.root / 'install/share/tool.txt'
    installed.unlink()
    result, _ = update('flow')
    assert 'share/tool.txt is missing' in result[1]['flow']
    assert installed.read_text() == 'tool\n'
    (folder / 'CMakeLists.txt').write_text(
        (folder / 'CMakeLists.txt').read_text().replace(install, '')
    )
    assert update('flow')[0][0] == 0
    assert not installed.is_symlink()
    assert update('flow')[0] == [0, {}, ['flow']]
