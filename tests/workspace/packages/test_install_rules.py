# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Whether build files spell out which scripts they install."""

from pathlib import Path

from colcon_yamllaunch.workspace.packages.build_files import names_all_programs
import pytest

PLAIN = """
cmake_minimum_required(VERSION 3.16)
project(my_pkg)
find_package(ament_cmake REQUIRED)
include(CTest)  # include(more.cmake)
add_executable(pump src/pump.cpp)
install(TARGETS pump DESTINATION lib/${PROJECT_NAME})
install(PROGRAMS scripts/a.py
  DESTINATION lib/${PROJECT_NAME})
install(DIRECTORY launch DESTINATION share/${PROJECT_NAME})
ament_package()
"""
SETUP = """
from setuptools import setup
setup(
    name=package_name,
    entry_points={'console_scripts': ['a = p.a:main', f'b = {p}.b:main']},
    scripts=['scripts/c.sh'],
    data_files=[
        (f'share/{package_name}/config', glob('config/*')),
        (os.path.join('share', package_name), ['package.xml']),
    ],
)
"""


@pytest.mark.parametrize(
    ('more', 'is_known'),
    [
        ('', True),
        ('set(OTHER x)\nif(BUILD_TESTING)\nendif()', True),
        ('install(PROGRAMS ${SCRIPTS} DESTINATION lib/x)', False),
        ('install(PROGRAMS scripts/${NAME}.py DESTINATION x)', False),
        ('install(DIRECTORY scripts/ DESTINATION lib/my_pkg)', False),
        ('install(DIRECTORY x DESTINATION ${CMAKE_INSTALL_LIBDIR})', False),
        ('install(CODE "x")', False),
        ('add_executable(${PROJECT_NAME}_node x.cpp)', False),
        ('my_macro(x)', False),
        ('file(GLOB scripts scripts/*.py)', False),
        ('include(more.cmake)', False),
        ('rclcpp_components_register_node(x EXECUTABLE y)', False),
    ],
)
def test_cmake_that_tells_all_programs(
    tmp_path: Path, more: str, is_known: bool
) -> None:
    path = tmp_path / 'CMakeLists.txt'
    path.write_text(PLAIN + more)
    assert names_all_programs(tmp_path) is is_known


@pytest.mark.parametrize(
    ('old', 'new', 'is_known'),
    [
        ('', '', True),
        ("'a = p.a:main'", "name + ' = p.a:main'", False),
        ("'a = p.a:main'", "f'{name} = p.a:main'", False),
        ("['scripts/c.sh']", "glob('scripts/*')", False),
        ("['scripts/c.sh']", 'SCRIPTS', False),
        ("f'share/{package_name}/config'", "'lib/' + package_name", False),
        ('name=package_name', '**arguments', False),
        ('name=package_name', 'cmdclass=more', False),
        ('setup(', 'configure(', False),
        ('setup(', 'setup((', False),
    ],
)
def test_setup_that_tells_all_programs(
    tmp_path: Path, old: str, new: str, is_known: bool
) -> None:
    (tmp_path / 'setup.py').write_text(SETUP.replace(old, new))
    assert names_all_programs(tmp_path) is is_known
    (tmp_path / 'setup.cfg').write_text('[options.data_files]\n')
    assert not names_all_programs(tmp_path)
