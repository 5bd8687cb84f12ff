# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A node is added to a package by lines, and nothing of it is lost."""

from pathlib import Path

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.workspace.create.added_node import (
    add_node,
    AddedNode,
    edits,
)
from colcon_yamllaunch.workspace.packages.package import Package
import pytest

CMAKE = """\
project(a)
# ament_package()
if(X)
endif()

ament_package()
"""
MANIFEST = """\
<package>
  <name>a</name>
  <depend>rclpy</depend>
\t<test_depend>x</test_depend>

  <export/>
</package>
"""
SETUP = """\
setup(
    entry_points={
        'console_scripts': [{entries}],
    },
)
"""


def edited(
    folder: Path, kind: str, node: str, files: dict[str, str]
) -> dict[str, list[str]]:
    """Return the lines that files get, in order; they lose none."""
    for name, text in files.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(text.encode())
    added = AddedNode(
        Package('a', folder, kind), node.removesuffix('.cpp'), '.' in node
    )
    lines = {}
    for name, text in edits(added).items():
        kept = files[name].splitlines()
        lines[name] = []
        for line in text.splitlines():
            if kept and line == kept[0]:
                kept.pop(0)
            else:
                lines[name].append(line.strip())
        assert kept == []
    return lines


@pytest.mark.parametrize(
    ('node', 'lines', 'dependencies'),
    [
        (
            'fan',
            ['install(PROGRAMS scripts/fan.py DESTINATION'],
            None,
        ),
        (
            'fan.cpp',
            [
                'find_package(rclcpp REQUIRED)',
                'add_executable(fan src/fan.cpp)',
                'target_compile_features(fan PUBLIC cxx_std_17)',
                'target_link_libraries(fan rclcpp::rclcpp)',
                'install(TARGETS fan DESTINATION',
            ],
            ['<depend>rclcpp</depend>'],
        ),
    ],
)
def test_package_of_ament_cmake(
    tmp_path: Path,
    node: str,
    lines: list[str],
    dependencies: list[str] | None,
) -> None:
    files = {'CMakeLists.txt': CMAKE, 'package.xml': MANIFEST}
    changed = edited(tmp_path, 'ros.ament_cmake', node, files)
    end = ' lib/${PROJECT_NAME})'
    assert changed['CMakeLists.txt'] == [*lines[:-1], lines[-1] + end, '']
    assert changed.get('package.xml') == dependencies


def test_plain_package(tmp_path: Path) -> None:
    text = 'project(a)\r\ninstall(FILES x)'
    files = {'CMakeLists.txt': text}
    rule = 'install(PROGRAMS scripts/fan.py DESTINATION lib/${PROJECT_NAME})'
    assert edited(tmp_path, 'cmake', 'fan', files) == {
        'CMakeLists.txt': ['', rule]
    }


@pytest.mark.parametrize(
    ('entries', 'expected'),
    [
        ('', "['fan = a.fan:main', ]"),
        ("'x = a.x:main'", "['fan = a.fan:main', 'x = a.x:main']"),
        (
            "\n            'x = a.x:main'\n        ",
            "[\n            'fan = a.fan:main',\n            'x = a.x:main'",
        ),
    ],
)
def test_python_package(tmp_path: Path, entries: str, expected: str) -> None:
    (tmp_path / 'a').mkdir()
    (tmp_path / 'a/__init__.py').touch()
    (tmp_path / 'package.xml').write_text(MANIFEST)
    (tmp_path / 'setup.py').write_text(SETUP.replace('{entries}', entries))
    added = AddedNode(Package('a', tmp_path, 'ros.ament_python'), 'fan', False)
    assert expected in edits(added)['setup.py']


@pytest.mark.parametrize(
    ('kind', 'node', 'file', 'text', 'reason'),
    [
        ('ros.ament_cmake', 'fan', 'CMakeLists.txt', 'x()', 'has no line'),
        ('cmake', 'fan.cpp', 'CMakeLists.txt', 'project(a NONE)', 'no lang'),
        ('python', 'fan', 'setup.py', 'setup(**more)', 'has no list'),
        ('python', 'fan', 'x.py', '', 'cannot read'),
        ('cmake', 'fan', 'scripts/fan.py', '', 'has a node fan.py already'),
    ],
)
def test_what_has_no_place_is_refused(
    tmp_path: Path, kind: str, node: str, file: str, text: str, reason: str
) -> None:
    for name, content in {'a/__init__.py': '', file: text}.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(content)
    before = sorted(tmp_path.rglob('*'))
    package = Package('a', tmp_path, kind)
    added = AddedNode(package, node.removesuffix('.cpp'), '.' in node)
    with pytest.raises(UserError, match=reason):
        add_node(added)
    assert sorted(tmp_path.rglob('*')) == before
    assert (tmp_path / file).read_text() == text
