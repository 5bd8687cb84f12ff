# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The programs that build files name."""

from pathlib import Path

from colcon_yamllaunch.workspace.packages.build_files import (
    source_plugins,
    source_programs,
)
import pytest


@pytest.mark.parametrize(
    ('file', 'text', 'names'),
    [
        ('CMakeLists.txt', 'add_executable(pump src/pump.cpp)', {'pump'}),
        ('src/CMakeLists.txt', 'add_executable(\n  "a-b" x.c)', {'a-b'}),
        ('CMakeLists.txt', '# add_executable(pump x.c)', set()),
        ('CMakeLists.txt', 'add_executable(${NAME} x.c)', set()),
        ('CMakeLists.txt', 'ament_auto_add_executable(pump x.c)', {'pump'}),
        (
            'CMakeLists.txt',
            'rclcpp_components_register_node(lib PLUGIN "a::B" EXECUTABLE b)',
            {'b'},
        ),
        (
            'CMakeLists.txt',
            'install(\n PROGRAMS\n  scripts/a.py "b.sh" ${MORE} # c.py\n'
            ' DESTINATION lib/${PROJECT_NAME})',
            {'a.py', 'b.sh'},
        ),
        ('CMakeLists.txt', 'install(FILES a.py DESTINATION x)', set()),
        (
            'setup.py',
            "entry_points={'console_scripts': ['a = p.a:main', 'b=p:b']}, x=y",
            {'a', 'b'},
        ),
        (
            'setup.cfg',
            '[options.entry_points]\nconsole_scripts =\n  a = p.a:main\n'
            '[tool]\nb = c:d\n',
            {'a'},
        ),
    ],
)
def test_programs(
    tmp_path: Path, file: str, text: str, names: set[str]
) -> None:
    path = tmp_path / file
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    assert source_programs(tmp_path).names == names


@pytest.mark.parametrize(
    ('text', 'names'),
    [
        (
            'rclcpp_components_register_node(l PLUGIN "a::B" EXECUTABLE b)',
            {'a::B'},
        ),
        ('rclcpp_components_register_node(l\n PLUGIN a::b::C)', {'a::b::C'}),
        (
            'rclcpp_components_register_nodes(l "a::B"\n  "a::C")\n',
            {'a::B', 'a::C'},
        ),
        ('rclcpp_components_register_nodes(l "${N}::B")', set()),
        ('# rclcpp_components_register_nodes(l "a::B")', set()),
    ],
)
def test_components(tmp_path: Path, text: str, names: set[str]) -> None:
    (tmp_path / 'CMakeLists.txt').write_text(text)
    assert source_plugins(tmp_path) == names


@pytest.mark.parametrize(
    ('text', 'names'),
    [
        (
            'project(pump CXX)\nadd_executable(${PROJECT_NAME}_node x.c)',
            'pump_node',
        ),
        (
            'project("pump")\nset(EXE ${PROJECT_NAME}_node)\n'
            'rclcpp_components_register_node(lib EXECUTABLE "${EXE}_exe")',
            'pump_node_exe',
        ),
        (
            'if(A)\nset(X a)\nelse()\nset(X b)\nendif()\nadd_executable(${X})',
            'a b',
        ),
        (
            'foreach(x a b)\nadd_executable(${x}_${x} ${x}.c)\nendforeach()',
            'a_a b_b',
        ),
        (
            'set(ALL a)\nlist(APPEND ALL b c)\nlist(APPEND MORE d)\n'
            'foreach(x IN LISTS ALL MORE ITEMS e)\nforeach(y 1 2)\n'
            'add_executable(${x}${y})\nendforeach()\nendforeach()',
            'a1 a2 b1 b2 c1 c2 d1 d2 e1 e2',
        ),
        (
            'function(program name)\nadd_executable(${name}_node ${ARGN})\n'
            'endfunction()\nprogram(a a.c)\nPROGRAM(b)',
            'a_node b_node',
        ),
        (
            'macro(programs)\nforeach(x ${ARGN})\nadd_executable(${x})\n'
            'endforeach()\nendmacro()\nprograms(a b)',
            'a b',
        ),
        (
            'foreach(file src/a.cpp src/b.x.cpp)\n'
            'get_filename_component(name ${file} NAME_WE)\n'
            'add_executable(${name} ${file})\nendforeach()',
            'a b',
        ),
        (
            'add_executable(a a.c)\n'
            'set_target_properties(a PROPERTIES OUTPUT_NAME b)',
            'a b',
        ),
        (
            '#[[ add_executable(a) ]]\nset(X "# none")\nadd_executable(b)',
            'b',
        ),
        ('add_executable(a', ''),
    ],
)
def test_names_that_cmake_computes(
    tmp_path: Path, text: str, names: str
) -> None:
    (tmp_path / 'CMakeLists.txt').write_text(text)
    found = source_programs(tmp_path)
    assert found.names == set(names.split())
    assert not found.may_have('zzz')


def test_functions_and_variables_of_another_file(tmp_path: Path) -> None:
    folder = tmp_path / 'cmake'
    folder.mkdir()
    (tmp_path / 'CMakeLists.txt').write_text(
        'project(p)\ninclude(cmake/own.cmake)\nprogram(${PREFIX}_a)\n'
    )
    (folder / 'own.cmake').write_text(
        'set(PREFIX ${PROJECT_NAME})\n'
        'function(program name)\nadd_executable(${name}_x)\nendfunction()\n'
    )
    assert source_programs(tmp_path).names == {'p_a_x'}


@pytest.mark.parametrize(
    ('text', 'may_be', 'may_not_be'),
    [
        ('add_executable(${NAME}_node x.c)', 'pump_node', 'pump'),
        ('add_executable($<1:a>)', 'pump', None),
        ('add_executable(${${A}_B})', 'pump', None),
        ('string(TOUPPER a X)\nadd_executable(x${X})', 'xA', 'A'),
        (
            'foreach(i RANGE 3)\nadd_executable(x${i})\nendforeach()',
            'x2',
            'y2',
        ),
        (
            'set(X a)\nstring(APPEND X b)\nadd_executable(${X}_c)',
            'ab_c',
            'ab',
        ),
        ('find_package(nodes)\nadd_node(src/pump.cpp)', 'pump_node', 'node'),
        ('register_all(NAMES "pump" tap)', 'run_tap', 'run'),
        # what a pattern finds are files of the source
        (
            'file(GLOB X *.py)\ninstall(PROGRAMS ${X} ${B}/a TYPE BIN)',
            'a',
            'pump',
        ),
    ],
)
def test_names_that_cannot_be_known(
    tmp_path: Path, text: str, may_be: str, may_not_be: str | None
) -> None:
    (tmp_path / 'CMakeLists.txt').write_text(text)
    found = source_programs(tmp_path)
    assert found.may_have(may_be)
    assert may_not_be is None or not found.may_have(may_not_be)


@pytest.mark.parametrize(
    'text',
    [
        'macro(a x)\na(${x}${x})\na(b)\nendmacro()\na(c)',
        'set(A a b c d e f g h)\n' + 'set(A ${A}${A} ${A})\n' * 40,
        'foreach(a ${x})\n' * 300,
    ],
)
def test_files_with_many_values_end(tmp_path: Path, text: str) -> None:
    (tmp_path / 'CMakeLists.txt').write_text(text + '\nadd_executable(last)')
    assert 'last' in source_programs(tmp_path).names


@pytest.mark.parametrize(
    ('line', 'name', 'has_it'),
    [
        ("[f'{NAME}_node = p:main']", 'pump_node', True),
        ("[NAME + '_node = p:main']", 'pump_node', True),
        ("[f'{NAME}_node = p:main']", 'pump', False),
        ("[f'{n} = p.{n}:main' for n in NODES]", 'pump', True),
        ("['%s = p:main' % n]", 'pump', True),
        ("['tap = p:main']", 'pump', False),
    ],
)
def test_entry_points_that_are_computed(
    tmp_path: Path, line: str, name: str, *, has_it: bool
) -> None:
    text = f"NAME = 'pump'\nsetup(entry_points={{'console_scripts': {line}}})"
    (tmp_path / 'setup.py').write_text(text)
    assert source_programs(tmp_path).may_have(name) is has_it
