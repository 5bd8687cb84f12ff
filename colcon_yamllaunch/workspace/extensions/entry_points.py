# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Which Python modules extend the launch language, without running anything.

ROS 2's launcher loads the modules that distributions name in the entry point
group :data:`GROUP` (`Parser.load_launch_extensions` of `launch`). Installed
ones have that in the metadata beside them, and the sources of packages in
what the metadata are made of.
"""

import ast
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
import glob
import os
from pathlib import Path
import re
import shutil

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.search_path import split_path
from colcon_yamllaunch.common.text_files import text_of

#: The entry point group of extensions of the launch language.
GROUP = 'launch.frontend.launch_extension'

_METADATA = ('.dist-info', '.egg-info')
_INSTALLED = ('lib/python3*/', 'local/lib/python3*/')
_PACKAGES = ('site-packages', 'dist-packages')
# where a source usually has its modules
_IN_SOURCE = ('', 'src', 'python', 'lib')
# `name = module:attribute [extra]`
_ENTRY = re.compile(r'^\s*[^#;=\s][^=]*=\s*["\']?([\w.]+)', re.M)
# up to the next section, or in setup.cfg to the next option
_SECTION = re.compile(
    rf'^\[\s*(?:{re.escape(GROUP)}'
    rf'|project\.entry-points\.["\']{re.escape(GROUP)}["\'])\s*\]'
    r'\s*$(.*?)(?=^\[|\Z)',
    re.M | re.S,
)
_OPTION = re.compile(
    rf'^{re.escape(GROUP)}\s*[=:]((?:.*\n?)(?:[ \t]+.*\n?|\s*\n)*)', re.M
)


@dataclass(frozen=True, slots=True)
class Extension:
    """
    A module that extends the launch language.

    :param package: Whose it is
    :param module: Its full name
    :param folders: Where Python, or a build, looks for it
    :param is_installed: Whether it is in the environment, and not only in
      the source of a package
    """

    package: str
    module: str
    folders: tuple[str, ...]
    is_installed: bool = True


def installed_extensions(folders: Iterable[str]) -> Iterator[Extension]:
    """
    Find the extensions that are installed into folders.

    As in Python, the first of several distributions of one name counts.
    """
    folders = tuple(folders)
    seen: set[str] = set()
    for folder in folders:
        for entry in _entries(folder):
            name = entry.partition('.')[0].partition('-')[0]
            if not entry.endswith(_METADATA) or name in seen:
                continue
            text = text_of(Path(folder, entry, 'entry_points.txt'))
            seen.add(name)
            if GROUP in text:
                for module in _in_sections(text):
                    yield Extension(name, module, folders)


def extensions_in_source(package: str, source: Path) -> Iterator[Extension]:
    """
    Find the extensions that a package will have once it is built.

    :param source: The folder with its source
    """
    folders = tuple(str(source / folder) for folder in _IN_SOURCE)
    for file in ('setup.py', 'setup.cfg', 'pyproject.toml'):
        text = text_of(source / file)
        if GROUP not in text:
            continue
        find = _in_setup if file == 'setup.py' else _in_metadata
        for module in find(text):
            yield Extension(package, module, folders, is_installed=False)


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
    """Return the prefix that a virtual environment sees the packages of."""
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
        for entry in _entries(folder):
            if entry.endswith('.pth'):
                for line in text_of(Path(folder, entry)).splitlines():
                    if os.path.isabs(line):
                        yield line.rstrip()


def _entries(folder: str) -> list[str]:
    try:
        return sorted(os.listdir(folder))
    except OSError:
        return []


def _in_sections(text: str) -> Iterator[str]:
    for section in _SECTION.findall(text):
        yield from _ENTRY.findall(section)


def _in_metadata(text: str) -> Iterator[str]:
    """Find the modules that a `setup.cfg` or `pyproject.toml` names."""
    yield from _in_sections(text)
    for lines in _OPTION.findall(text):
        yield from _ENTRY.findall(lines)


def _in_setup(text: str) -> Iterator[str]:
    """Find the modules that the mappings in a `setup.py` name."""
    try:
        nodes = list(ast.walk(ast.parse(text)))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return
    for node in nodes:
        if not isinstance(node, ast.Dict):
            continue
        for key, value in zip(node.keys, node.values, strict=True):
            if isinstance(key, ast.Constant) and key.value == GROUP:
                for inner in ast.walk(value):
                    if isinstance(inner, ast.Constant):
                        yield from _ENTRY.findall(str(inner.value))
