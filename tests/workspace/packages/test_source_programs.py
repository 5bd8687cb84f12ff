# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The programs that build files name."""

from pathlib import Path

from colcon_yamllaunch.workspace.packages.source_programs import source_plugins
from colcon_yamllaunch.workspace.packages.source_programs import (
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
    assert source_programs(tmp_path) == names
