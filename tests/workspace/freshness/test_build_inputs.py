# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a build reads, be its path as odd as can be."""

import struct
import subprocess

from colcon_yamllaunch.workspace.freshness.build_inputs import BuildInputs
from colcon_yamllaunch.workspace.freshness.build_record import (
    BuildMode,
    relevant_environment,
)
from colcon_yamllaunch.workspace.packages.build_files import only_installs
import pytest
from support.package_builds import PackageBuilds

pytestmark = pytest.mark.hostile

NAMES = ('a b', 'a(b)', "a'b", 'a#b', 'a$b', 'a%b', 'a&b', 'a;b', 'a:b')


def for_make(path: str) -> str:
    """Escape a path as GCC and CMake do."""
    path = path.replace('$', '$$')
    return path.replace(' ', '\\ ').replace('#', '\\#')


def for_ninja(path: str) -> str:
    for special in '$ :':
        path = path.replace(special, f'${special}')
    return path


def ninja_rule(path: str) -> str:
    return f'build x: CC main.c | {for_ninja(path)}\n'


def rule(path: str) -> str:
    return (
        f'x.o: {for_make("/usr/x.h")} \\\n  {for_make(path)} \\\n /usr/y.h\n'
    )


def ninja_log(path: str) -> bytes:
    data = path.encode() + b'\0' * (-len(path.encode()) % 4)
    record = struct.pack('<I', len(data) + 4) + data + b'\xff\xff\xff\xff'
    return b'# ninjadeps\n\x04\0\0\0' + record


@pytest.mark.parametrize('name', NAMES)
@pytest.mark.parametrize(
    ('file', 'written'),
    [
        ('x.dir/main.c.o.d', rule),
        ('x.dir/compiler_depend.make', rule),
        ('x.dir/depend.make', rule),
        ('x.dir/build.make', lambda path: f'x: {for_make(path)}\n\tcc $@\n'),
        (
            'build.ninja',
            lambda path: f'build x: CC main.c | {for_ninja(path)}',
        ),
        ('.ninja_deps', ninja_log),
        ('CMakeFiles/Makefile.cmake', lambda path: f'set(x\n  "{path}"\n)\n'),
    ],
)
def test_a_header_of_another_package(tmp_path, name, file, written):
    header = tmp_path / 'src' / name / 'include/x.h'
    header.parent.mkdir(parents=True)
    header.touch()
    text = written(str(header))
    path = tmp_path / 'build/flow' / file
    path.parent.mkdir(parents=True)
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    source = tmp_path / 'src/flow'
    inputs = BuildInputs(source, tmp_path / 'build/flow')
    assert inputs.external_files([source, tmp_path / 'build']) == [header]


def test_a_file_that_a_command_reads(tmp_path):
    path = tmp_path / 'tool.py'
    path.touch()
    build = tmp_path / 'build'
    build.mkdir()
    (build / 'build.make').write_text(f'x:\n\tcd / && python {path} >x\n')
    assert BuildInputs(tmp_path / 'src', build).external_files([build]) == [
        path
    ]


@pytest.fixture
def builds(tmp_path):
    return PackageBuilds(tmp_path)


def why(builds: PackageBuilds, **variables: str) -> str:
    builds.variables = variables
    return builds.why


@pytest.mark.parametrize(
    ('code', 'name'),
    [
        ('set(x $ENV{LEVEL})', 'LEVEL'),
        ('if(DEFINED ENV{LEVEL})', 'LEVEL'),
        ('find_path(x y.h HINTS ENV LEVEL)', 'LEVEL'),
        ('find_package(Odd+1 REQUIRED)', 'Odd+1_DIR'),
        ('find_package( Odd )', 'Odd_ROOT'),
        ('find_package(Odd)', 'ODD_ROOT'),
        ('find_dependency(Odd)', 'Odd_DIR'),
    ],
)
def test_a_variable_that_cmake_files_look_for(builds, code, name):
    builds.write('src/flow/cmake/x.cmake', code)
    builds.build()
    assert why(builds) == ''
    assert why(builds, OTHER='1') == ''
    assert why(builds, **{name: '1'}) == f'{name} changed in the environment'
    assert builds.decide().mode is BuildMode.CLEAN
    builds.build()
    assert builds.why == ''
    assert why(builds, **{name: '2'}) == f'{name} changed in the environment'
    assert why(builds) == f'{name} changed in the environment'


def test_a_variable_of_what_the_package_finds(builds):
    config = builds.write('elsewhere/oddConfig.cmake', 'set(x $ENV{LEVEL})')

    def configure():
        builds.write('build/flow/Makefile.cmake', f'"{config}"')
        builds.write('build/flow/CMakeCache.txt', 'Deep_DIR:PATH=/x\n')

    builds.build(configure)
    for name in ('LEVEL', 'Deep_DIR', 'Deep_ROOT'):
        changed = f'{name} changed in the environment'
        assert why(builds, **{name: '1'}) == changed


def test_the_own_install_space_in_a_variable_does_not_matter(builds):
    builds.write('src/flow/x.cmake', 'set(x $ENV{LEVEL} $ENV{PWD})')
    builds.build()
    assert why(builds, LEVEL=str(builds.products.install_base / 'flow')) == ''
    assert why(builds, PWD='/x') == ''


@pytest.mark.parametrize(
    'name',
    ['CPLUS_INCLUDE_PATH', 'C_INCLUDE_PATH', 'CPATH', 'LIBRARY_PATH', 'FC'],
)
def test_variables_of_compilers(tmp_path, name):
    before = relevant_environment({}, tmp_path)
    assert relevant_environment({name: '/x'}, tmp_path) != before


def test_a_new_header_that_may_come_first(builds):
    used = builds.root / 'src/flow/second/x.h'

    def compiler():
        builds.write('build/flow/x.d', f'x.o: {used}\n')

    builds.write('src/flow/second/x.h')
    builds.build(compiler)
    assert builds.why == ''
    builds.write('src/flow/first/y.h')
    assert builds.decide().mode is BuildMode.CONFIGURE
    builds.write('src/flow/first/x.h')
    assert builds.decide().mode is BuildMode.CLEAN


ODD = """\
cmake_minimum_required(VERSION 3.16)
project(odd C)
add_executable(odd main.c)
target_include_directories(odd PRIVATE first)
target_compile_definitions(odd PRIVATE LEVEL=$ENV{ODD_LEVEL}+0)
install(TARGETS odd DESTINATION lib/odd)
"""
FOLDER = "It's (my) #1 $ folder"


def test_a_program_of_all_of_these(workspace, update):
    workspace.write('src/odd/CMakeLists.txt', ODD)
    workspace.write(f'src/{FOLDER}/x.h', '#define X 1\n')
    workspace.write('src/odd/second/y.h', '#define Y 1\n')
    (workspace.root / 'src/odd/first').mkdir()
    workspace.write(
        'src/odd/main.c',
        f'#include <stdio.h>\n#include "../{FOLDER}/x.h"\n'
        '#if __has_include("y.h")\n#include "y.h"\n'
        '#else\n#include "second/y.h"\n#endif\n'
        'int main(void) { return printf("%d %d %d", X, Y, LEVEL) < 0; }\n',
    )

    def run(**variables):
        (returncode, _, _), output = update('odd', **variables)
        assert returncode == 0, output
        program = workspace.root / 'install/odd/lib/odd/odd'
        done = subprocess.run([program], capture_output=True, text=True)
        return done.stdout

    assert run() == '1 1 0'
    workspace.write(f'src/{FOLDER}/x.h', '#define X 2\n')
    assert run() == '2 1 0'
    workspace.write('src/odd/first/y.h', '#define Y 2\n')
    assert run() == '2 2 0'
    assert run(ODD_LEVEL='3') == '2 2 3'
    first = workspace.root / 'first'
    first.mkdir()
    (first / 'stdio.h').write_text(
        '#include_next <stdio.h>\n#undef LEVEL\n#define LEVEL 4\n'
    )
    assert run(ODD_LEVEL='3', C_INCLUDE_PATH=str(first)) == '2 2 4'


@pytest.mark.parametrize(
    ('text', 'expected'),
    [
        ('', True),
        ('find_package(ament_cmake REQUIRED)\nament_package()', True),
        ('if(BUILD_TESTING)\n  add_test(NAME x COMMAND y)\nendif()', True),
        ('set(files a.py)\ninstall(FILES ${files} DESTINATION x)', True),
        ('# find_package(other)', True),
        # what may find, compile, run or read something of another package
        ('find_package(other)', False),
        ('FIND_PACKAGE(${name})', False),
        ('find_package(ament_cmake)\nfind_package(\n  "other")', False),
        ('find_program(x y)', False),
        ('add_executable(x x.c)', False),
        ('add_custom_target(x ALL COMMAND y)', False),
        ('include(other)', False),
        ('set(CMAKE_PROJECT_INCLUDE x)', False),
        ('install(FILES ${other_DIR}/x DESTINATION x)', False),
        ('install(FILES ../other/x DESTINATION x)', False),
        ('install(FILES /ws/install/other/x DESTINATION x)', False),
        ('install(FILES $ENV{OTHER}/x DESTINATION x)', False),
        ('install(CODE "x")', False),
        ('foreach(x IN LISTS CMAKE_PREFIX_PATH)\nendforeach()', False),
        ('set(x $<TARGET_FILE:other>)', False),
    ],
)
def test_a_build_that_only_installs_needs_no_other_package(
    tmp_path, text, expected
):
    install = 'install(PROGRAMS scripts/a.py DESTINATION lib/${PROJECT_NAME})'
    text = f'cmake_minimum_required(VERSION 3.16)\nproject(a)\n{text}\n'
    (tmp_path / 'CMakeLists.txt').write_text(text + install)
    assert only_installs(tmp_path, ['other']) == expected
    # what installs may be what is changed
    assert not only_installs(tmp_path, ['other', 'ament_cmake_core'])
    # whatever stands in another file of it counts, too
    (tmp_path / 'more.cmake').write_text('find_library(x y)')
    assert not only_installs(tmp_path, ['other'])


def test_a_package_without_cmake_files_is_not_known(tmp_path):
    assert not only_installs(tmp_path, [])
