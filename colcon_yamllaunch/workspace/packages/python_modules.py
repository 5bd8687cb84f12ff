# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The Python modules of packages, without running them.

:func:`undeclared_imports` finds modules of packages that a package does not
declare. :class:`ExposedNames` knows what packages add to the launch language:
ROS 2's launcher loads the modules that distributions name in the entry point
group :data:`GROUP` (`Parser.load_launch_extensions` of `launch`). Installed
ones have that in the metadata beside them, and the sources of packages in
what the metadata are made of. A module says `@expose_action('name')` or
`@expose_substitution('name')` when it is imported (`launch.frontend.expose`),
so what a module of an extension imports of its own package is read, too.
"""

import ast
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
import glob
import os
from pathlib import Path
import re
import shutil
from typing import NamedTuple

from colcon_yamllaunch.common.files import (
    content_of,
    names_in,
    split_path,
    text_of,
)
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.packages.package import Package, source_files

_TESTS = frozenset(('test', 'tests'))


#: The entry point group of extensions of the launch language.
GROUP = 'launch.frontend.launch_extension'
_METADATA = ('.dist-info', '.egg-info')
_INSTALLED = ('lib/python3*/', 'local/lib/python3*/')
_PACKAGES = ('site-packages', 'dist-packages')
# where a source usually has its modules
_IN_SOURCE = ('', 'src', 'python', 'lib')
# `name = module:attribute [extra]`, in a line or a text of Python
_ENTRY = re.compile(r'(?:^|["\'])\s*[\w.-]+\s*=\s*["\']?([\w.]+)', re.M)
# where entries of another group begin: in metadata, and in Python
_NEXT_GROUP = re.compile(r'^\[|^[\w.]+\s*[=:]\s*$', re.M)
_NEXT_LIST = re.compile(r'\]')
#: How many modules of an extension are looked at.
MAXIMUM_MODULES = 1000
#: The largest module that is (bytes).
MAXIMUM_SIZE = 1024 * 1024
#: The packages of ROS 2 itself: of what they have, most is known.
OF_ROS = ('launch', 'launch_ros')
_ACTION, _SUBSTITUTION = 'expose_action', 'expose_substitution'


class Import(NamedTuple):
    """
    An import of a module of another package.

    :param path: The file
    :param line: The line, counted from 1
    :param column: The column, counted from 1
    :param module: The module, up to the first dot
    :param owner: The package that has it
    """

    path: Path
    line: int
    column: int
    module: str
    owner: str


def undeclared_owner(
    module: str, user: Package, packages: Iterable[Package]
) -> str | None:
    """
    Return the package that has a module and is not declared by its user.

    A package has the module of its own name, as packages with interfaces do,
    and those whose folders it has.

    :param packages: The packages of the workspace
    """
    declared = user.build_depends | user.run_depends | {user.name}
    owners = [p for p in packages if p.name == module] or [
        p for p in packages if os.path.isfile(p.path / module / '__init__.py')
    ]
    if not owners or any(owner.name in declared for owner in owners):
        return None
    return owners[0].name


def undeclared_imports(
    user: Package, packages: Iterable[Package]
) -> Iterator[Import]:
    """
    Find what a package imports of packages that it does not declare.

    Its tests do not count, and neither do files that are no Python.

    :param packages: The packages of the workspace
    """
    packages = tuple(packages)
    owners: dict[str, str | None] = {}
    for name, _ in sorted(source_files(user.path), key=lambda file: file[0]):
        path = user.path / name
        if path.suffix != '.py' or _TESTS.intersection(Path(name).parts):
            continue
        for module, node in _imports(ast.walk(parsed(path))):
            if module not in owners:
                owners[module] = undeclared_owner(module, user, packages)
            owner = owners[module]
            if owner is not None:
                yield Import(
                    path, node.lineno, node.col_offset + 1, module, owner
                )


def certain_imports(path: Path) -> Iterator[tuple[str, ast.stmt]]:
    """
    Iterate over the modules that a script imports as it starts.

    None where it changes `sys.path`.
    """
    if 'sys.path' not in text_of(path):
        yield from _imports(parsed(path).body)


def parsed(path: Path) -> ast.Module:
    """Return the tree of a module, an empty one where it has none."""
    try:
        return ast.parse(content_of(path, MAXIMUM_SIZE))
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return ast.Module([], [])


def _imports(nodes: Iterable[ast.AST]) -> Iterator[tuple[str, ast.stmt]]:
    for node in nodes:
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name.partition('.')[0], node
        # relative ones stay in the package
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield (node.module or '').partition('.')[0], node


@dataclass(frozen=True, slots=True)
class Extension:
    """
    A module that extends the launch language.

    :param package: Whose it is
    :param module: Its full name
    :param folders: Where Python, or a build, looks for it
    """

    package: str
    module: str
    folders: tuple[str, ...]


def _installed_extensions(folders: tuple[str, ...]) -> Iterator[Extension]:
    """
    Find the extensions that are installed into folders.

    As in Python, the first of several distributions of one name counts.
    """
    seen: set[str] = set()
    for folder in folders:
        for entry in sorted(names_in(folder)):
            name = entry.partition('.')[0].partition('-')[0]
            if not entry.endswith(_METADATA) or name in seen:
                continue
            text = text_of(Path(folder, entry, 'entry_points.txt'))
            seen.add(name)
            for module in _extension_modules(text, _NEXT_GROUP):
                yield Extension(name, module, folders)


def _extensions_in_source(package: str, source: Path) -> Iterator[Extension]:
    """
    Find the extensions that a package will have once it is built.

    :param source: The folder with its source
    """
    folders = tuple(str(source / folder) for folder in _IN_SOURCE)
    for file in ('setup.py', 'setup.cfg', 'pyproject.toml'):
        end = _NEXT_LIST if file == 'setup.py' else _NEXT_GROUP
        for module in _extension_modules(text_of(source / file), end):
            yield Extension(package, module, folders)


def python_folders(environment: Mapping[str, str]) -> list[str]:
    """
    Return where the Python of an environment looks for packages.

    Told without running it, so there may be more of them than it has.
    """
    found = split_path(environment.get('PYTHONPATH'))
    for prefix in split_path(environment.get('AMENT_PREFIX_PATH')):
        found += _installed_into(prefix)
    python = shutil.which('python3', path=environment.get('PATH', os.defpath))
    if python is not None:
        prefix = os.path.dirname(os.path.dirname(python))
        found += _installed_into(prefix)
        home = _base_of(prefix)
        if home is not None:
            found += _installed_into(home)
    user = environment.get('HOME')
    if user and not environment.get('PYTHONNOUSERSITE'):
        found += _installed_into(os.path.join(user, '.local'))
    found = list(dict.fromkeys(filter(os.path.isabs, found)))
    return [*found, *_linked_from(found)]


def _installed_into(prefix: str) -> list[str]:
    patterns = [*_INSTALLED]
    if prefix == '/usr':
        # as Debian has it
        patterns += ['lib/python3/', '../usr/local/lib/python3*/']
    root = glob.escape(prefix)
    return [
        os.path.normpath(folder)
        for pattern in patterns
        for name in _PACKAGES
        for folder in sorted(glob.glob(f'{root}/{pattern}{name}'))
    ]


def _base_of(prefix: str) -> str | None:
    """Return the prefix whose packages a virtual environment uses."""
    settings = dict(
        [part.strip() for part in line.split('=', 1)]
        for line in text_of(Path(prefix, 'pyvenv.cfg')).splitlines()
        if '=' in line
    )
    if settings.get('include-system-site-packages') != 'true':
        return None
    return os.path.dirname(settings.get('home', '')) or None


def _linked_from(folders: Iterable[str]) -> Iterator[str]:
    """Return the folders that development installations add (`.pth`)."""
    for folder in folders:
        for entry in sorted(names_in(folder)):
            if entry.endswith('.pth'):
                for line in text_of(Path(folder, entry)).splitlines():
                    if os.path.isabs(line):
                        yield line.rstrip()


def _extension_modules(text: str, end: re.Pattern[str]) -> list[str]:
    """Return the modules in the entry point group :data:`GROUP`."""
    _, _, rest = text.partition(GROUP)
    # the quote, bracket or sign between the group and its entries
    rest = rest.lstrip('"\'] \t')
    rest = rest[1:] if rest[:1] in ('=', ':') else rest
    found = end.search(rest)
    return _ENTRY.findall(rest[: found.start() if found else None])


class ExposedNames:
    """
    The actions and substitutions that packages expose.

    Packages are looked at when a name is asked for first, those of ROS 2
    itself only when no other has the name.

    :param environment: Where the packages are
    :param packages: The packages of the workspace, built or not
    """

    def __init__(
        self, environment: Mapping[str, str], packages: Iterable[Package]
    ) -> None:
        self._environment = environment
        self._packages = packages
        self._not_installed: set[str] = set()

    def action(self, name: str) -> str | None:
        """Return the package that exposes an action, None when none does."""
        return self._others[_ACTION].get(name) or self._ros[_ACTION].get(name)

    def substitution(self, name: str) -> str | None:
        """Return the package that exposes a substitution, or None."""
        kind = _SUBSTITUTION
        return self._others[kind].get(name) or self._ros[kind].get(name)

    def actions(self) -> Mapping[str, str]:
        """Return all actions, with their packages."""
        return self._ros[_ACTION] | self._others[_ACTION]

    def substitutions(self) -> Mapping[str, str]:
        """Return all substitutions, with their packages."""
        return self._ros[_SUBSTITUTION] | self._others[_SUBSTITUTION]

    def is_installed(self, package: str) -> bool:
        """Return whether a package that exposes something is installed."""
        return package not in self._not_installed

    @cached_property
    def _folders(self) -> tuple[str, ...]:
        return tuple(python_folders(self._environment))

    @cached_property
    def _others(self) -> dict[str, dict[str, str]]:
        """What packages expose, those of ROS 2 itself left out."""
        installed = [
            extension
            for extension in _installed_extensions(self._folders)
            if extension.package not in OF_ROS
            and extension.module not in OF_ROS
        ]
        in_source = [
            extension
            for package in self._packages
            for extension in _extensions_in_source(package.name, package.path)
            if extension.module not in OF_ROS
            and _file_of(extension.module, extension.folders) is not None
        ]
        # a distribution may have another name than its package
        there = {e.module for e in installed}
        own = {e.module for e in in_source}
        self._not_installed = {
            e.package for e in in_source if e.module not in there
        }
        # what a package of the workspace has is what its source has
        others = [e for e in installed if e.module not in own]
        return _names([*in_source, *others])

    @cached_property
    def _ros(self) -> dict[str, dict[str, str]]:
        return _names([Extension(n, n, self._folders) for n in OF_ROS])


def _names(extensions: Iterable[Extension]) -> dict[str, dict[str, str]]:
    """Return the exposed names with their packages, by what exposes them."""
    names: dict[str, dict[str, str]] = {_ACTION: {}, _SUBSTITUTION: {}}
    for extension in extensions:
        for kind, name in _exposed_by(extension):
            names[kind].setdefault(name, extension.package)
    return names


def _exposed_by(extension: Extension) -> Iterator[tuple[str, str]]:
    """Return what an extension exposes, as what exposes it and the name."""
    pending = _with_parents(extension.module)
    seen: set[str] = set()
    while pending and len(seen) < MAXIMUM_MODULES:
        module = pending.pop()
        path = _file_of(module, extension.folders)
        if module in seen or path is None:
            continue
        seen.add(module)
        tree = parsed(path)
        yield from _exposed_in(tree)
        is_package = path.name == '__init__.py'
        if is_package and 'import_module' in text_of(path):
            # which modules it is, only running it would tell
            folder = path.parent
            pending += [f'{module}.{f.stem}' for f in folder.glob('*.py')]
            inner = folder.glob('*/__init__.py')
            pending += [f'{module}.{f.parent.name}' for f in inner]
        top = module.partition('.')[0]
        for name in _imported(tree, module, is_package):
            if name.partition('.')[0] == top:
                pending += _with_parents(name)


def _with_parents(module: str) -> list[str]:
    """Return a module and the packages around, which Python imports, too."""
    parts = module.split('.')
    return ['.'.join(parts[:n]) for n in range(len(parts), 0, -1)]


def _file_of(module: str, folders: Iterable[str]) -> Path | None:
    relative = module.replace('.', '/')
    for folder in folders:
        for end in ('/__init__.py', '.py'):
            path = Path(folder, relative + end)
            if os.path.isfile(path):
                return path
    return None


def _exposed_in(tree: ast.AST) -> Iterator[tuple[str, str]]:
    texts: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and (text := text_in(node.value)):
            for target in node.targets:
                if isinstance(target, ast.Name):
                    texts[target.id] = text
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and node.args:
            kind = last_name(node.func)
            argument = node.args[0]
            if kind not in (_ACTION, _SUBSTITUTION):
                continue
            text = text_in(argument) or texts.get(last_name(argument))
            if text:
                yield kind, text


def _imported(tree: ast.AST, module: str, is_package: bool) -> Iterator[str]:
    """Return the modules, or names in modules, that a module imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ''
            if node.level:
                around = module.split('.')
                keep = len(around) - node.level + is_package
                base = '.'.join([*around[: max(0, keep)], *base.split('.')])
                base = base.rstrip('.')
            yield base
            yield from (f'{base}.{alias.name}' for alias in node.names)


def last_name(node: ast.expr) -> str:
    """Return the name that an expression ends in; empty for another one."""
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ''


def text_in(node: ast.expr) -> str | None:
    """Return the text that an expression is, None for another one."""
    value = node.value if isinstance(node, ast.Constant) else None
    return value if isinstance(value, str) else None
