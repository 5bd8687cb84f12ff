# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The command environment of a package that depends on no other, remembered.

That is what colcon calls the variables of a build. It has a shell source the
scripts of the packages that are needed, and print its variables. Where there
are none, it prints what it printed before.
"""

import asyncio
from collections.abc import Awaitable
from collections.abc import Callable
from collections.abc import Mapping
import os
from pathlib import Path
from typing import Any

from colcon_core.plugin_system import SkipExtensionException
from colcon_core.shell import get_shell_extensions

#: Asks a shell as colcon's `generate_command_environment` does.
Ask = Callable[[str, Path, Mapping[str, Any]], Awaitable[dict[str, str]]]

_TASK = 'build'
#: The variable that shells set to the folder that they are started in.
_FOLDER = 'PWD'


def remember_command_environment(folder: Path) -> None:
    """
    Have builds in this process run no shell that is to source nothing.

    The variables of this process must be those of builds. Where a shell
    changes some, builds go on to ask it.

    :param folder: An empty one
    """
    for extensions in get_shell_extensions().values():
        for extension in extensions.values():
            ask = extension.generate_command_environment
            try:
                found = asyncio.run(ask(_TASK, folder, {}))
            except (NotImplementedError, SkipExtensionException):
                continue
            known = _Known(ask, folder, found)
            if known.is_plain:
                extension.generate_command_environment = known.answer
            # the first one that can is asked for all
            return


class _Known:
    def __init__(self, ask: Ask, folder: Path, found: dict[str, str]) -> None:
        self._ask = ask
        self._type = type(found)
        self._scripts = _scripts(folder)
        self._names = set(os.environ)
        expected = {**os.environ, _FOLDER: str(folder)}
        # such as those that libraries in C have set
        self._more = found.items() - expected.items()
        #: Whether the shell has passed all variables on as they are.
        self.is_plain = all(found.get(n) == expected[n] for n in expected)

    async def answer(
        self, task: str, folder: Path, dependencies: Mapping[str, Any]
    ) -> dict[str, str]:
        """Return the variables for a task, as the shell would print them."""
        if (
            task != _TASK
            or dependencies
            or not all(map(self._is_passed_on, os.environ))
            or _scripts(folder) != self._scripts
        ):
            return await self._ask(task, folder, dependencies)
        # colcon has a type of its own where names have no case
        environment = self._type(self._more)
        environment.update(os.environ)
        environment[_FOLDER] = str(folder)
        return environment

    def _is_passed_on(self, name: str) -> bool:
        return name in self._names or (name.isascii() and name.isidentifier())


def _scripts(folder: Path) -> dict[str, bytes]:
    """Return what colcon wrote for the shell, for it or for its users."""
    found = folder.glob(f'colcon_command_prefix_{_TASK}.*')
    return {p.name: p.read_bytes() for p in found if p.suffix != '.env'}
