# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What is adapted to a machine.

The paths of the workspace are replaced by those there, and
:func:`sent_variables` returns the environment variables that are sent.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
import json
import os
import os.path
import re
from typing import Any

from colcon_yamllaunch.plan.plan import (
    Component,
    ParameterFile,
    Plan,
    Process,
    SetParameter,
    Timer,
)

#: The variables of the user that are sent to each machine.
SENT = (
    'ROS_*',
    'RMW_*',
    'CYCLONEDDS_URI',
    'FASTRTPS_*',
    'FASTDDS_*',
    'TERM',
    'COLORTERM',
)
#: Exceptions, which depend on the installation there.
NOT_SENT = (
    'ROS_DISTRO',
    'ROS_VERSION',
    'ROS_PYTHON_VERSION',
    'ROS_LOG_DIR',
    'ROS_HOME',
    'ROS_PACKAGE_PATH',
    'ROS_ROOT',
    'ROS_ETC_DIR',
)
#: Folders whose files are not copied from one machine to another.
SYSTEM = ('/dev', '/proc', '/run', '/sys')

#: The fields that have paths, of entries of a plan and what they consist of.
_WITH_PATHS: Mapping[type, Sequence[str]] = {
    Process: ('argv', 'cwd', 'environment', 'parameters'),
    Component: ('parameters', 'extra_arguments'),
    Timer: ('entries',),
    ParameterFile: ('content', 'parameters'),
    SetParameter: ('value',),
}

# a path begins where no other path or word goes on …
_BEFORE = r'(?<![\w.~+-])'
# … and its folder ends where its name does
_AFTER = r'(?![\w~+@%#-]|\.[\w.])'


class RemotePaths:
    """
    The folders of the workspace, here and on a machine.

    :param folders: Absolute paths here, and the paths there
    """

    def __init__(self, folders: Mapping[str, str]) -> None:
        found = {}
        for here, there in folders.items():
            for path in (here, os.path.realpath(here)):
                path = path.rstrip('/')
                if path and path not in found:
                    found[path] = there.rstrip('/') or '/'
        self._folders = dict(
            sorted(found.items(), key=lambda pair: -len(pair[0]))
        )
        written = {**self._folders}
        for here, there in self._folders.items():
            # as values of parameters are, in JSON
            written[json.dumps(here)[1:-1]] = json.dumps(there)[1:-1]
        self._written = written
        # a folder that is the same there must not be replaced by a shorter one
        self.is_same = all(a == b for a, b in found.items())
        listed = sorted(written, key=len, reverse=True)
        alternatives = '|'.join(map(re.escape, listed))
        self._pattern = re.compile(f'{_BEFORE}(?:{alternatives}){_AFTER}')

    def text(self, text: str) -> str:
        """Return a text with the paths there, at any place in it."""
        if self.is_same or not self._folders:
            return text
        return self._pattern.sub(lambda m: self._written[m.group()], text)

    def covers(self, path: str) -> bool:
        """Return whether a path is in one of the folders."""
        return any(
            path == folder or path.startswith(f'{folder}/')
            for folder in self._folders
        )

    def plan(self, plan: Plan) -> Plan:
        """Return a plan with the paths of the machine."""
        return replace(plan, entries=self._with_paths(plan.entries))

    def environment(self, variables: Mapping[str, str]) -> dict[str, str]:
        """Return variables with the paths of the machine."""
        return {name: self.text(text) for name, text in variables.items()}

    def _with_paths(self, value: Any) -> Any:
        """Return a part of a plan with the paths of the machine."""
        if isinstance(value, str):
            return self.text(value)
        if isinstance(value, tuple):
            return tuple(map(self._with_paths, value))
        fields = _WITH_PATHS.get(type(value), ())
        changed = {f: self._with_paths(getattr(value, f)) for f in fields}
        return replace(value, **changed) if changed else value


def is_of_system(path: str) -> bool:
    """Return whether a path is one that each machine has for itself."""
    return any(path == top or path.startswith(f'{top}/') for top in SYSTEM)


def sent_variables(
    environment: Mapping[str, str], names: Sequence[str] = ()
) -> dict[str, str]:
    """
    Return the variables of the user that are sent to a machine.

    :param names: The names in `env:` of the machine
    """
    return {
        name: value
        for name, value in environment.items()
        if name in names
        or (
            name not in NOT_SENT
            and any(fnmatchcase(name, pattern) for pattern in SENT)
        )
    }


def paths_in(text: str) -> Iterator[str]:
    """Return the absolute paths in a word, as in `file:=/a/b` or `/a:/b`."""
    for part in re.split(r'[:=,;\s\'"]', text):
        if part.startswith('//'):
            # the rest of a URL: file:///a, https://host/a
            part = part[2:]
        if part.startswith('/') and len(part) > 1:
            yield os.path.normpath(part)
