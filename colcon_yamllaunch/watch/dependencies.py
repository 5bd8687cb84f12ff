# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The files that the processes and packages of a launch use.

They are found in the plan, the programs, the memory maps of processes, and the
records of builds. The record of a package's last successful build lists which
source files stand for installed files. Nothing is started to find them.
"""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import field, replace
from functools import cache, lru_cache
import os
from pathlib import Path
import re
import shlex
import shutil

from colcon_yamllaunch.common.files import is_user_file
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.plan.labels import MACHINE_SEPARATOR
from colcon_yamllaunch.plan.plan import (
    Component,
    ParameterFile,
    Plan,
    Process,
    SetParameter,
)
from colcon_yamllaunch.workspace.colcon.colcon_cache import CachedColcon
from colcon_yamllaunch.workspace.freshness.build_record import (
    DamagedRecordError,
    read_record,
    Record,
    RECORD_NAME,
)
from colcon_yamllaunch.workspace.packages.package import closure, Package
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator

#: The products of packages: what identifies the content of each built and
#: installed file, by its path behind all links.
Products = Mapping[str, Mapping[str, str]]

_PYTHON_SUFFIX = '.py'
_LINK = 'link to '
#: The size of the cache; no workspace has so many packages.
_RECORDS = 10_000
_ELF = b'\x7fELF'
_LONGEST_PATH = 4096
_SHELLS = frozenset(('bash', 'dash', 'sh', 'zsh'))
_ROS = 'ros2'
_DELETED = ' (deleted)'


@dataclass(frozen=True, slots=True)
class RemoteDependencies:
    """
    What the parts of a launch on other machines use.

    :param machines: The machine of each process and component, by label
    :param files: The files that each of these names, by the paths that they
      would have on this computer
    :param packages: The packages of the workspace that each machine needs
    :param unsynced: The machines that receive no code, each with the reason
    """

    machines: Mapping[str, str] = field(default_factory=dict)
    files: Mapping[str, frozenset[str]] = field(default_factory=dict)
    packages: Mapping[str, frozenset[str]] = field(default_factory=dict)
    unsynced: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ProcessDependencies:
    """
    What a process or component of the launch uses.

    Its files on another machine begin with the name of that machine, as
    `arm│/ws/src/a.py`, and may differ from those on this computer.

    :param label: Its label
    :param program: The file that it runs, behind all links; None if unknown
    :param packages: The packages of the workspace whose code may be in it:
      its own, those of components in it, and their dependencies
    :param files: Other files that its plan names, behind all links
    :param may_run_python: Whether it is or may start a Python interpreter
    :param is_component: Whether it is a component
    :param machine: The machine that it runs on, empty for this computer
    """

    label: str
    program: str | None = None
    packages: frozenset[str] = frozenset()
    files: frozenset[str] = frozenset()
    may_run_python: bool = False
    is_component: bool = False
    machine: str = ''


@dataclass(frozen=True, slots=True)
class PackageDependencies:
    """
    A package of the workspace that the launch uses.

    All files below are relative to its source, except `inputs`.

    :param path: The folder of its source, as colcon names it
    :param live: Files that the install space links to, so that their edits
      need no build
    :param modules: The live files that Python programs import
    :param module_folders: Folders where a new file would be such a module
    :param inputs: Files outside its source that its last build read
    :param share: Its share folder in the install space, empty if there is none
    """

    name: str
    path: str
    live: frozenset[str] = frozenset()
    modules: frozenset[str] = frozenset()
    module_folders: frozenset[str] = frozenset()
    inputs: frozenset[str] = frozenset()
    share: str = ''


@dataclass(frozen=True, slots=True)
class Dependencies:
    """
    What a launch uses.

    :param processes: The processes and components, in the order of the launch
    :param packages: The packages of the workspace that it needs
    :param plan_files: The files that its plan was made from, behind all
      links: launch files, and the files that these read
    :param reads_more: Whether evaluating the plan ran programs, which may
      have read other files, too
    :param is_plan_broken: Whether the launch file had errors when it was last
      evaluated
    :param products: The build and install folders, which are not watched
    :param remote: What its parts on other machines use
    """

    processes: tuple[ProcessDependencies, ...] = ()
    packages: tuple[PackageDependencies, ...] = ()
    plan_files: frozenset[str] = frozenset()
    reads_more: bool = False
    is_plan_broken: bool = False
    products: tuple[str, ...] = ()
    remote: RemoteDependencies = field(default_factory=RemoteDependencies)

    def folders(self) -> tuple[str, ...]:
        """Return the folders to watch with everything below them."""
        return tuple(sorted({package.path for package in self.packages}))

    def files(self) -> tuple[str, ...]:
        """Return the other files to watch."""
        found = self.plan_files.union(
            *self.remote.files.values(),
            *(process.files for process in self.processes),
            *(package.inputs for package in self.packages),
            (p.program for p in self.processes if p.program is not None),
        )
        products = tuple(folder + os.sep for folder in self.products)
        return tuple(
            sorted(
                path
                for path in found
                if is_user_file(path) and not path.startswith(products)
            )
        )

    def labels(self, wanted: Iterable[str]) -> tuple[str, ...]:
        """Return the labels among `wanted`, in the order of the launch."""
        names = set(wanted)
        return tuple(p.label for p in self.processes if p.label in names)


def find_dependencies(
    plan: Plan,
    evaluation: Evaluation,
    colcon: CachedColcon | None,
    locator: PackageLocator,
    wanted: Iterable[str],
    environment: Mapping[str, str],
    remote: RemoteDependencies | None = None,
) -> Dependencies:
    """
    Return what a launch uses.

    :param plan: Its plan, with the labels that are in use
    :param evaluation: The evaluation that made the plan
    :param colcon: The colcon of the workspace, None without a workspace
    :param locator: Finds the packages of the workspace
    :param wanted: The packages of the workspace that it names
    :param environment: The environment of the processes
    :param remote: The dependencies of parts on other machines
    """
    remote = remote or RemoteDependencies()
    packages: list[Package] = []
    products: set[str] = set()
    used: list[PackageDependencies] = []
    if colcon is not None:
        for base in (colcon.build_base, colcon.install_base):
            products |= {str(base), os.path.realpath(base)}
        by_name = {p.name: p for p in locator.packages()}
        needed = frozenset(wanted).union(*remote.packages.values())
        packages = [by_name[n] for n in closure(by_name.values(), needed)]
        for package in packages:
            share = locator.share(package.name) or ''
            used.append(_package(colcon, package, share))
    finder = _ProcessFinder(plan, packages, environment, colcon, remote)
    read = [*(file.path for file in evaluation.files), *evaluation.inputs]
    return Dependencies(
        tuple(finder.find()),
        tuple(used),
        frozenset(map(os.path.realpath, read)),
        reads_more=evaluation.has_run_programs,
        is_plan_broken=bool(evaluation.errors),
        products=tuple(sorted(products)),
        remote=remote,
    )


def build_products(colcon: CachedColcon, names: Iterable[str]) -> Products:
    """Return the products of the last successful builds of packages."""
    found: dict[str, dict[str, str]] = {}
    for name in names:
        products = found[name] = {}
        if (record := _record(colcon, name)) is None:
            continue
        for folder, files in (
            (colcon.install_base, record.installed),
            (colcon.build_base / name, record.products),
        ):
            real = os.path.realpath(folder)
            for path, file in files.items():
                text = f'{file.digest} {file.executable:d}'
                products[f'{real}{os.sep}{path}'] = text
    return found


def _record(colcon: CachedColcon, name: str) -> Record | None:
    """Return the record of the last build of a package, if there is one."""
    path = f'{colcon.build_base}{os.sep}{name}{os.sep}{RECORD_NAME}'
    try:
        status = os.stat(path)
    except OSError:
        return None
    return _read_record(path, status.st_mtime_ns, status.st_ino)


@lru_cache(_RECORDS)
def _read_record(path: str, _time: int, _inode: int) -> Record | None:
    try:
        return read_record(Path(path))
    except DamagedRecordError:
        return None


def _package(
    colcon: CachedColcon, package: Package, share: str
) -> PackageDependencies:
    """Return what is used of a package, as of its last build."""
    name, path = package.name, str(package.path)
    record = _record(colcon, name)
    if record is None:
        return PackageDependencies(name, path, share=share)
    modules = frozenset(_modules(package, record, colcon.build_base / name))
    return PackageDependencies(
        name,
        path,
        record.live,
        modules,
        frozenset(map(os.path.dirname, modules)),
        frozenset(filter(os.path.isabs, record.files)),
        share,
    )


def _modules(package: Package, record: Record, build: Path) -> Iterator[str]:
    """
    Iterate over the files that programs in Python import.

    :param build: The package's folder in the build space, where those of
      packages in Python are linked, too
    """
    folder = package.path
    candidates = [r for r in record.live if r.endswith(_PYTHON_SUFFIX)]
    if not candidates:
        return
    data, programs = set(), set()
    for start in {str(folder), os.path.realpath(folder), str(build)}:
        link = f'{_LINK}{start}{os.sep}'
        for installed, found in record.installed.items():
            if not found.digest.startswith(link):
                continue
            parts = installed.split(os.sep)
            target = found.digest[len(link) :].rstrip(os.sep)
            if 'share' in parts:
                data.add(target)
            elif parts[-3:-1] == ['lib', package.name]:
                programs.add(target)
    imported = _imported(folder, programs)
    for relative in candidates:
        above = relative
        while above and above not in data:
            above = os.path.dirname(above)
        if not above and (
            relative not in programs
            or Path(relative).stem in imported
            or not os.access(folder / relative, os.X_OK)
        ):
            yield relative


def _imported(folder: Path, programs: Iterable[str]) -> set[str]:
    """Return the modules that programs import, up to the first dot."""
    found: set[str] = set()
    for program in programs:
        try:
            text = (folder / program).read_text('utf-8')
        except (OSError, UnicodeDecodeError):
            continue
        found.update(re.findall(r'(?m)^\s*(?:from|import)\s+(\w+)', text))
    return found


class _ProcessFinder:
    """
    Finds what the processes and components of a plan use.

    :param packages: Those of the workspace that the launch needs
    :param environment: The environment of the processes
    :param colcon: The colcon of the workspace, None without a workspace
    :param remote: The dependencies of parts on other machines
    """

    def __init__(
        self,
        plan: Plan,
        packages: list[Package],
        environment: Mapping[str, str],
        colcon: CachedColcon | None,
        remote: RemoteDependencies,
    ) -> None:
        self._plan = plan
        self._names = frozenset(package.name for package in packages)
        self._environment = environment
        # the install base, and folders that may have files of the user, all
        # with a separator at their end
        self._install = os.sep
        self._folders: tuple[str, ...] = ()
        if colcon is not None:
            self._install = f'{colcon.install_base}{os.sep}'
            folders = (colcon.root, *(package.path for package in packages))
            real = map(os.path.realpath, folders)
            self._folders = tuple(f'{folder}{os.sep}' for folder in real)
        self._remote = remote
        # most processes share files and packages
        self._closure = cache(
            lambda names: frozenset(closure(packages, names))
        )
        self._named_file = cache(self._find_named_file)
        self._may_run_python = cache(_may_run_python)

    def find(self) -> Iterator[ProcessDependencies]:
        """Iterate over the dependencies, in the order of the launch."""
        components = tuple(self._plan.components())
        for process in self._plan.processes():
            name = process.node_name or ''
            inside = {c.package for c in components if c.container == name}
            yield self._placed(self._of_process(process, inside))
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
            machine=machine,
        )

    def _of_process(
        self, process: Process, packages: set[str]
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
        packages |= {*map(self._owner, words), *self._commanded(words)}
        packages |= {process.package or ''}
        return ProcessDependencies(
            process.label,
            program,
            self._closure(frozenset(packages - {''})),
            named - {program},
            program is None
            or self._may_run_python(program)
            or any(map(self._may_run_python, named)),
        )

    def _of_component(self, component: Component) -> ProcessDependencies:
        parameters = (*component.parameters, *component.extra_arguments)
        return ProcessDependencies(
            component.label,
            packages=self._closure(frozenset((component.package,))),
            files=self._named(_values(parameters), ''),
            is_component=True,
        )

    def _owner(self, word: str) -> str:
        """Return the package of the workspace that has a program, or ''."""
        if word.startswith(self._install):
            # merged or not, programs are in lib/PACKAGE
            _, _, inside = word[len(self._install) - 1 :].partition('/lib/')
            name, separator, _ = inside.partition(os.sep)
            if separator and name in self._names:
                return name
        return ''

    def _commanded(self, words: Iterable[str]) -> frozenset[str]:
        """Return the packages whose programs a `ros2` command starts."""
        names = {os.path.basename(word) for word in words}
        if _ROS not in names:
            return frozenset()
        # `ros2 launch` may start the programs of any package
        return self._names if 'launch' in names else self._names & names

    def _program(self, process: Process, word: str) -> str | None:
        if os.sep not in word:
            changed = dict(process.environment)
            path = changed.get('PATH', self._environment.get('PATH'))
            found = shutil.which(word, path=path)
            if found is None:
                return None
            word = found
        return os.path.realpath(os.path.join(process.cwd, word))

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
        real = os.path.realpath(path)
        if not is_user_file(real, self._folders):
            return None
        if os.path.isfile(real):
            return real
        # a file that may be created
        is_likely = '.' in os.path.basename(real) and not os.path.exists(real)
        is_likely = is_likely and os.path.isdir(os.path.dirname(real))
        return real if is_likely else None


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
    for current in (pid, *_descendants(pid)):
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
    return frozenset(found) if is_known else None


def _descendants(pid: int) -> Iterator[int]:
    # not every kernel has these files
    for file in Path(f'/proc/{pid}/task').glob('*/children'):
        with suppress(OSError):
            for child in map(int, file.read_text().split()):
                yield child
                yield from _descendants(child)


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
