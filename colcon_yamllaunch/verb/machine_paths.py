# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The files that the part of a machine names, looked for on that machine."""

from collections.abc import Callable, Iterator
from dataclasses import replace
import os.path
from pathlib import Path
import re

from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic, Severity
from colcon_yamllaunch.plan.plan import (
    Component,
    Entry,
    ParameterFile,
    Plan,
    Process,
    Timer,
)
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
)
from colcon_yamllaunch.remote.deployment.deployment import Machine
from colcon_yamllaunch.remote.deployment.remote_paths import (
    is_of_system,
    paths_in,
    RemotePaths,
)
from colcon_yamllaunch.watch.dependencies import is_user_file
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator

#: What is asked of the machine.
LOOK = 'inspection.find_missing'
#: The fix for a program that no package has.
INSTALL = 'install it there'


class MachinePaths:
    """
    Translates paths of this computer to those of a machine.

    :param folders: Where folders of this computer are there
    :param cwd: The folder that the launch is begun in
    :param workspace: The workspace there, if there is one
    :param home: The home folder there
    :param locator: The packages here
    """

    def __init__(
        self,
        machine: Machine,
        folders: RemotePaths,
        cwd: str,
        workspace: str | None,
        home: str,
        locator: PackageLocator,
    ) -> None:
        self._machine = machine
        self.folders = folders
        self._cwd = cwd
        self.workspace = workspace
        self._locator = locator
        # where processes run that run here where the launch is begun
        self._remote_cwd = self._home = home
        #: Whether the workspace there can be sourced.
        self.has_setup = False

    def plan(self, plan: Plan) -> Plan:
        """Return a plan with the paths there."""
        entries = tuple(map(self._with_folder, plan.entries))
        return self.folders.plan(replace(plan, entries=entries))

    def check(
        self, part: Plan, connection: MachineConnection
    ) -> Iterator[Diagnostic]:
        """
        Find what processes are given, and is not there.

        :param part: What is to run there, with the paths of this computer
        :raises UserError: when the machine cannot be asked
        """
        named = dict(self._named(part))
        asked = {path: self.folders.text(path) for path in named}
        setup = f'{self.workspace}/install/setup.bash'
        folders = [self.folders.text(self._cwd), self.workspace or self._home]
        paths = {*asked.values(), setup, *folders}
        answer = connection.ask(LOOK, {'paths': sorted(paths)})
        found = answer.get('missing')
        missing = set(map(str, found)) if isinstance(found, list) else set()
        there = (folder for folder in folders if folder not in missing)
        self._remote_cwd = next(there, self._home)
        self.has_setup = setup not in missing
        for path, process in named.items():
            if asked[path] in missing:
                yield from self._missing(path, process)

    def _named(self, part: Plan) -> Iterator[tuple[str, Process]]:
        """Iterate over the paths that may be missing, and who is given them.

        The last one of each counts, so it begins with the last process.
        """
        for process in reversed(list(part.processes())):
            texts = [a for a in process.argv if isinstance(a, str)]
            for text in reversed(texts):
                for path in paths_in(text):
                    if self.folders.covers(path) or (
                        not is_of_system(path) and os.path.exists(path)
                    ):
                        yield path, process
            program = process.argv[0]
            if isinstance(program, str) and program.startswith('/'):
                yield program, process

    def _missing(self, path: str, process: Process) -> Iterator[Diagnostic]:
        """Report a missing path, if that is a problem."""
        there = self.folders.text(path)
        severity: Severity = 'warning'
        problem, hint = f"there is no '{there}' there", None
        owner = self._locator.owner(path)
        if owner is not None:
            hint = (
                f'let {owner.name} install it, or look for a slip of the pen'
            )
        if path == process.argv[0]:
            problem = f"there is no program '{there}' there"
            if owner is None and process.package is not None:
                hint = f'install the package {process.package} there'
            # as on this computer, the launch goes on without one that no
            # package has
            severity = 'error' if hint else 'warning'
            hint = hint or INSTALL
        elif not self.folders.covers(path):
            problem = f"'{path}' is a file of this computer that is not there"
            hint = (
                'put it into a package of the workspace and name it by '
                '$(find-pkg-share …), or copy it there'
            )
        elif self._locator.package_of(path) and not os.path.exists(path):
            # a program may be about to make it
            return
        machine = self._machine.name
        yield Diagnostic(
            severity,
            f'{process.label} runs on {machine}, and {problem}',
            process.position,
            hint,
        )

    def _with_folder(self, entry: Entry) -> Entry:
        """Return an entry whose processes run in a folder that is there."""
        if isinstance(entry, Timer):
            inner = tuple(map(self._with_folder, entry.entries))
            return replace(entry, entries=inner)
        if isinstance(entry, Process) and entry.cwd == self._cwd:
            return replace(entry, cwd=self._remote_cwd)
        return entry


#: What no path of a package has, and what stands around paths has.
_BETWEEN = r'[^\s:,;\'"<>|&()\[\]{}]*'
_WORD = re.compile(r'[^\s:=,;\'"<>|&()\[\]{}]+')


def packages_of(
    plan: Plan, locator: PackageLocator, root: Path, install_base: Path
) -> frozenset[str]:
    """
    Return the packages of the workspace that a part of a plan names.

    It names them as the package of a program or component, or by a path, in
    whatever it gives a process.

    :param root: The root of the workspace
    :param install_base: Where its packages are installed
    """
    own = {package.name for package in locator.packages()}
    found = {process.package for process in plan.processes()}
    found.update(component.package for component in plan.components())
    bases = dict.fromkeys(
        str(path)
        for base in (install_base, root)
        for path in (base, os.path.realpath(base))
    )
    pattern = re.compile(f'(?:{"|".join(map(re.escape, bases))})/{_BETWEEN}')
    paths = {path for text in texts_of(plan) for path in pattern.findall(text)}
    for path in paths:
        package = locator.owner(path) or locator.package_of(path)
        if package is not None:
            found.add(package.name)
    return frozenset(name for name in found if name in own)


def files_of(
    part: Process | Component, covers: Callable[[str], bool]
) -> frozenset[str]:
    """
    Return the files that a process or component names, as absolute paths.

    :param covers: Whether a file counts that does not exist here
    """
    folder = part.cwd if isinstance(part, Process) else os.sep
    found = set()
    for text in _texts(part):
        words = (text, text.rpartition('=')[2], *_WORD.findall(text))
        for word in words:
            path = os.path.normpath(os.path.join(folder, word.strip('"\'')))
            if os.sep in word and '\0' not in path:
                found.add(path)
    return frozenset(
        path
        for path in found
        if covers(path) or (is_user_file(path) and os.path.isfile(path))
    )


def texts_of(plan: Plan) -> Iterator[str]:
    """Iterate over all texts of a plan that may have paths in them."""
    for process in plan.processes():
        yield from _texts(process)
    for component in plan.components():
        yield from _texts(component)


def _texts(part: Process | Component) -> Iterator[str]:
    parameters = list(part.parameters)
    if isinstance(part, Component):
        parameters += part.extra_arguments
    else:
        yield part.cwd
        for argument in part.argv:
            if isinstance(argument, ParameterFile):
                yield argument.content
                parameters += argument.parameters
            else:
                yield argument
        for _, value in part.environment:
            yield value or ''
    for parameter in parameters:
        yield parameter.value
