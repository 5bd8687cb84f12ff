# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What CMake files and `setup.py` say, without running them.

This is the only reader of build files. It finds the programs, components and
names of packages before they are built, and what a build may read.
"""

import ast
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from itertools import pairwise, product, takewhile
from math import prod
import os
from pathlib import Path, PurePosixPath
import re
from typing import NamedTuple

from colcon_yamllaunch.common.files import text_of
from colcon_yamllaunch.workspace.packages.package_index import cmake_files
from colcon_yamllaunch.workspace.packages.python_modules import (
    last_name,
    parsed,
    text_in,
)

#: How many values a variable may come to.
MAXIMUM_VALUES = 100
#: How long a value may be (characters).
MAXIMUM_LENGTH = 1000

# stands for whatever cannot be known
_ANY = '\0'
_COMMENT = re.compile(
    r'#\[(=*)\[.*?\]\1\]|("(?:\\.|[^"\\])*")|#[^\n]*', re.DOTALL
)
_COMMENT_LINE = re.compile(r'^\s*#.*$', re.MULTILINE)
_COMMAND = re.compile(r'([A-Za-z_]\w*)\s*\(')
_ARGUMENT = re.compile(r'"((?:\\.|[^"\\])*)"|([()])|([^\s()"]+)', re.DOTALL)
_VARIABLE = re.compile(r'\$\{([\w.+/-]+)\}')
# the environment, what the generator computes, nested variables
_OTHER_VALUE = re.compile(r'\$(?:ENV|CACHE)?\{[^}]*\}|\$<.*')
_KEYWORD = re.compile(r'[A-Z][A-Z_]+')
# the arguments that name a program
_NAMING = ('EXECUTABLE', 'OUTPUT_NAME', 'RENAME')
# what sets a variable to something that is not known
_COMPUTING = re.compile(
    r'cmake_(parse_arguments|path)|execute_process|file|function|list|macro|'
    r'math|string|find_(file|path|program)|'
    r'get_(filename_component|property|target_property)'
)
# what brings no program but those that it names
_HARMLESS = re.compile(
    r'(ament|catkin|cmake|find|get|include|link|pluginlib|rclcpp|rosidl|set|'
    r'target)_\w+|add_(compile_definitions|compile_options|custom_command|'
    r'custom_target|definitions|dependencies|library|subdirectory|test)|'
    r'configure_file|enable_testing|include|install|mark_as_advanced|message|'
    r'option|pkg_check_modules|project|return|set|unset|break|continue|'
    r'(end)?(if|while|foreach|function|macro)|else|elseif'
)
#: Commands that install nothing unless their arguments say so.
_PLAIN = re.compile(
    r'cmake_minimum_required|project|find_package|set|option|message'
    r'|if|elseif|else|endif|enable_testing|add_test|set_tests_properties'
    r'|add_executable|add_library|add_compile_options|add_subdirectory'
    r'|include_directories|link_directories|target_\w+|include|install'
    r'|rosidl_generate_interfaces|rosidl_target_interfaces'
    r'|ament_target_dependencies|ament_package|ament_export_\w+'
    r'|ament_lint_auto_find_test_dependencies|ament_add_\w*test\w*'
    r'|ament_python_install_package'
)
_PLAIN_MODULES = ('CTest', 'GNUInstallDirs')
_PLAIN_VARIABLES = re.compile(r'\$\{(PROJECT_NAME|CMAKE_CURRENT_SOURCE_DIR)\}')
#: Commands of CMake and ament_cmake that look for nothing but what they name,
#: and what is meant by these names.
_INSTALLING = {
    *('add_subdirectory', 'add_test', 'ament_export_dependencies'),
    *('ament_package', 'ament_python_install_package'),
    *('cmake_minimum_required', 'else', 'elseif', 'enable_testing'),
    *('endforeach', 'endif', 'find_package', 'foreach', 'if', 'install'),
    *('message', 'option', 'project', 'set'),
}
_TOOLS = 'ament_cmake'
_USED = re.compile(r'\$\{([^}]*)\}')
_SETTING = ('set', 'foreach', 'option')
_OWN_VARIABLES = {
    *('CMAKE_CURRENT_LIST_DIR', 'CMAKE_CURRENT_SOURCE_DIR'),
    *('CMAKE_PROJECT_NAME', 'CMAKE_SOURCE_DIR', 'PROJECT_NAME'),
    'PROJECT_SOURCE_DIR',
}
#: A path that leads elsewhere, a variable of the environment, one that says
#: where CMake looks, an expression, and what `install` runs.
_ELSEWHERE = re.compile(
    r'\.\.|[\s;]/|ENV\{|CMAKE_\w*(?:PATH|ROOT)|\$<|\bCODE\b|\bSCRIPT\b'
)
#: Commands that read files without writing it down, or run programs that may.
_READING = re.compile(r'file|execute_process|configure_file|add_custom_\w+')
#: What runs programs, which may read whatever they like.
_PROGRAMS = re.compile(
    r'\b(execute_process|exec_program|add_custom_\w+|externalproject_\w+'
    r'|fetchcontent_\w+|try_run)\s*\(',
    re.IGNORECASE,
)
#: Packages that CMake looks for, and variables of the environment that it
#: reads.
_FINDING = re.compile(r'(?i)\bfind_(?:package|dependency)\s*\(\s*"?([\w.+-]+)')
_ENVIRONMENT = re.compile(r'\bENV(?:\{|\s+"?)(\w+)')
#: Where documents are, relative to the package.
_DOCUMENT_FOLDERS = ('', 'doc', 'docs')
_DOCUMENTS = re.compile(
    r'(readme|license|licence|copying|notice|authors|contributors|changelog'
    r'|changes|history|contributing|code_of_conduct|security'
    r'|quality_declaration)(\.\w+)?|[^.].*\.(md|rst)',
    re.IGNORECASE,
)
#: Where something is installed to.
_DESTINATION = re.compile(r'\bDESTINATION\s+\S+')
_SEPARATORS = re.compile(r'[\s"\'();<>:=]+')
_PLACEHOLDER = re.compile(r'\$\w*\{[^{}]*\}')
#: The folder of the source itself, or the one around it.
_WHOLE = re.compile(
    r'(\.{1,2}|\$\{\w*(SOURCE_DIR|LIST_DIR|HOME_DIRECTORY)\})[./]*'
)
_ENTRY = re.compile(r'([\w.-]+)\s*=\s*[\w.]+\s*:\s*\w+')
_ASSIGNED = re.compile(r'^(\w+)\s*=\s*[\'"]([\w.-]+)[\'"]', re.M)
# a list of entry points that Python puts together
_COMPUTED = re.compile(r'[{%+]|\bfor\b|\.format\(')
#: What declares the build of a Python package, beside its `setup.py`.
_DECLARATIONS = ('setup.cfg', 'pyproject.toml')
_INSTALLED_FILES = re.compile('(?:data|script)[_-]files')
_SECTION = re.compile(
    r'^\[(?:metadata|project)\]\s*$(.*?)(?=^\[|\Z)', re.M | re.S
)
_NAME = re.compile(r'^name\s*[=:]\s*[\'"]?([\w.-]+)', re.M)


class Command(NamedTuple):
    """
    A command of CMake.

    :param name: Its name in lower case
    :param arguments: Its arguments, variables not put in
    """

    name: str
    arguments: tuple[str, ...]


def cmake_texts(folder: Path) -> list[str]:
    """Return the CMake files of a package, those in its root first."""
    names = sorted(cmake_files(str(folder))[0], key=lambda n: n.count('/'))
    return [text_of(folder / name) for name in names]


def cmake_commands(folder: Path) -> list[Command]:
    """Return the commands in the CMake files of a package."""
    return [c for text in cmake_texts(folder) for c in _commands(text)]


def _commands(text: str) -> Iterator[Command]:
    """Return the commands in a text; one without a name is not complete."""
    text = _COMMENT.sub(lambda found: found[2] or ' ', text)
    at = 0
    while start := _COMMAND.search(text, at):
        arguments, depth, at = [], 1, start.end()
        while depth and (found := _ARGUMENT.search(text, at)):
            at = found.end()
            depth += {'(': 1, ')': -1}.get(found[2] or '', 0)
            if found[2] is None:
                arguments.append(found[3] if found[1] is None else found[1])
        if depth:
            # nothing is known of the rest
            yield Command('', ())
            return
        yield Command(start[1].lower(), tuple(arguments))


@dataclass(slots=True)
class SourcePrograms:
    """
    The programs that a package's build would install.

    :param names: Those whose names are known
    :param patterns: How the names of others may start and end
    :param scripts: Those of them that Python makes (entry points)
    :param hints: Words out of which foreign macros may make other names
    """

    names: set[str] = field(default_factory=set)
    patterns: set[tuple[str, str]] = field(default_factory=set)
    scripts: set[str] = field(default_factory=set)
    hints: set[str] = field(default_factory=set)

    def may_have(self, name: str) -> bool:
        """Return whether there may be a program of that name."""
        return (
            name in self.names
            or any(hint in name for hint in self.hints)
            or any(
                name.startswith(start) and name.endswith(end)
                for start, end in self.patterns
            )
        )

    def add(self, name: str) -> None:
        """Note a name, which need not be known as a whole."""
        if _ANY not in name:
            self.names.add(name)
        else:
            parts = name.split(_ANY)
            self.patterns.add((parts[0], parts[-1]))


def source_programs(folder: Path) -> SourcePrograms:
    """
    Return the programs that a package's build would install.

    Variables of CMake, and the parameters of functions and macros, have all
    values that the files give them anywhere. Where something else computes
    one, any name fits.

    :param folder: The source of the package
    """
    found = SourcePrograms()
    commands = cmake_commands(folder)
    variables = _Variables(commands)
    for name, arguments in commands:
        if name.endswith('add_executable') and arguments:
            for program in variables.words(arguments[:1]):
                found.add(program)
        elif not (
            name in variables.functions
            or _HARMLESS.fullmatch(name)
            or _COMPUTING.fullmatch(name)
        ):
            stems = {PurePosixPath(w).stem for w in variables.words(arguments)}
            found.hints |= {s for s in stems if len(s) > 2 and _ANY not in s}
        for keyword, argument in pairwise(arguments):
            if keyword in _NAMING:
                for program in variables.words((argument,)):
                    found.add(program)
        if 'PROGRAMS' in arguments:
            files = arguments[arguments.index('PROGRAMS') + 1 :]
            for word in variables.words(takewhile(_is_no_keyword, files)):
                program = PurePosixPath(word).name
                # the source has those that are looked for by a pattern
                if program.strip(_ANY) and '*' not in program:
                    found.add(program)
    for file in ('setup.py', 'setup.cfg'):
        _read_scripts(text_of(folder / file), found)
    return found


def source_plugins(folder: Path) -> set[str]:
    """
    Return the components that a package's build would register.

    Names that are only computed by the build are not found.

    :param folder: The source of the package
    """
    found: set[str] = set()
    for name, words in cmake_commands(folder):
        if name == 'rclcpp_components_register_nodes':
            found.update(words[1:])
        elif name == 'rclcpp_components_register_node':
            after = pairwise(words)
            found.update(n for word, n in after if word == 'PLUGIN')
    return {name for name in found if '::' in name and '$' not in name}


class _Variables:
    """
    The values that variables of CMake may have.

    A list has `;` between its items.

    :param functions: The parameters of functions and macros, by their names
      in lower case
    """

    def __init__(self, commands: Sequence[Command]) -> None:
        self._values: dict[str, set[str]] = {}
        self.functions = {
            arguments[0].lower(): arguments[1:]
            for name, arguments in commands
            if name in ('function', 'macro') and arguments
        }
        self._before: dict[str, set[str]] = {}
        # one file may use the variables of another, and a function has its
        # arguments only behind its commands
        for _ in range(3):
            self._before, self._values = self._values, {}
            for command in commands:
                self._read(command.name, command.arguments)

    def words(self, arguments: Iterable[str]) -> list[str]:
        """Return the words that arguments may come to."""
        return [
            word
            for argument in arguments
            for value in sorted(self._evaluate(argument))
            for word in value.split(';')
            if word
        ]

    def _read(self, name: str, arguments: tuple[str, ...]) -> None:
        if name == 'project' and arguments:
            for variable in ('PROJECT_NAME', 'CMAKE_PROJECT_NAME'):
                self._add(variable, self.words(arguments[:1]))
        elif name == 'set' and arguments:
            ends = ('CACHE', 'PARENT_SCOPE')
            items = takewhile(lambda a: a not in ends, arguments[1:])
            # each item stands for the list
            self._add(arguments[0], self.words(items))
        elif name == 'list' and 'APPEND' in arguments[:-1]:
            self._add(arguments[1], self.words(arguments[2:]))
        elif name == 'foreach' and arguments:
            self._add(arguments[0], self._items(arguments[1:]))
        elif name in self.functions:
            parameters = self.functions[name]
            for parameter, argument in zip(
                parameters, arguments, strict=False
            ):
                self._add(parameter, self.words((argument,)))
            for index, argument in enumerate(arguments):
                self._add(f'ARGV{index}', self.words((argument,)))
            self._add('ARGV', self.words(arguments))
            self._add('ARGN', self.words(arguments[len(parameters) :]))
        elif name == 'get_filename_component' and len(arguments) > 2:
            self._add(arguments[0], self._path_parts(*arguments[1:3]))
        elif _COMPUTING.fullmatch(name):
            for argument in arguments:
                self._add(argument, (_ANY,))

    def _path_parts(self, path: str, part: str) -> list[str]:
        if part not in ('NAME', 'NAME_WE'):
            return [_ANY]
        names = [PurePosixPath(word).name for word in self.words((path,))]
        # NAME_WE is without the longest suffix
        return names if part == 'NAME' else [n.split('.')[0] for n in names]

    def _items(self, arguments: tuple[str, ...]) -> Iterator[str]:
        """Return what the variable of a loop may be."""
        are_names = False
        for argument in arguments:
            if argument == 'RANGE':
                yield _ANY
            elif argument in ('IN', 'LISTS', 'ITEMS'):
                are_names = argument == 'LISTS'
            else:
                item = f'${{{argument}}}' if are_names else argument
                yield from self.words((item,))

    def _add(self, name: str, values: Iterable[str]) -> None:
        known = self._values.setdefault(name, set())
        known.update(v if len(v) <= MAXIMUM_LENGTH else _ANY for v in values)
        if len(known) > MAXIMUM_VALUES:
            self._values[name] = {_ANY}

    def _evaluate(self, argument: str) -> set[str]:
        names = sorted(set(_VARIABLE.findall(argument)))
        choices = [
            self._values.get(name) or self._before.get(name) or {_ANY}
            for name in names
        ]
        if prod(map(len, choices)) > MAXIMUM_VALUES:
            choices = [{_ANY} for _ in names]
        found = set()
        for values in product(*choices):
            text = argument
            for name, value in zip(names, values, strict=True):
                text = text.replace(f'${{{name}}}', value)
            found.add(_OTHER_VALUE.sub(_ANY, text))
        return found


def _is_no_keyword(argument: str) -> bool:
    return _KEYWORD.fullmatch(argument) is None


def _read_scripts(text: str, found: SourcePrograms) -> None:
    values = dict(_ASSIGNED.findall(text))
    _, key, scripts = text.partition('console_scripts')
    if not key:
        return
    # the list ends in setup.py, the next section begins in setup.cfg
    end = re.search(r'\]|^\[', scripts, re.M)
    scripts = scripts[: end.start() if end else None]
    for name, value in values.items():
        scripts = scripts.replace(f'{{{name}}}', value)
        scripts = re.sub(rf'\b{name}\s*\+\s*[\'"]', f"'{value}", scripts)
    names = set(_ENTRY.findall(scripts))
    found.names |= names
    found.scripts |= names
    if _COMPUTED.search(scripts):
        found.add(_ANY)


def names_all_programs(folder: Path) -> bool:
    """
    Return whether the build files name all programs that a build installs.

    That is so if they have only commands with known results; others, variables
    and patterns may result in any name.

    :param folder: The source of the package
    """
    if cmake_files(str(folder))[0]:
        return all(map(_is_plain, cmake_commands(folder)))
    declared = ''.join(text_of(folder / name) for name in _DECLARATIONS)
    if _INSTALLED_FILES.search(declared):
        return False
    calls, _ = _setup_calls(folder)
    return len(calls) == 1 and all(
        keyword.arg not in (None, 'cmdclass')
        and (
            keyword.arg not in ('entry_points', 'scripts')
            or _is_named(keyword.value)
        )
        and (keyword.arg != 'data_files' or _is_data(keyword.value))
        for keyword in calls[0].keywords
    )


def _is_plain(command: Command) -> bool:
    name, arguments = command
    first = arguments[0] if arguments else ''
    if name == 'include':
        return first in _PLAIN_MODULES
    if name == 'add_executable':
        return '$' not in first
    if name != 'install':
        return _PLAIN.fullmatch(name) is not None
    text = _PLAIN_VARIABLES.sub('', ' '.join(arguments))
    if '$' in text or first in ('CODE', 'SCRIPT'):
        return False
    # in a folder that is installed to the programs, any file may be one
    _, _, destination = text.partition('DESTINATION ')
    return first != 'DIRECTORY' or destination.startswith(('share', 'include'))


def _is_named(node: ast.AST | None) -> bool:
    """Return whether texts begin with what is no variable: `name = …`."""
    if isinstance(node, (ast.List, ast.Tuple)):
        return all(map(_is_named, node.elts))
    if isinstance(node, ast.Dict):
        return all(map(_is_named, node.values))
    if isinstance(node, ast.JoinedStr):
        first = node.values[0]
        return isinstance(first, ast.Constant) and '=' in str(first.value)
    return isinstance(node, ast.Constant)


def _is_data(files: ast.expr) -> bool:
    """Return whether files are installed to folders without programs."""
    if not isinstance(files, ast.List):
        return False
    for item in files.elts:
        folder = item.elts[0] if isinstance(item, ast.Tuple) else item
        texts = (n for n in ast.walk(folder) if isinstance(n, ast.Constant))
        first = next(texts, None)
        if first is None or not str(first.value).startswith('share'):
            return False
    return True


def only_installs(folder: Path, packages: Collection[str]) -> bool:
    """
    Return whether a build certainly uses no files of other packages.

    That is so if its CMake files do no more than install files of the package,
    with ament_cmake at most, which is not in the workspace.

    :param folder: The source of the package
    :param packages: Packages of the workspace that it needs
    """
    made: set[str] = set()
    text = ''
    commands = cmake_commands(folder)
    for name, arguments in commands:
        first = arguments[0] if arguments else ''
        if name not in _INSTALLING or (
            # not one whose name is in a variable
            name == 'find_package' and not first.startswith(_TOOLS)
        ):
            return False
        if name in _SETTING:
            made.add(first)
        text += f'{name} {" ".join(arguments)}\n'
    return (
        bool(commands)
        and not any(name.startswith(_TOOLS) for name in packages)
        and not any(name.startswith('CMAKE_') for name in made)
        and (made | _OWN_VARIABLES).issuperset(_USED.findall(text))
        and not _ELSEWHERE.search(text)
    )


def reading_commands(folder: Path) -> list[Command]:
    """Return the commands of a package's CMake files that may read files."""
    commands = cmake_commands(folder)
    return [c for c in commands if _READING.fullmatch(c.name)]


def searched_names(text: str) -> tuple[set[str], set[str]]:
    """
    Return what a CMake file looks for: packages and environment variables.

    :param text: The file
    """
    return set(_FINDING.findall(text)), set(_ENVIRONMENT.findall(text))


def is_document(relative: str) -> bool:
    """
    Return whether a file is one that people read and tools do not.

    :param relative: Its path in the package
    """
    folder, _, name = relative.rpartition('/')
    return (
        folder in _DOCUMENT_FOLDERS and _DOCUMENTS.fullmatch(name) is not None
    )


def may_be_named(relative: str, texts: Iterable[str]) -> bool:
    """
    Return whether CMake files may read or install a file of the source.

    They may if a word in them is its name, a pattern that matches it, or a
    folder that it is in.

    :param texts: Their texts
    """
    parts = [part.lower() for part in relative.split('/')]
    # a name may be put together from its parts
    parts += [part.partition('.')[0] for part in parts]
    for text in texts:
        if _PROGRAMS.search(text):
            return True
        text = _DESTINATION.sub('', _COMMENT_LINE.sub('', text))
        if any(_may_name(word, parts) for word in _SEPARATORS.split(text)):
            return True
    return False


def _may_name(word: str, parts: list[str]) -> bool:
    if _WHOLE.fullmatch(word):
        return True
    name = word.rstrip('/').rpartition('/')[2].lower()
    if not _PLACEHOLDER.sub('', name):
        # what the variables are made of stands elsewhere
        return False
    pattern = _PLACEHOLDER.sub('*', name)
    return any(fnmatchcase(part, pattern) for part in parts)


def cmake_name(folder: Path) -> str | None:
    """Return the name that the CMakeLists.txt in a folder gives it."""
    path = folder / 'CMakeLists.txt'
    if not os.path.isfile(path):
        return None
    for name, arguments in _commands(text_of(path)):
        # the name may come from a variable
        if name == 'project' and arguments and '$' not in arguments[0]:
            return arguments[0]
    return folder.name


def python_name(folder: Path) -> str | None:
    """
    Return the name of a Python package as far as its files write it.

    colcon runs `setup.py` for the name, and so does a launch, which builds the
    package anyway. Who only looks reads it: the name that `setup()` is given
    as a text, or by a variable that is one, else that of `setup.cfg` or
    `pyproject.toml`.
    """
    calls, values = _setup_calls(folder)
    for call in calls:
        for keyword in call.keywords:
            if keyword.arg == 'name':
                name = last_name(keyword.value)
                return text_in(keyword.value) or values.get(name)
    return configured_name(folder)


def configured_name(
    folder: Path, files: Sequence[str] = _DECLARATIONS
) -> str | None:
    """Return the name that the metadata files of a package give it."""
    for file in files:
        for section in _SECTION.findall(text_of(folder / file)):
            found = _NAME.search(section)
            if found:
                return found[1]
    return None


def _setup_calls(
    folder: Path,
) -> tuple[list[ast.Call], dict[str, str | None]]:
    """Return the calls of `setup()`, and the texts of variables there."""
    values: dict[str, str | None] = {}
    calls = []
    for node in ast.walk(parsed(folder / 'setup.py')):
        if isinstance(node, ast.Assign):
            for target in node.targets:
                if isinstance(target, ast.Name):
                    # it may be any of them
                    is_first = target.id not in values
                    text = text_in(node.value) if is_first else None
                    values[target.id] = text
        elif isinstance(node, ast.Call) and last_name(node.func) == 'setup':
            calls.append(node)
    return calls, values
