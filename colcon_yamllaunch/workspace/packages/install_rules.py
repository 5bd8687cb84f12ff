# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Whether build files spell out which scripts they install."""

import ast
from pathlib import Path
import re

from colcon_yamllaunch.common.text_files import text_of
from colcon_yamllaunch.workspace.packages.package_folder import cmake_files

_COMMENT = re.compile(r'#.*')
_COMMAND = re.compile(r'^[ \t]*(\w+)\s*\(([^()]*)', re.M)
#: Commands of CMake that install nothing unless their arguments say so.
_KNOWN_COMMANDS = re.compile(
    r'cmake_minimum_required|project|find_package|set|option|message'
    r'|if|elseif|else|endif|enable_testing|add_test|set_tests_properties'
    r'|add_executable|add_library|add_compile_options|add_subdirectory'
    r'|include_directories|link_directories|target_\w+|include|install'
    r'|rosidl_generate_interfaces|rosidl_target_interfaces'
    r'|ament_target_dependencies|ament_package|ament_export_\w+'
    r'|ament_lint_auto_find_test_dependencies|ament_add_\w*test\w*'
    r'|ament_python_install_package'
)
_KNOWN_MODULES = ('CTest', 'GNUInstallDirs')
_KNOWN_VARIABLES = ('${PROJECT_NAME}', '${CMAKE_CURRENT_SOURCE_DIR}')
#: What declares the build of a Python package, beside its `setup.py`.
_DECLARATIONS = ('setup.cfg', 'pyproject.toml')
_COMPUTED = re.compile('(?:data|script)[_-]files')
#: The arguments of `setup()` that name programs.
_NAMING = ('entry_points', 'scripts')


def spells_out_programs(folder: Path) -> bool:
    """
    Tell whether a build installs no script but those whose names it spells.

    Then the files that describe the build do nothing but what is known: other
    commands of CMake, variables and patterns may come to any name.

    :param folder: The source of the package
    """
    cmake = [text_of(folder / n) for n in cmake_files(str(folder))[0]]
    if cmake:
        return all(_is_plain_cmake(_COMMENT.sub('', text)) for text in cmake)
    if any(_COMPUTED.search(text_of(folder / n)) for n in _DECLARATIONS):
        return False
    return _is_plain_setup(text_of(folder / 'setup.py'))


def _is_plain_cmake(text: str) -> bool:
    for word, written in _COMMAND.findall(text):
        command, arguments = word.lower(), written
        for variable in _KNOWN_VARIABLES:
            arguments = arguments.replace(variable, '')
        if (
            not _KNOWN_COMMANDS.fullmatch(command)
            or (command == 'include' and written.strip() not in _KNOWN_MODULES)
            or (command == 'add_executable' and '$' in written.split()[0])
            or (command == 'install' and not _is_plain_rule(arguments))
        ):
            return False
    return True


def _is_plain_rule(arguments: str) -> bool:
    kind = arguments.split(maxsplit=1)[:1]
    if '$' in arguments or kind in (['CODE'], ['SCRIPT']):
        return False
    # in a folder that is installed to the programs, any file may be one
    _, _, destination = arguments.partition('DESTINATION')
    folder = destination.strip().strip('"')
    return kind != ['DIRECTORY'] or folder.startswith(('share', 'include'))


def _is_plain_setup(text: str) -> bool:
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError, RecursionError):
        return False
    calls = [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id == 'setup'
    ]
    return len(calls) == 1 and all(
        keyword.arg not in (None, 'cmdclass')
        and (keyword.arg not in _NAMING or _is_named(keyword.value))
        and (keyword.arg != 'data_files' or _is_data(keyword.value))
        for keyword in calls[0].keywords
    )


def _is_named(node: ast.AST | None) -> bool:
    """Tell whether texts begin with what is no variable: `name = …`."""
    if isinstance(node, (ast.List, ast.Tuple)):
        return all(map(_is_named, node.elts))
    if isinstance(node, ast.Dict):
        return all(map(_is_named, node.values))
    if isinstance(node, ast.JoinedStr):
        first = node.values[0]
        return isinstance(first, ast.Constant) and '=' in str(first.value)
    return isinstance(node, ast.Constant)


def _is_data(files: ast.expr) -> bool:
    """Tell whether files are installed to folders that have no programs."""
    if not isinstance(files, ast.List):
        return False
    for item in files.elts:
        folder = item.elts[0] if isinstance(item, ast.Tuple) else item
        texts = (n for n in ast.walk(folder) if isinstance(n, ast.Constant))
        first = next(texts, None)
        if first is None or not str(first.value).startswith('share'):
            return False
    return True
