# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What CMake files and `setup.py` say, without running them.

This is the only reader of build files.
"""

import ast
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Sequence
from dataclasses import dataclass
from dataclasses import field
from itertools import pairwise
from itertools import product
from pathlib import Path
from pathlib import PurePosixPath
import re

from colcon_yamllaunch.common.text_files import text_of
from colcon_yamllaunch.workspace.packages.package_index import cmake_files

#: How many commands of CMake are gone through, in loops and functions too.
MAXIMUM_COMMANDS = 20_000
#: How many loops and functions are gone through inside of one another.
MAXIMUM_DEPTH = 30
#: How many values a variable, and how many words an argument may come to.
MAXIMUM_VALUES = 100

# stands for whatever cannot be known
_ANY = '\0'
_COMMENT = re.compile(
    r'#\[(=*)\[.*?\]\1\]|("(?:\\.|[^"\\])*")|#[^\n]*', re.DOTALL
)
_COMMAND = re.compile(r'([A-Za-z_]\w*)\s*\(')
_ARGUMENT = re.compile(r'"((?:\\.|[^"\\])*)"|([()])|([^\s()"]+)', re.DOTALL)
_VARIABLE = re.compile(r'\$\{([\w.+/-]+)\}')
# the environment, what the generator computes, nested variables
_OTHER_VALUE = re.compile(r'\$(?:ENV|CACHE)?\{[^}]*\}|\$<.*')
_KEYWORD = re.compile(r'[A-Z][A-Z_]+')
# the arguments that name a program
_NAMING = ('EXECUTABLE', 'OUTPUT_NAME', 'RENAME')
# what computes a variable in a way that is not followed
_COMPUTING = frozenset(
    [
        'cmake_parse_arguments',
        'cmake_path',
        'execute_process',
        'file',
        'find_file',
        'find_path',
        'find_program',
        'get_filename_component',
        'get_property',
        'get_target_property',
        'list',
        'math',
        'string',
    ]
)
# what brings no program but those that it names
_HARMLESS = re.compile(
    r'(ament|catkin|cmake|find|get|include|link|pluginlib|rclcpp|rosidl|set|'
    r'target)_\w+|add_(compile_definitions|compile_options|custom_command|'
    r'custom_target|definitions|dependencies|library|subdirectory|test)|'
    r'configure_file|enable_testing|include|install|mark_as_advanced|message|'
    r'option|pkg_check_modules|project|return|unset|(end)?(if|while)|else|'
    r'elseif|break|continue'
)
_ENTRY = re.compile(r'([\w.-]+)\s*=\s*[\w.]+\s*:\s*\w+')
_ASSIGNED = re.compile(r'^(\w+)\s*=\s*[\'"]([\w.-]+)[\'"]', re.M)
# a list of entry points that Python puts together
_COMPUTED = re.compile(r'[{%+]|\bfor\b|\.format\(')


_COMMENT_RULES = re.compile(r'#.*')
_COMMAND_RULES = re.compile(r'^[ \t]*(\w+)\s*\(([^()]*)', re.M)
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
_COMPUTED_RULES = re.compile('(?:data|script)[_-]files')
#: The arguments of `setup()` that name programs.
_NAMING_RULES = ('entry_points', 'scripts')
_SECTION = re.compile(
    r'^\[(?:metadata|project)\]\s*$(.*?)(?=^\[|\Z)', re.M | re.S
)
_NAME = re.compile(r'^name\s*[=:]\s*[\'"]?([\w.-]+)', re.M)


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
        """Tell whether there may be a program of that name."""
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

    Variables, loops, functions and macros of CMake are followed as far as
    their values stand in the files; conditions are taken to hold.

    :param folder: The source of the package
    """
    names = sorted(cmake_files(str(folder))[0], key=lambda n: n.count('/'))
    files = [list(_commands(text_of(folder / name))) for name in names]
    cmake = _CMake()
    # one file may use the functions and variables of another
    for _ in range(2):
        cmake.found = found = SourcePrograms()
        cmake.left = MAXIMUM_COMMANDS
        for commands in files:
            cmake.run(commands, 0)
    for name in ('setup.py', 'setup.cfg'):
        _read_setup(text_of(folder / name), found)
    return found


def source_plugins(folder: Path) -> set[str]:
    """
    Return the components that a package's build would register.

    Names that are only computed by the build are not found.

    :param folder: The source of the package
    """
    found: set[str] = set()
    for name in cmake_files(str(folder))[0]:
        for command in _commands(text_of(folder / name)):
            words = command.arguments
            if command.name == 'rclcpp_components_register_nodes':
                found.update(words[1:])
            elif command.name == 'rclcpp_components_register_node':
                after = pairwise(words)
                found.update(n for word, n in after if word == 'PLUGIN')
    return {name for name in found if '::' in name and '$' not in name}


@dataclass(frozen=True, slots=True)
class _Command:
    """
    A command of CMake.

    :param name: Its name in lower case
    :param arguments: Its arguments, variables not put in
    """

    name: str
    arguments: tuple[str, ...]


def _commands(text: str) -> Iterator[_Command]:
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
            return
        yield _Command(start[1].lower(), tuple(arguments))


class _CMake:
    """Goes through commands, and keeps what variables may be."""

    def __init__(self) -> None:
        self.found = SourcePrograms()
        #: How many commands are gone through at most.
        self.left = 0
        # a list has ; between its items
        self._variables: dict[str, set[str]] = {}
        self._functions: dict[str, tuple[tuple[str, ...], list[_Command]]] = {}

    def run(self, commands: list[_Command], depth: int) -> None:
        """Go through some commands."""
        at = 0
        while at < len(commands):
            command = commands[at]
            at += 1
            self.left -= 1
            if self.left < 0 or depth > MAXIMUM_DEPTH:
                self.found.add(_ANY)
                return
            if command.name in ('function', 'macro', 'foreach'):
                end = _end(commands, at, command.name)
                body, at = commands[at:end], end + 1
                if command.name == 'foreach':
                    self._loop(command.arguments, body, depth)
                elif command.arguments:
                    name, *parameters = command.arguments
                    self._functions[name.lower()] = tuple(parameters), body
            elif command.name in self._functions:
                self._call(command, depth)
            else:
                self._do(command)

    def _do(self, command: _Command) -> None:
        name, arguments = command.name, command.arguments
        if name == 'project' and arguments:
            for variable in ('PROJECT_NAME', 'CMAKE_PROJECT_NAME'):
                self._add(variable, self._words(arguments[:1]))
        elif name == 'set' and arguments:
            self._set(arguments[0], arguments[1:])
        elif name == 'list' and 'APPEND' in arguments[:-1]:
            variable, *items = arguments[1:]
            if variable in self._variables:
                items.insert(0, f'${{{variable}}}')
            self._set(variable, tuple(items))
        elif name == 'get_filename_component' and len(arguments) > 2:
            self._add(arguments[0], self._components(*arguments[1:3]))
        elif name in _COMPUTING:
            for argument in arguments:
                self._add(argument, (_ANY,))
        elif name.endswith('add_executable') and arguments:
            self._add_programs(self._words(arguments[:1]))
        elif not _HARMLESS.fullmatch(name):
            for word in self._words(arguments):
                stem = PurePosixPath(word).stem
                if len(stem) > 2 and _ANY not in stem:
                    self.found.hints.add(stem)
        self._read_keywords(arguments)

    def _read_keywords(self, arguments: tuple[str, ...]) -> None:
        for keyword, argument in pairwise(arguments):
            if keyword in _NAMING:
                self._add_programs(self._words((argument,)))
        if 'PROGRAMS' in arguments:
            files = arguments[arguments.index('PROGRAMS') + 1 :]
            for word in self._words(_until_keyword(files)):
                name = PurePosixPath(word).name
                # the source has those that are looked for by a pattern
                if name.strip(_ANY) and '*' not in name:
                    self.found.add(name)

    def _add_programs(self, names: Iterable[str]) -> None:
        for name in names:
            self.found.add(name)

    def _loop(
        self, arguments: tuple[str, ...], body: list[_Command], depth: int
    ) -> None:
        if not arguments:
            return
        variable, *items = arguments
        if items[:1] == ['RANGE']:
            words = [_ANY]
        elif items[:1] == ['IN']:
            words, are_names = [], False
            for item in items[1:]:
                if item in ('LISTS', 'ITEMS'):
                    are_names = item == 'LISTS'
                else:
                    item = f'${{{item}}}' if are_names else item
                    words += self._words((item,))
        else:
            words = self._words(items)
        outer = self._variables.get(variable)
        for word in dict.fromkeys(words):
            self._variables[variable] = {word}
            self.run(body, depth + 1)
        self._variables.pop(variable, None)
        if outer is not None:
            self._variables[variable] = outer

    def _call(self, command: _Command, depth: int) -> None:
        parameters, body = self._functions[command.name]
        values = [self._values(argument) for argument in command.arguments]
        own = dict(zip(parameters, values, strict=False))
        rest = command.arguments[len(parameters) :]
        own['ARGN'] = {';'.join(self._words(rest))}
        own['ARGV'] = {';'.join(self._words(command.arguments))}
        own |= {f'ARGV{index}': value for index, value in enumerate(values)}
        outer = {name: self._variables.get(name) for name in own}
        self._variables |= own
        self.run(body, depth + 1)
        for name, value in outer.items():
            self._variables.pop(name, None)
            if value is not None:
                self._variables[name] = value

    def _set(self, name: str, arguments: tuple[str, ...]) -> None:
        for end in ('CACHE', 'PARENT_SCOPE'):
            if end in arguments:
                arguments = arguments[: arguments.index(end)]
        choices = [self._values(argument) for argument in arguments]
        self._add(
            name, (';'.join(c).strip(';') for c in _combinations(choices))
        )

    def _add(self, name: str, values: Iterable[str]) -> None:
        # a condition may decide which of them it is
        known = self._variables.setdefault(name, set())
        known.update(values)
        if len(known) > MAXIMUM_VALUES:
            self._variables[name] = {_ANY}

    def _components(self, path: str, part: str) -> list[str]:
        if part not in ('NAME', 'NAME_WE'):
            return [_ANY]
        names = [PurePosixPath(word).name for word in self._words((path,))]
        # NAME_WE is without the longest suffix
        return names if part == 'NAME' else [n.split('.')[0] for n in names]

    def _words(self, arguments: Iterable[str]) -> list[str]:
        """Return the words that arguments may come to."""
        found = [
            word
            for argument in arguments
            for value in sorted(self._values(argument))
            for word in value.split(';')
            if word
        ]
        return found if len(found) <= MAXIMUM_VALUES * 10 else [_ANY]

    def _values(self, argument: str) -> set[str]:
        """Return what an argument may come to."""
        pieces = _VARIABLE.split(argument)
        choices = [
            self._variables.get(piece, {_ANY}) if index % 2 else {piece}
            for index, piece in enumerate(pieces)
        ]
        return {
            _OTHER_VALUE.sub(_ANY, ''.join(choice))
            for choice in _combinations(choices)
        }


def _combinations(choices: list[set[str]]) -> Iterable[tuple[str, ...]]:
    count = 1
    for choice in choices:
        count *= len(choice)
    return product(*choices) if count <= MAXIMUM_VALUES else ((_ANY,),)


def _end(commands: list[_Command], at: int, name: str) -> int:
    depth = 1
    for index in range(at, len(commands)):
        depth += commands[index].name == name
        depth -= commands[index].name == f'end{name}'
        if not depth:
            return index
    return len(commands)


def _until_keyword(arguments: tuple[str, ...]) -> Iterator[str]:
    for argument in arguments:
        if _KEYWORD.fullmatch(argument):
            return
        yield argument


def _read_setup(text: str, found: SourcePrograms) -> None:
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


def spells_out_programs(folder: Path) -> bool:
    """
    Tell whether a build installs no script but those whose names it spells.

    Then the files that describe the build do nothing but what is known: other
    commands of CMake, variables and patterns may come to any name.

    :param folder: The source of the package
    """
    cmake = [text_of(folder / n) for n in cmake_files(str(folder))[0]]
    if cmake:
        return all(
            _is_plain_cmake(_COMMENT_RULES.sub('', text)) for text in cmake
        )
    if any(_COMPUTED_RULES.search(text_of(folder / n)) for n in _DECLARATIONS):
        return False
    return _is_plain_setup(text_of(folder / 'setup.py'))


def _is_plain_cmake(text: str) -> bool:
    for word, written in _COMMAND_RULES.findall(text):
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
        and (keyword.arg not in _NAMING_RULES or _is_named(keyword.value))
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


def written_name(folder: Path) -> str | None:
    """Return the name of a Python package as far as its files write it."""
    names = list(_in_setup(text_of(folder / 'setup.py')))
    return names[0] if names else configured_name(folder)


def configured_name(
    folder: Path, files: Sequence[str] = ('setup.cfg', 'pyproject.toml')
) -> str | None:
    """Return the name that the metadata files of a package give it."""
    for file in files:
        for section in _SECTION.findall(text_of(folder / file)):
            found = _NAME.search(section)
            if found:
                return found[1]
    return None


def _in_setup(text: str) -> Iterator[str | None]:
    """Return the names that `setup()` is given, None for one not known."""
    try:
        nodes = list(ast.walk(ast.parse(text)))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return
    values: dict[str, str | None] = {}
    for node in nodes:
        for target in getattr(node, 'targets', ()):
            if isinstance(node, ast.Assign) and isinstance(target, ast.Name):
                known = _text(node.value) if target.id not in values else None
                values[target.id] = known
    for node in nodes:
        if isinstance(node, ast.Call) and _name_of(node.func) == 'setup':
            for keyword in node.keywords:
                if keyword.arg == 'name':
                    name = _name_of(keyword.value)
                    yield _text(keyword.value) or values.get(name or '')


def _name_of(node: ast.expr) -> str | None:
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else None


def _text(node: ast.expr) -> str | None:
    value = node.value if isinstance(node, ast.Constant) else None
    return value if isinstance(value, str) else None
