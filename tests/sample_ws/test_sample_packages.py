# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The files of sample_ws, without building or running anything."""

from pathlib import Path
import re
import sys

from catkin_pkg.package import parse_package
import pytest
import yaml

SAMPLE_WS = Path(__file__).parents[2] / 'sample_ws'
PROGRAMS = (
    'flow/scripts/inspect.sh',
    'src/my_pkg/scripts/counter.py',
    'src/my_pkg/scripts/double.py',
    'src/my_pkg/scripts/gauge.py',
    'src/my_pkg/scripts/throttle.py',
)
LAUNCH_FILES = (
    'flow/launch/flow.yaml',
    'src/my_pkg/launch/demo.yaml',
    'src/my_pkg/launch/gauge.yaml',
    'src/my_pkg/launch/throttle.yaml',
    'src/my_py_pkg/launch/square.yaml',
    'talk/launch/talk.yaml',
)


@pytest.mark.parametrize('name', ['my_pkg', 'my_py_pkg'])
def test_manifest_is_valid(name: str) -> None:
    warnings: list[str] = []
    package = parse_package(SAMPLE_WS / 'src' / name, warnings=warnings)
    assert package.name == name
    assert package.package_format == 3
    assert warnings == []


def test_manifest_declares_what_demo_uses() -> None:
    package = parse_package(SAMPLE_WS / 'src/my_pkg')
    names = {depend.name for depend in package.exec_depends}
    assert names == {'flow', 'rclpy', 'std_msgs'}


def test_flow_has_nothing_of_ros() -> None:
    assert not (SAMPLE_WS / 'flow/package.xml').exists()
    cmake = (SAMPLE_WS / 'flow/CMakeLists.txt').read_text()
    assert 'find_package' not in cmake


def test_talk_needs_only_python() -> None:
    package = SAMPLE_WS / 'talk'
    assert not (package / 'package.xml').exists()
    assert not (package / 'CMakeLists.txt').exists()
    for module in package.rglob('*.py'):
        for name in re.findall(r'^(?:from|import) (\w+)', module.read_text()):
            allowed = {'setuptools', 'talk', *sys.stdlib_module_names}
            assert name in allowed, module


@pytest.mark.parametrize('path', PROGRAMS)
def test_program_is_executable_and_installed(path: str) -> None:
    program = SAMPLE_WS / path
    assert program.stat().st_mode & 0o111 == 0o111
    assert program.read_text().startswith('#!')
    package = program.parents[1]
    cmake = (package / 'CMakeLists.txt').read_text()
    assert str(program.relative_to(package)) in cmake


@pytest.mark.parametrize('path', LAUNCH_FILES)
def test_launch_file_has_one_root_key(path: str) -> None:
    content = yaml.safe_load((SAMPLE_WS / path).read_text())
    assert list(content) == ['launch']
    assert all(len(entry) == 1 for entry in content['launch'])


def test_demo_shows_every_kind_of_entry() -> None:
    path = SAMPLE_WS / 'src/my_pkg/launch/demo.yaml'
    entries = yaml.safe_load(path.read_text())['launch']
    kinds = {kind for entry in entries for kind in entry}
    assert kinds == {'arg', 'executable', 'group', 'include'}
    group = next(entry['group'] for entry in entries if 'group' in entry)
    kinds = {kind for entry in group for kind in entry}
    assert kinds == {'node', 'push_ros_namespace'}
