# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Adding a node to a package.

Files that a user wrote get lines, and lose none. What has another form than
that of `ros2 pkg create` and `colcon create` is refused.
"""

import ast
from contextlib import suppress
import os
from pathlib import Path
import re

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.create.new_package import (
    class_name,
    client_library,
    module_name,
    node_template,
    write_file,
)
from colcon_yamllaunch.workspace.packages.build_files import source_programs
from colcon_yamllaunch.workspace.packages.package import Package

_AMENT_PACKAGE = re.compile(r'^ament_package\(', re.M)
_NO_LANGUAGES = re.compile(r'^project\s*\([^)]*\bNONE\b', re.M | re.I)
_CONSOLE_SCRIPTS = re.compile(
    r"""^([ \t]*)(['"])console_scripts\2\s*:\s*\[[ \t]*(\n([ \t]*)['"])?""",
    re.M,
)
_DEPEND = r'<(?:depend|exec_depend|build_depend|run_depend)\b[^>]*>\s*{}\s*<'


@dataclass(frozen=True, slots=True)
class AddedNode:
    """
    A node that is to be added.

    :param node: Its name
    :param is_cpp: Whether it is written in C++; else it is in Python
    """

    package: Package
    node: str
    is_cpp: bool

    @property
    def is_ros(self) -> bool:
        """Whether it is one of ROS: where its package is."""
        return 'ament' in self.package.type

    @property
    def is_script(self) -> bool:
        """Whether it is a script that CMake installs."""
        return not self.is_cpp and not self.package.type.endswith('python')

    @property
    def executable(self) -> str:
        """The name by which it is run and launched."""
        return f'{self.node}.py' if self.is_script else self.node

    @property
    def path(self) -> str:
        """
        Where its code is, in the package.

        :raises UserError: when the package has no place for it
        """
        if self.is_cpp:
            return f'src/{self.node}.cpp'
        if self.is_script:
            return f'scripts/{self.node}.py'
        name = self.package.name
        for module in (name, module_name(name)):
            if os.path.isfile(self.package.path / module / '__init__.py'):
                return f'{module}/{self.node}.py'
        raise UserError(
            f'{name} has no folder {name} with __init__.py for its modules: '
            'nothing was changed'
        )


def add_node(added: AddedNode) -> list[str]:
    """
    Write the code of a node, and what makes it part of its package.

    :returns: The files that were made and changed, the new one first
    :raises UserError: when that cannot be; then nothing was changed
    """
    folder = added.package.path
    file = folder / added.path
    if (
        os.path.exists(file)
        or added.executable in source_programs(folder).names
    ):
        raise UserError(
            f'{added.package.name} has a node {added.executable} already: '
            'nothing was changed'
        )
    changed = edits(added)
    before = {name: (folder / name).read_bytes() for name in changed}
    values = {
        'node': added.node,
        'class_name': class_name(added.node),
        'is_script': added.is_script,
    }
    try:
        file.parent.mkdir(exist_ok=True)
        template = node_template(is_ros=added.is_ros, is_cpp=added.is_cpp)
        write_file(file, template, values)
        for name, text in changed.items():
            (folder / name).write_bytes(text.encode())
    except OSError as e:
        with suppress(OSError):
            file.unlink(missing_ok=True)
            for name, content in before.items():
                (folder / name).write_bytes(content)
        raise UserError(f'cannot write {e.filename}: {e.strerror}') from e
    return [added.path, *changed]


def edits(added: AddedNode) -> dict[str, str]:
    """
    Return the files of a package that change, as they are to be.

    :raises UserError: when one has no place for what is to be added
    """
    folder = added.package.path
    changed = {}
    if added.package.type.endswith('python'):
        changed['setup.py'] = _with_entry(added, _read(folder / 'setup.py'))
    else:
        text = _read(folder / 'CMakeLists.txt')
        changed['CMakeLists.txt'] = _with_rule(added, text)
    library = client_library(added.is_cpp)
    if added.is_ros:
        text = _read(folder / 'package.xml')
        if not re.search(_DEPEND.format(library), text):
            changed['package.xml'] = _with_dependency(text, library, folder)
    return changed


def _read(path: Path) -> str:
    try:
        return path.read_bytes().decode('utf-8')
    except (OSError, UnicodeDecodeError) as e:
        raise UserError(f'cannot read {path}: nothing was changed') from e


def _with_rule(added: AddedNode, text: str) -> str:
    """Return a CMakeLists.txt that builds and installs the node."""
    node = added.node
    where = added.package.path / 'CMakeLists.txt'
    if added.is_cpp and _NO_LANGUAGES.search(text):
        raise UserError(
            'it has no languages: nothing was changed',
            f"write 'project({added.package.name})' there first",
            place=str(where),
        )
    lines = []
    if added.is_cpp:
        if added.is_ros and not re.search(r'find_package\s*\(rclcpp\b', text):
            lines.append('find_package(rclcpp REQUIRED)')
        lines += [
            f'add_executable({node} {added.path})',
            f'target_compile_features({node} PUBLIC cxx_std_17)',
        ]
        if added.is_ros:
            lines.append(f'target_link_libraries({node} rclcpp::rclcpp)')
    what = f'TARGETS {node}' if added.is_cpp else f'PROGRAMS {added.path}'
    lines.append(f'install({what} DESTINATION lib/${{PROJECT_NAME}})')
    rule = '\n'.join(lines) + '\n'
    if not added.is_ros:
        return f'{text.rstrip()}\n\n{rule}'
    ends = list(_AMENT_PACKAGE.finditer(text))
    if len(ends) != 1:
        raise UserError(
            "it has no line 'ament_package()' to add the node in front of",
            f'add this yourself:\n{rule}',
            place=str(where),
        )
    return f'{text[: ends[0].start()]}{rule}\n{text[ends[0].start() :]}'


def _with_entry(added: AddedNode, text: str) -> str:
    """Return a setup.py with an entry point for the node."""
    module = added.path.removesuffix('.py').replace('/', '.')
    entry = f"'{added.node} = {module}:main',"
    found = list(_CONSOLE_SCRIPTS.finditer(text))
    if len(found) == 1:
        match = found[0]
        if match[3] is None:
            at = match.end()
            new = f'{text[:at]}{entry} {text[at:]}'
        else:
            at = match.start(3)
            new = f'{text[:at]}\n{match[4]}{entry}{text[at:]}'
        if _has_entry(new, entry.strip("',")):
            return new
    raise UserError(
        "it has no list 'console_scripts' to add the node to: nothing was "
        'changed',
        f'add {entry} to the entry_points yourself',
        place=str(added.package.path / 'setup.py'),
    )


def _has_entry(text: str, entry: str) -> bool:
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError, RecursionError):
        return False
    return any(
        isinstance(node, ast.List)
        and any(getattr(item, 'value', None) == entry for item in node.elts)
        for node in ast.walk(tree)
    )


def _with_dependency(text: str, library: str, folder: Path) -> str:
    """Return a package.xml that depends on a package."""
    depends = list(
        re.finditer(r'^([ \t]*)<\w*depend\b.*</\w*depend>[ \t]*\n', text, re.M)
    )
    if depends:
        last = depends[-1]
        line = f'{last[1]}<depend>{library}</depend>\n'
        return text[: last.end()] + line + text[last.end() :]
    end = re.search(r'^[ \t]*(<export>|</package>)', text, re.M)
    if end is None:
        raise UserError(
            'it has no line with </package>: nothing was changed',
            'end it with </package>',
            place=str(folder / 'package.xml'),
        )
    line = f'  <depend>{library}</depend>\n'
    return text[: end.start()] + line + text[end.start() :]
