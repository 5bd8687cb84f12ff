# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What the environment that a setup script makes comes from.

The script is followed as bash would: through the prefixes that it chains, the
packages of each and their hooks. That is possible only as long as all that
runs is known; a hook that is a script may do and read anything.
"""

from collections.abc import Iterable
from collections.abc import Mapping
import glob
import os
from pathlib import Path
import re

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.search_path import split_path
from colcon_yamllaunch.workspace.environment.environment_hooks import (
    DamagedHooksError,
)
from colcon_yamllaunch.workspace.environment.environment_hooks import Hooks
from colcon_yamllaunch.workspace.environment.environment_hooks import (
    read_hooks,
)
from colcon_yamllaunch.workspace.environment.setup_script_digests import (
    ament_prefix_script,
)
from colcon_yamllaunch.workspace.environment.setup_script_digests import (
    chained_prefixes,
)
from colcon_yamllaunch.workspace.environment.setup_script_digests import (
    colcon_prefix_script,
)
from colcon_yamllaunch.workspace.environment.setup_script_digests import (
    commands,
)
from colcon_yamllaunch.workspace.environment.setup_script_digests import (
    is_ament_bash_script,
)
from colcon_yamllaunch.workspace.environment.setup_script_digests import (
    is_ament_prefix_util,
)
from colcon_yamllaunch.workspace.environment.setup_script_digests import (
    is_colcon_prefix_util,
)
from colcon_yamllaunch.workspace.environment.sourcing import OWN_VARIABLES
from colcon_yamllaunch.workspace.environment.sourcing import SCRIPT

#: Where colcon and ament list the packages of a prefix.
_COLCON_INDEX = 'share/colcon-core/packages'
_AMENT_INDEX = 'share/ament_index/resource_index'

#: Text that means itself within double quotes, and in a list of paths.
_PLAIN_TEXT = re.compile(r'[^$`"\\\n]*')
_PLAIN_PATHS = re.compile(r'[^$`"\\\n*?\[\]]*')
_NAME = re.compile(r'[A-Za-z_][A-Za-z0-9_]*')
#: Variables that bash gives another value whenever they are used.
_RESTLESS = frozenset(
    ('BASHPID', 'EPOCHREALTIME', 'EPOCHSECONDS', 'HISTCMD', 'LINENO')
) | frozenset(('PPID', 'RANDOM', 'SECONDS', 'SRANDOM', *OWN_VARIABLES))
_FUNCTION = re.compile(r'BASH_FUNC_(.*)(?:%%|\(\))', re.S)
_ELF = b'\x7fELF'
#: Where a Python looks for what runs whenever it starts, below its prefix and
#: below the home folder (Python's module `site`, with Debian's changes).
_PYTHON_FOLDERS = (
    'lib/python3*',
    'lib/python3*/*-packages',
    'local/lib/python3*/*-packages',
)
_USER_FOLDERS = (
    '.local/lib',
    '.local/lib/python3*',
    '.local/lib/python3*/site-packages',
)


class UnknownContentError(Exception):
    """Something that sourcing runs is not known."""


@dataclass(frozen=True, slots=True)
class SetupInputs:
    """
    What an environment comes from, beside the caller's.

    :param paths: Files, folders and what is looked for and may be missing
    :param promised: For each package of the script's own prefix the variables
      with the path that its hooks put into each
    """

    paths: tuple[str, ...]
    promised: Mapping[str, tuple[tuple[str, str], ...]]


def setup_inputs(
    setup: Path, environment: Mapping[str, str], programs: Iterable[str]
) -> SetupInputs:
    """
    Find out what sourcing a setup script depends on.

    :param setup: The script
    :param environment: The variables that it is sourced with
    :param programs: The programs that source it
    :raises UnknownContentError: when it runs something that is not known
    """
    if str(setup) != os.path.normpath(setup) or not setup.is_absolute():
        raise UnknownContentError(setup)
    following = _Following(environment)
    try:
        return following.follow(setup, programs)
    except (OSError, DamagedHooksError) as e:
        raise UnknownContentError(e) from e


class _Following:
    def __init__(self, environment: Mapping[str, str]) -> None:
        self._environment = environment
        self._paths: dict[str, None] = {}
        self._words: set[str] = set()
        self._promised: dict[str, tuple[tuple[str, str], ...]] = {}

    def follow(self, setup: Path, programs: Iterable[str]) -> SetupInputs:
        self._add(*programs)
        self._words |= commands(SCRIPT)
        self._look_up('bash')
        self._look_up('dirname')
        chained = chained_prefixes(self._read(str(setup)))
        if chained is None:
            raise UnknownContentError(setup)
        for prefix in chained:
            self._follow_prefix(prefix)
        # those of other prefixes are no packages of this workspace
        self._promised.clear()
        self._follow_prefix(str(setup.parent))
        self._refuse_functions()
        return SetupInputs(tuple(self._paths), self._promised)

    def _add(self, *paths: str) -> None:
        self._paths.update(dict.fromkeys(paths))

    def _read(self, path: str) -> str:
        self._add(path)
        with open(path, encoding='utf-8', errors='surrogateescape') as file:
            text = file.read()
        self._words |= commands(text)
        return text

    def _look_up(self, program: str) -> None:
        for folder in self._environment.get('PATH', os.defpath).split(':'):
            path = os.path.abspath(os.path.join(folder, program))
            self._add(path)
            if os.access(path, os.X_OK):
                return

    def _follow_prefix(self, prefix: str) -> None:
        if not _PLAIN_PATHS.fullmatch(prefix):
            raise UnknownContentError(prefix)
        path = os.path.join(prefix, 'local_setup.bash')
        text = self._read(path)
        script = colcon_prefix_script(text)
        if script is not None:
            self._follow_python(script.python, 'COLCON_PYTHON_EXECUTABLE')
            self._follow_colcon_prefix(prefix, script.merge_install)
        elif is_ament_bash_script(text):
            self._follow_ament_prefix(prefix)
        else:
            raise UnknownContentError(path)

    def _follow_colcon_prefix(self, prefix: str, merge_install: bool) -> None:
        # the script evaluates what is in this variable
        value = self._environment.get('COLCON_PREFIX_PATH', '')
        util = os.path.join(prefix, '_local_setup_util_sh.py')
        if not (
            _PLAIN_PATHS.fullmatch(value)
            and is_colcon_prefix_util(self._read(util))
        ):
            raise UnknownContentError(util)
        index = os.path.join(prefix, _COLCON_INDEX)
        self._add(prefix, index)
        listed = index if merge_install else prefix
        for name in _folder(listed):
            own = prefix if merge_install else os.path.join(prefix, name)
            if os.path.isfile(own):
                continue
            entry = os.path.join(own, _COLCON_INDEX, name)
            self._add(entry)
            if os.path.isfile(entry):
                self._follow_package(own, name)

    def _follow_ament_prefix(self, prefix: str) -> None:
        path = os.path.join(prefix, 'local_setup.sh')
        script = ament_prefix_script(self._read(path))
        util = os.path.join(prefix, '_local_setup_util.py')
        if script is None or not is_ament_prefix_util(self._read(util)):
            raise UnknownContentError(path)
        self._follow_python(script.python, 'AMENT_PYTHON_EXECUTABLE')
        index = os.path.join(prefix, _AMENT_INDEX)
        listed = os.path.join(index, 'packages')
        self._add(prefix, listed)
        for name in _folder(listed):
            self._add(
                os.path.join(listed, name),
                os.path.join(index, 'package_run_dependencies', name),
            )
            if self._follow_package(prefix, name).files:
                continue
            # what is sourced when there is no package.dsv
            setup = os.path.join(prefix, 'share', name, 'local_setup')
            self._add(f'{setup}.bash', f'{setup}.sh')
            if os.path.exists(f'{setup}.bash') or os.path.exists(
                f'{setup}.sh'
            ):
                raise UnknownContentError(setup)

    def _follow_package(self, prefix: str, name: str) -> Hooks:
        hooks = read_hooks(prefix, name)
        if hooks.scripts:
            raise UnknownContentError(hooks.scripts[0])
        for variable, value in hooks.texts:
            if (
                not _NAME.fullmatch(variable)
                or variable in _RESTLESS
                or not _PLAIN_TEXT.fullmatch(value)
                # which encoding it is read in depends on much
                or not value.isascii()
            ):
                raise UnknownContentError(f'{name}: {variable}={value}')
        self._add(*hooks.files, *hooks.tested)
        self._promised[name] = tuple(hooks.extended)
        return hooks

    def _follow_python(self, filled_in: str, override: str) -> None:
        python = self._environment.get(override) or filled_in
        if not os.path.isabs(python) or not _is_program(python):
            raise UnknownContentError(python)
        real = os.path.realpath(python)
        places = {
            os.path.dirname(os.path.dirname(path)) for path in (python, real)
        }
        folders = [
            folder
            for place in sorted(places)
            for folder in _matching(place, _PYTHON_FOLDERS)
        ]
        folders += _matching(self._environment.get('HOME'), _USER_FOLDERS)
        for folder in folders:
            self._add(folder, *glob.glob(f'{glob.escape(folder)}/*.pth'))
        self._add(python, *(f'{place}/pyvenv.cfg' for place in places))
        path = split_path(self._environment.get('PYTHONPATH'))
        for folder in [*folders, *map(os.path.abspath, path)]:
            self._add(f'{folder}/sitecustomize.py')
            self._add(f'{folder}/usercustomize.py')

    def _refuse_functions(self) -> None:
        for name in self._environment:
            function = _FUNCTION.fullmatch(name)
            if function is not None and function[1] in self._words:
                raise UnknownContentError(name)


def _folder(path: str) -> list[str]:
    if not os.path.isdir(path):
        return []
    names = os.listdir(path)
    return sorted(name for name in names if not name.startswith('.'))


def _matching(place: str | None, patterns: Iterable[str]) -> list[str]:
    if not place:
        return []
    return [
        path
        for pattern in patterns
        for path in sorted(
            glob.glob(os.path.join(glob.escape(place), pattern))
        )
    ]


def _is_program(path: str) -> bool:
    with open(path, 'rb') as file:
        return file.read(len(_ELF)) == _ELF
