# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What each process of a plan uses, as its entry and its program tell.

That is the program, the files that its arguments, variables and parameters
name, and the packages whose code it may run. Nothing is started for that.
"""

from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from dataclasses import replace
import os
import shlex
import shutil

from colcon_yamllaunch.plan.labels import MACHINE_SEPARATOR
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import ParameterFile
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.plan import SetParameter
from colcon_yamllaunch.watch.knowledge import is_edited
from colcon_yamllaunch.watch.knowledge import ProcessUse
from colcon_yamllaunch.watch.knowledge import RunsThere
from colcon_yamllaunch.workspace.packages.package import Package

_PYTHON_SUFFIX = '.py'
_ELF = b'\x7fELF'
_LONGEST_PATH = 4096
#: Links that lead to links.
_LONGEST_CHAIN = 8
_SHELLS = frozenset(('bash', 'dash', 'sh', 'zsh'))
_ROS = 'ros2'


class ProcessUses:
    """
    What the processes and components of a plan use.

    :param packages: Those of the workspace that the launch needs
    :param libraries: What is known of the files mapped into processes
    :param environment: That of the processes
    :param install: The install base, with a separator at its end
    :param own: The folders that may have files of the user, each so
    :param there: What of the plan runs on other machines
    """

    def __init__(
        self,
        plan: Plan,
        packages: Collection[Package],
        libraries: Mapping[str, frozenset[str] | None],
        environment: Mapping[str, str],
        install: str,
        own: tuple[str, ...],
        there: RunsThere,
    ) -> None:
        self._plan = plan
        self._install = install
        self._own = own
        self._there = there
        self._needs = {
            p.name: p.build_depends | p.run_depends for p in packages
        }
        self._libraries = libraries
        self._environment = environment
        self._closures: dict[str, frozenset[str]] = {}
        self._files: dict[str, str | None] = {}
        self._kinds: dict[str, bool] = {}
        self._folders: dict[str, str] = {}

    def all(self) -> Iterator[ProcessUse]:
        """Iterate over what each of them uses, in the order of the launch."""
        components = tuple(self._plan.components())
        inside: dict[str, set[str]] = {}
        for component in components:
            inside.setdefault(component.container, set()).add(
                component.package
            )
        containers = {}
        for process in self._plan.processes():
            if process.is_container and process.node_name:
                containers[process.node_name] = process.label
            loaded = inside.get(process.node_name or '', ())
            yield self._placed(self._process(process, loaded))
        for component in components:
            label = containers.get(component.container)
            yield self._placed(self._component(component, label))

    def _placed(self, use: ProcessUse) -> ProcessUse:
        """Return what a process uses on the machine that it runs on."""
        machine = self._there.machines.get(use.label)
        if machine is None:
            return use
        # links here say nothing about the files there
        return replace(
            use,
            program=None,
            files=frozenset(
                f'{machine}{MACHINE_SEPARATOR}{path}'
                for path in self._there.files[use.label]
            ),
            may_run_python=use.may_run_python
            or not os.path.exists(use.program or ''),
            libraries=None,
            machine=machine,
        )

    def _process(self, process: Process, loaded: Iterable[str]) -> ProcessUse:
        words = [w for w in process.argv if isinstance(w, str)]
        if words and os.path.basename(words[0]) in _SHELLS:
            # what a shell is given
            words += [part for word in words[1:] for part in _split(word)]
        program = self._program(process, words[0]) if words else None
        named = self._named(words[1:], process.cwd)
        named |= self._values(process.parameters, process.cwd)
        for word in process.argv:
            if isinstance(word, ParameterFile):
                named |= self._values(word.parameters, process.cwd)
        values = [v for _, v in process.environment if v is not None]
        named |= self._named(values, process.cwd)
        owners = [o for o in map(self._owner, words) if o is not None]
        package = process.package
        if package is None and owners:
            package = owners[0]
        packages = {*loaded, *self._commanded(words), *owners}
        if package is not None:
            packages.add(package)
        return ProcessUse(
            process.label,
            program,
            package,
            self._closure(packages),
            frozenset(named - {program}),
            program is None
            or self._may_run_python(program)
            or any(map(self._may_run_python, named)),
            self._libraries.get(process.label),
        )

    def _component(
        self, component: Component, container: str | None
    ) -> ProcessUse:
        named = self._values(component.parameters, '')
        named |= self._values(component.extra_arguments, '')
        return ProcessUse(
            component.label,
            None,
            component.package,
            self._closure((component.package,)),
            frozenset(named),
            is_component=True,
            container=container,
        )

    def _closure(self, names: Iterable[str]) -> frozenset[str]:
        """Return packages of the workspace with all that they need."""
        found: frozenset[str] = frozenset()
        for name in names:
            if name not in self._closures:
                pending, reached = [name], set()
                while pending:
                    current = pending.pop()
                    if current in self._needs and current not in reached:
                        reached.add(current)
                        pending += self._needs[current]
                self._closures[name] = frozenset(reached)
            found |= self._closures[name]
        return found

    def _owner(self, word: str) -> str | None:
        """Return the package of the workspace that has a program."""
        if not word.startswith(self._install):
            return None
        parts = word[len(self._install) :].split(os.sep)
        # merged or not, programs are in lib/PACKAGE
        if 'lib' in parts[:-2]:
            name = parts[parts.index('lib') + 1]
            if name in self._needs:
                return name
        return None

    def _commanded(self, words: Iterable[str]) -> set[str]:
        """Return the packages whose programs a command of ROS 2 starts."""
        names = {os.path.basename(word) for word in words}
        if _ROS not in names:
            return set()
        if 'launch' in names:
            # which ones it does not tell
            return set(self._needs)
        return names & self._needs.keys()

    def _program(self, process: Process, word: str) -> str | None:
        if os.sep not in word:
            changed = dict(process.environment)
            path = changed.get('PATH', self._environment.get('PATH'))
            found = shutil.which(word, path=path)
            if found is None:
                return None
            word = found
        return self._real(os.path.join(process.cwd, word))

    def _named(self, words: Iterable[str], cwd: str) -> set[str]:
        """Return the files that words name, behind all links."""
        found = set()
        for word in words:
            # as `--file=PATH`, `file:=PATH`
            for part in (word, word.rpartition('=')[2]):
                if os.sep in part:
                    path = os.path.join(cwd, part)
                    if path not in self._files:
                        self._files[path] = self._file(path)
                    real = self._files[path]
                    if real is not None:
                        found.add(real)
        return found

    def _file(self, path: str) -> str | None:
        """Return the file that a path names, if one may edit it."""
        if len(path) > _LONGEST_PATH or not path.isprintable():
            return None
        real = self._real(path)
        if not is_edited(real, self._own):
            return None
        if os.path.isfile(real):
            return real
        # one that may come
        is_likely = '.' in os.path.basename(real) and not os.path.exists(real)
        return (
            real
            if is_likely and os.path.isdir(os.path.dirname(real))
            else None
        )

    def _real(self, path: str) -> str:
        """Return what is behind all links, as `os.path.realpath` does."""
        for _ in range(_LONGEST_CHAIN):
            # most files are in few folders
            folder, base = os.path.split(os.path.normpath(path))
            if folder not in self._folders:
                self._folders[folder] = os.path.realpath(folder)
            path = os.path.join(self._folders[folder], base)
            try:
                target = os.readlink(path)
            except OSError:
                return path
            path = os.path.join(os.path.dirname(path), target)
        return os.path.realpath(path)

    def _values(
        self, parameters: Iterable[SetParameter], cwd: str
    ) -> set[str]:
        return self._named((p.value.strip('"\'') for p in parameters), cwd)

    def _may_run_python(self, path: str) -> bool:
        """Tell whether a program is or may start a Python."""
        if path not in self._kinds:
            self._kinds[path] = _may_run_python(path)
        return self._kinds[path]


def _may_run_python(path: str) -> bool:
    if os.path.basename(path).startswith('python'):
        return True
    if not os.access(path, os.X_OK):
        return path.endswith(_PYTHON_SUFFIX)
    try:
        with open(path, 'rb') as file:
            # a script in a shell may start one
            return file.read(len(_ELF)) != _ELF
    except OSError:
        return True


def _split(text: str) -> list[str]:
    try:
        return shlex.split(text)
    except ValueError:
        return text.split()
