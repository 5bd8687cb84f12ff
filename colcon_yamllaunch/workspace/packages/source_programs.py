# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The programs and components that a package will have.

They are found as far as its build files say.
"""

from collections.abc import Iterator
from pathlib import Path
from pathlib import PurePosixPath
import re

from colcon_yamllaunch.common.text_files import text_of
from colcon_yamllaunch.workspace.packages.package_folder import cmake_files

_COMMENT = re.compile(r'#.*')
_TARGET = re.compile(
    r'\b(?:ament_auto_)?add_executable\s*\(\s*"?([\w.+-]+)', re.I
)
# rclcpp_components_register_node
_COMPONENT = re.compile(r'\bEXECUTABLE\s+"?([\w.+-]+)')
# rclcpp_components_register_node(TARGET PLUGIN "class" …), and
# rclcpp_components_register_nodes(TARGET "class" …)
_PLUGIN = re.compile(r'\bPLUGIN\s+"?([\w:]+)')
_PLUGINS = re.compile(
    r'\brclcpp_components_register_nodes\s*\(\s*\S+\s+([^)]*)\)', re.I
)
_SCRIPTS = re.compile(
    r'\binstall\s*\(\s*PROGRAMS\s+([^)]*?)\s+(?:DESTINATION|TYPE)\b', re.I
)
_ENTRY = re.compile(r'([\w.-]+)\s*=\s*[\w.]+\s*:\s*\w+')


def source_programs(folder: Path) -> set[str]:
    """
    Return the names of the programs that a package's build would install.

    Names that are only computed by the build are not found.

    :param folder: The source of the package
    """
    found: set[str] = set()
    for name in cmake_files(str(folder))[0]:
        found.update(_in_cmake(text_of(folder / name)))
    for name in ('setup.py', 'setup.cfg'):
        found.update(_in_setup(text_of(folder / name)))
    return found


def source_plugins(folder: Path) -> set[str]:
    """
    Return the components that a package's build would register.

    Names that are only computed by the build are not found.

    :param folder: The source of the package
    """
    found: set[str] = set()
    for name in cmake_files(str(folder))[0]:
        text = _COMMENT.sub('', text_of(folder / name))
        found.update(_PLUGIN.findall(text))
        for words in _PLUGINS.findall(text):
            names = (word.strip('"') for word in words.split())
            found.update(n for n in names if '::' in n and '$' not in n)
    return found


def _in_cmake(text: str) -> Iterator[str]:
    text = _COMMENT.sub('', text)
    for pattern in (_TARGET, _COMPONENT):
        yield from pattern.findall(text)
    for words in _SCRIPTS.findall(text):
        for word in words.split():
            name = PurePosixPath(word.strip('"')).name
            if '$' not in name and '*' not in name:
                yield name


def _in_setup(text: str) -> Iterator[str]:
    _, found, scripts = text.partition('console_scripts')
    # the list ends in setup.py, the next section begins in setup.cfg
    end = re.search(r'\]|^\[', scripts, re.M)
    if found:
        yield from _ENTRY.findall(scripts[: end.start() if end else None])
