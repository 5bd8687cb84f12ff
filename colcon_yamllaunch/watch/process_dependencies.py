# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What each process uses, according to its plan entry, program and memory maps.

That is the program, the files that its arguments, variables and parameters
name, the packages whose code it may run, and its shared libraries. Nothing is
started to find them.
"""

from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
import os
import shlex
import shutil

from colcon_yamllaunch.plan.labels import MACHINE_SEPARATOR
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import ParameterFile
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.plan import SetParameter
from colcon_yamllaunch.watch.dependencies import Dependencies
from colcon_yamllaunch.watch.dependencies import is_user_file
from colcon_yamllaunch.watch.dependencies import ProcessDependencies
from colcon_yamllaunch.watch.dependencies import RemoteDependencies
from colcon_yamllaunch.workspace.packages.closure import closure
from colcon_yamllaunch.workspace.packages.package import Package

_PYTHON_SUFFIX = '.py'
_ELF = b'\x7fELF'
_LONGEST_PATH = 4096
_SHELLS = frozenset(('bash', 'dash', 'sh', 'zsh'))
_ROS = 'ros2'
_DELETED = ' (deleted)'


class ProcessFinder:
    """
    Finds what the processes and components of a plan use.

    :param packages: Those of the workspace that the launch needs
    :param libraries: The files mapped into processes, as far as known
    :param environment: The environment of the processes
    :param install: The install base, with a separator at its end
    :param folders: The folders that may have files of the user, each so
    :param remote: The dependencies of parts on other machines
    """

    def __init__(
        self,
        plan: Plan,
        packages: Collection[Package],
        libraries: Mapping[str, frozenset[str] | None],
        environment: Mapping[str, str],
        install: str,
        folders: tuple[str, ...],
        remote: RemoteDependencies,
    ) -> None:
        self._plan = plan
        self._names = frozenset(package.name for package in packages)
        self._libraries = libraries
        self._environment = environment
        self._install = install
        self._folders = folders
        self._remote = remote
        # most processes share folders, files and packages
        self._closure = cache(
            lambda names: frozenset(closure(packages, names))
        )
        self._real_folder = cache(os.path.realpath)
        self._named_file = cache(self._find_named_file)
        self._may_run_python = cache(_may_run_python)

    def find(self) -> Iterator[ProcessDependencies]:
        """Iterate over the dependencies, in the order of the launch."""
        components = tuple(self._plan.components())
        inside: dict[str, set[str]] = {}
        for component in components:
            names = inside.setdefault(component.container, set())
            names.add(component.package)
        for process in self._plan.processes():
            loaded = inside.get(process.node_name or '', ())
            yield self._placed(self._of_process(process, loaded))
        for component in components:
            yield self._placed(self._of_component(component))

    def _placed(self, found: ProcessDependencies) -> ProcessDependencies:
        """Return what a process uses on the machine that it runs on."""
        machine = self._remote.machines.get(found.label)
        if machine is None:
            return found
        # links on this computer say nothing about files of the machine
        return replace(
            found,
            program=None,
            files=frozenset(
                f'{machine}{MACHINE_SEPARATOR}{path}'
                for path in self._remote.files[found.label]
            ),
            may_run_python=found.may_run_python
            or not os.path.exists(found.program or ''),
            libraries=None,
            machine=machine,
        )

    def _of_process(
        self, process: Process, loaded: Iterable[str]
    ) -> ProcessDependencies:
        words = [w for w in process.argv if isinstance(w, str)]
        if words and os.path.basename(words[0]) in _SHELLS:
            # a shell command
            words += [part for word in words[1:] for part in _split(word)]
        program = self._program(process, words[0]) if words else None
        parameters = [*process.parameters]
        for word in process.argv:
            if isinstance(word, ParameterFile):
                parameters += word.parameters
        values = [v for _, v in process.environment if v is not None]
        named = self._named(
            (*words[1:], *_values(parameters), *values), process.cwd
        )
        owners = [o for o in map(self._owner, words) if o is not None]
        packages = {*loaded, *self._commanded(words), *owners}
        if process.package is not None:
            packages.add(process.package)
        return ProcessDependencies(
            process.label,
            program,
            self._closure(frozenset(packages)),
            named - {program},
            program is None
            or self._may_run_python(program)
            or any(map(self._may_run_python, named)),
            self._libraries.get(process.label),
        )

    def _of_component(self, component: Component) -> ProcessDependencies:
        parameters = (*component.parameters, *component.extra_arguments)
        return ProcessDependencies(
            component.label,
            packages=self._closure(frozenset((component.package,))),
            files=self._named(_values(parameters), ''),
            is_component=True,
        )

    def _owner(self, word: str) -> str | None:
        """Return the package of the workspace that has a program."""
        if not word.startswith(self._install):
            return None
        parts = word[len(self._install) :].split(os.sep)
        # merged or not, programs are in lib/PACKAGE
        if 'lib' in parts[:-2]:
            name = parts[parts.index('lib') + 1]
            if name in self._names:
                return name
        return None

    def _commanded(self, words: Iterable[str]) -> frozenset[str]:
        """Return the packages whose programs a `ros2` command starts."""
        names = {os.path.basename(word) for word in words}
        if _ROS not in names:
            return frozenset()
        # `ros2 launch` may start any of them
        return self._names if 'launch' in names else self._names & names

    def _program(self, process: Process, word: str) -> str | None:
        if os.sep not in word:
            changed = dict(process.environment)
            path = changed.get('PATH', self._environment.get('PATH'))
            found = shutil.which(word, path=path)
            if found is None:
                return None
            word = found
        return self._real(os.path.join(process.cwd, word))

    def _named(self, words: Iterable[str], cwd: str) -> frozenset[str]:
        """Return the files that words name, behind all links."""
        found = {
            self._named_file(os.path.join(cwd, part))
            for word in words
            # as `--file=PATH`, `file:=PATH`
            for part in (word, word.rpartition('=')[2])
            if os.sep in part
        }
        return frozenset(path for path in found if path is not None)

    def _find_named_file(self, path: str) -> str | None:
        """Return the file that a path names, if a user may edit it."""
        if len(path) > _LONGEST_PATH or not path.isprintable():
            return None
        real = self._real(path)
        if not is_user_file(real, self._folders):
            return None
        if os.path.isfile(real):
            return real
        # a file that may be created
        is_likely = '.' in os.path.basename(real) and not os.path.exists(real)
        is_likely = is_likely and os.path.isdir(os.path.dirname(real))
        return real if is_likely else None

    def _real(self, path: str) -> str:
        """Return what is behind all links; most files are in few folders."""
        folder, base = os.path.split(os.path.normpath(path))
        path = os.path.join(self._real_folder(folder), base)
        return os.path.realpath(path) if os.path.islink(path) else path


def with_libraries(
    dependencies: Dependencies, processes: Mapping[str, int]
) -> Dependencies:
    """
    Return `dependencies` with the files that are mapped into processes now.

    A process that has ended keeps its files.

    :param processes: The process IDs of those that run, by label
    """
    folders = tuple(folder + os.sep for folder in dependencies.products)
    found = []
    for process in dependencies.processes:
        pid = processes.get(process.label)
        mapped = mapped_files(pid, folders) if pid else None
        if mapped is not None:
            process = replace(
                process,
                libraries=mapped,
                may_run_python=process.may_run_python
                or any('/libpython' in path for path in mapped),
            )
        found.append(process)
    return replace(dependencies, processes=tuple(found))


def mapped_files(
    pid: int, folders: tuple[str, ...] = ()
) -> frozenset[str] | None:
    """
    Return the user's files that are mapped into a process and its children.

    A file that was replaced since is returned with its former name. None is
    returned for a process that has ended, or of another user.

    :param pid: The process; one that was started with a prefix or in a shell
      maps nothing itself, so its children count
    :param folders: The folders of the user, with a separator at the end
    """
    found: set[str] = set()
    is_known = False
    pending = [pid]
    while pending:
        current = pending.pop()
        try:
            # fields are separated by spaces, and the path comes last
            with open(f'/proc/{current}/maps', errors='surrogateescape') as f:
                lines = f.readlines()
        except OSError:
            continue
        is_known = is_known or bool(lines)
        for line in lines:
            path = line[line.find('/') :].rstrip('\n') if '/' in line else ''
            path = path.removesuffix(_DELETED)
            if is_user_file(path, folders):
                found.add(path)
        pending += _children(current)
    return frozenset(found) if is_known else None


def _children(pid: int) -> list[int]:
    found: list[int] = []
    try:
        for thread in os.listdir(f'/proc/{pid}/task'):
            with open(f'/proc/{pid}/task/{thread}/children') as file:
                found += map(int, file.read().split())
    except OSError:
        # not every kernel has these files
        pass
    return found


def _may_run_python(path: str) -> bool:
    if os.path.basename(path).startswith('python'):
        return True
    if not os.access(path, os.X_OK):
        return path.endswith(_PYTHON_SUFFIX)
    try:
        with open(path, 'rb') as file:
            # a shell script may start one
            return file.read(len(_ELF)) != _ELF
    except OSError:
        return True


def _values(parameters: Iterable[SetParameter]) -> Iterator[str]:
    return (p.value.strip('"\'') for p in parameters)


def _split(text: str) -> list[str]:
    try:
        return shlex.split(text)
    except ValueError:
        return text.split()
