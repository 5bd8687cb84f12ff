# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What the environment that a setup script makes comes from.

The scripts that colcon and ament write do what the descriptions of hooks say.
So their paths tell all, as long as each script is from its template and no
hook is a script, which may do and read anything.
"""

from collections.abc import Mapping
import os
from pathlib import Path
import re

from colcon_yamllaunch.common.search_path import split_path
from colcon_yamllaunch.common.text_files import content_of
from colcon_yamllaunch.workspace.environment import hooks
from colcon_yamllaunch.workspace.environment import setup_templates
from colcon_yamllaunch.workspace.environment.sourcing import OWN_VARIABLES

#: Where colcon and ament list the packages of a prefix.
_COLCON_INDEX = 'share/colcon-core/packages'
_AMENT_INDEX = 'share/ament_index/resource_index'
_CHAINED = re.compile(
    rf'^COLCON_CURRENT_PREFIX="({setup_templates.LITERAL})"$', re.M
)
_PYTHON = re.compile(r'_(colcon|ament)_python_executable="([\w./+@:,%=-]+)"')
#: Variables by which a user chooses another Python.
_OVERRIDES = {
    'colcon': 'COLCON_PYTHON_EXECUTABLE',
    'ament': 'AMENT_PYTHON_EXECUTABLE',
}
_ELF = b'\x7fELF'
#: Where a Python looks for what runs whenever it starts (module `site`).
_PYTHON_FOLDERS = (
    'lib/python3*',
    'lib/python3*/*-packages',
    'local/lib/python3*/*-packages',
)
#: Text that means itself within double quotes, and in a list of paths.
_PLAIN_TEXT = re.compile(setup_templates.LITERAL)
_PLAIN_PATHS = re.compile(r'[^$`"\\\n*?\[\]]*')
_NAME = re.compile(r'[A-Za-z_]\w*', re.A)
#: Variables that bash gives another value whenever they are used.
_RESTLESS = frozenset(
    ('BASHPID', 'EPOCHREALTIME', 'EPOCHSECONDS', 'HISTCMD', 'LINENO')
) | frozenset(('PPID', 'RANDOM', 'SECONDS', 'SRANDOM', *OWN_VARIABLES))


class UnknownContentError(Exception):
    """Something that sourcing runs is not known."""


def setup_inputs(
    setup: Path, environment: Mapping[str, str]
) -> tuple[str, ...]:
    """
    Return the paths that sourcing a setup script depends on.

    They are files, folders and what is looked for and may be missing.

    :param environment: The variables that it is sourced with
    :raises UnknownContentError: when it runs something that is not known
    """
    try:
        return _Inputs(environment).follow(setup)
    except (OSError, hooks.DamagedHooksError) as e:
        raise UnknownContentError(e) from e


class _Inputs:
    def __init__(self, environment: Mapping[str, str]) -> None:
        self._environment = environment
        self._paths: dict[str, None] = {}

    def follow(self, setup: Path) -> tuple[str, ...]:
        for name in self._environment:
            # a function may stand for any command of the scripts
            if name.startswith('BASH_FUNC_'):
                raise UnknownContentError(name)
        text = self._read(setup, setup_templates.colcon(setup.name))
        for prefix in [*_CHAINED.findall(text), str(setup.parent)]:
            self._follow_prefix(Path(prefix))
        return tuple(self._paths)

    def _note(self, *paths: Path | str) -> None:
        self._paths.update(dict.fromkeys(map(str, paths)))

    def _read(self, path: Path, *templates: Path | None) -> str:
        self._note(path)
        text = content_of(path).decode('utf-8', 'surrogateescape')
        if not any(setup_templates.is_from(t, text) for t in templates):
            raise UnknownContentError(path)
        return text

    def _follow_prefix(self, prefix: Path) -> None:
        # the list goes through a script without quotes
        known = self._environment.get('COLCON_PREFIX_PATH', '')
        if not _PLAIN_PATHS.fullmatch(f'{prefix}:{known}'):
            raise UnknownContentError(prefix)
        name = 'local_setup.bash'
        of_colcon = setup_templates.colcon(name)
        of_ament = setup_templates.ament(prefix, name)
        text = self._read(prefix / name, of_colcon, of_ament)
        if _PYTHON.search(text):
            self._follow_colcon(prefix, text)
        else:
            self._follow_ament(prefix)

    def _follow_colcon(self, prefix: Path, script: str) -> None:
        util = '_local_setup_util_sh.py'
        self._read(prefix / util, setup_templates.colcon(util))
        self._follow_python(script)
        is_merged = '--merged-install' in script
        listed = prefix / _COLCON_INDEX if is_merged else prefix
        for name in self._names(listed):
            own = prefix if is_merged else prefix / name
            entry = own / _COLCON_INDEX / name
            self._note(entry)
            if entry.is_file():
                self._follow_package(own, name)

    def _follow_ament(self, prefix: Path) -> None:
        script, _ = (
            self._read(prefix / name, setup_templates.ament(prefix, name))
            for name in ('local_setup.sh', '_local_setup_util.py')
        )
        self._follow_python(script)
        index = prefix / _AMENT_INDEX
        for name in self._names(index / 'packages'):
            self._note(index / 'packages' / name)
            self._note(index / 'package_run_dependencies' / name)
            if not self._follow_package(prefix, name):
                # one of its scripts is sourced instead
                raise UnknownContentError(name)

    def _names(self, folder: Path) -> list[str]:
        self._note(folder)
        names = os.listdir(folder) if os.path.isdir(folder) else []
        return sorted(name for name in names if not name.startswith('.'))

    def _follow_package(self, prefix: Path, name: str) -> bool:
        done = hooks.read_hooks(str(prefix), name)
        self._note(*done.paths)
        for script in done.scripts:
            raise UnknownContentError(script)
        for variable, value in done.texts:
            if (
                not _NAME.fullmatch(variable)
                or variable in _RESTLESS
                or not _PLAIN_TEXT.fullmatch(value)
                # which encoding it is read in depends on much
                or not value.isascii()
            ):
                raise UnknownContentError(f'{name}: {variable}={value}')
        return os.path.exists(done.paths[0])

    def _follow_python(self, script: str) -> None:
        found = _PYTHON.search(script)
        if found is None:
            raise UnknownContentError(script)
        override = self._environment.get(_OVERRIDES[found[1]])
        python = Path(override or found[2])
        with python.open('rb') as file:
            if not python.is_absolute() or file.read(len(_ELF)) != _ELF:
                raise UnknownContentError(python)
        home = self._environment.get('HOME', os.path.expanduser('~'))
        own = {python.parents[1], python.resolve().parents[1]}
        self._note(python, *(place / 'pyvenv.cfg' for place in own))
        folders = split_path(self._environment.get('PYTHONPATH'))
        for place in (*own, Path(home, '.local')):
            self._note(place / 'lib')
            for pattern in _PYTHON_FOLDERS:
                folders += map(str, place.glob(pattern))
        for folder in map(Path, map(os.path.abspath, folders)):
            self._note(folder, *folder.glob('*.pth'))
            self._note(*folder.glob('*customize.py'))
