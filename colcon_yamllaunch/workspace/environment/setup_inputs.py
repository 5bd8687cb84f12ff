# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What the environment that a setup script makes comes from.

In bash it does little: it sources the scripts of the prefixes that it chains
and of its own, and each of these evaluates what a Python program prints. So
the scripts have to be as colcon and ament write them, what the programs look
at is traced, and what they print has to be plain assignments. A hook that is a
script may do and read anything.
"""

from collections.abc import Mapping
import json
import os
from pathlib import Path
import re
import subprocess

from colcon_yamllaunch.workspace.environment.sourcing import OWN_VARIABLES
from colcon_yamllaunch.workspace.environment.sourcing import SCRIPT
from colcon_yamllaunch.workspace.environment.sourcing import SOURCE_TIMEOUT
from colcon_yamllaunch.workspace.environment.templates import ament_template
from colcon_yamllaunch.workspace.environment.templates import colcon_template
from colcon_yamllaunch.workspace.environment.templates import is_from_template
from colcon_yamllaunch.workspace.environment.templates import LITERAL

_TRACED_PYTHON = Path(__file__).with_name('traced_python.py')
_ELF = b'\x7fELF'
_WORD = re.compile(r'[\w.:\[-]+')
_COMMENT = re.compile(r'^ *#.*$', re.M)
_FUNCTION = re.compile(r'BASH_FUNC_(.*)(?:%%|\(\))', re.S)
_CHAINED = re.compile(rf'^COLCON_CURRENT_PREFIX="({LITERAL})"$', re.M)
_PYTHON = re.compile(r'_(colcon|ament)_python_executable="([\w./+@:,%=-]+)"')
#: Variables by which a user chooses another Python.
_OVERRIDES = {
    'colcon': 'COLCON_PYTHON_EXECUTABLE',
    'ament': 'AMENT_PYTHON_EXECUTABLE',
}
#: A list of paths that a shell leaves as it is, even without quotes.
_PLAIN_PATHS = re.compile(r'[^$`"\\\n*?\[\]]*')
#: Variables that bash gives another value whenever they are used.
_RESTLESS = frozenset(
    ('BASHPID', 'EPOCHREALTIME', 'EPOCHSECONDS', 'HISTCMD', 'LINENO')
) | frozenset(('PPID', 'RANDOM', 'SECONDS', 'SRANDOM', *OWN_VARIABLES))
#: A variable is set to a text, with its value before at one end.
_SET = re.compile(
    r'export ([A-Za-z_]\w*)="((?:\$\1:)?[^$`"\\\n]*(?::\$\1)?)"', re.A
)
#: A colon at an end is cut off; older versions of ament run programs for it.
_CUT = re.compile(
    r'export (\w+)=\$\{\1[#%]:\}'
    r'|if \[ "\$\(echo -n \$(\w+) \| (?:head|tail) -c 1\)" = ":" \]; '
    r'then export \2=\$\{\2[#%]\?\} ; fi',
    re.A,
)


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
    except (OSError, ValueError, subprocess.SubprocessError) as e:
        raise UnknownContentError(e) from e


class _Inputs:
    def __init__(self, environment: Mapping[str, str]) -> None:
        #: As it is when the next prefix is sourced.
        self._environment = dict(environment)
        self._paths: dict[str, None] = {}
        functions = map(_FUNCTION.fullmatch, environment)
        self._functions = {found[1] for found in functions if found}

    def follow(self, setup: Path) -> tuple[str, ...]:
        self._require(not self._functions & _commands(SCRIPT), 'a function')
        text = self._read(str(setup), colcon_template('setup.bash'))
        for prefix in [*_CHAINED.findall(text), str(setup.parent)]:
            self._follow_prefix(prefix)
        return tuple(self._paths)

    def _require(self, condition: bool, unknown: str) -> None:
        if not condition:
            raise UnknownContentError(unknown)

    def _read(self, path: str, *templates: Path | None) -> str:
        self._paths[path] = None
        with open(path, encoding='utf-8', errors='surrogateescape') as file:
            text = file.read()
        self._require(any(is_from_template(text, t) for t in templates), path)
        self._require(not self._functions & _commands(text), path)
        return text

    def _follow_prefix(self, prefix: str) -> None:
        # the list goes through a script without quotes
        known = self._environment.get('COLCON_PREFIX_PATH', '')
        self._require(
            _PLAIN_PATHS.fullmatch(f'{prefix}:{known}') is not None, prefix
        )
        name = 'local_setup.bash'
        text = self._read(
            os.path.join(prefix, name),
            colcon_template(name),
            ament_template(prefix, name),
        )
        program = '_local_setup_util_sh.py'
        if _PYTHON.search(text) is None:
            # that of ament leaves the work to another one
            name = 'local_setup.sh'
            text = self._read(
                os.path.join(prefix, name), ament_template(prefix, name)
            )
            program = '_local_setup_util.py'
        arguments = [os.path.join(prefix, program), 'sh', 'bash']
        if '--merged-install' in text:
            arguments.append('--merged-install')
        for line in self._trace(self._python(text), arguments).splitlines():
            self._assign(line)

    def _python(self, script: str) -> str:
        found = _PYTHON.search(script)
        if found is None:
            raise UnknownContentError(script)
        override = self._environment.get(_OVERRIDES[found[1]])
        python = override or found[2]
        with open(python, 'rb') as file:
            is_program = file.read(len(_ELF)) == _ELF
        self._require(os.path.isabs(python) and is_program, python)
        self._paths[python] = None
        return python

    def _trace(self, python: str, arguments: list[str]) -> str:
        traced = subprocess.run(
            [python, _TRACED_PYTHON, *arguments],
            env=self._environment,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=SOURCE_TIMEOUT,
            check=True,
        )
        paths, printed = json.loads(traced.stdout)
        self._paths |= dict.fromkeys(paths)
        return str(printed)

    def _assign(self, line: str) -> None:
        # which encoding a value is read in depends on much
        self._require(line.isascii(), line)
        found = _SET.fullmatch(line)
        if found is not None:
            name, value = found.groups()
            self._require(name not in _RESTLESS, line)
            before = self._environment.get(name, '')
            self._environment[name] = value.replace(f'${name}', before)
        elif not line.startswith('#'):
            self._require(_CUT.fullmatch(line) is not None, line)


def _commands(script: str) -> set[str]:
    """Return the words of a script, the names of its commands among them."""
    return set(_WORD.findall(_COMMENT.sub('', script)))
