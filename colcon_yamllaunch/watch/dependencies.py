# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The files that the processes and packages of a launch use, as data."""

from collections.abc import Iterable
from collections.abc import Mapping
from dataclasses import field
import os

from colcon_yamllaunch.common.frozen import dataclass

#: Where installers put files; nobody edits them.
_SYSTEM = tuple(
    f'/{name}/'
    for name in (
        *('bin', 'boot', 'dev', 'etc', 'lib', 'lib32', 'lib64', 'nix', 'opt'),
        *('proc', 'run', 'sbin', 'snap', 'sys', 'usr'),
    )
)


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
    :param libraries: The files that are mapped into the process, or were when
      it was last examined; None if it never was
    :param is_component: Whether it is a component
    :param machine: The machine that it runs on, empty for this computer
    """

    label: str
    program: str | None = None
    packages: frozenset[str] = frozenset()
    files: frozenset[str] = frozenset()
    may_run_python: bool = False
    libraries: frozenset[str] | None = None
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
    :param machines: The other machines that need it
    :param share: Its share folder in the install space, empty if there is none
    """

    name: str
    path: str
    live: frozenset[str] = frozenset()
    modules: frozenset[str] = frozenset()
    module_folders: frozenset[str] = frozenset()
    inputs: frozenset[str] = frozenset()
    machines: tuple[str, ...] = ()
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
    :param remote_files: The files that processes on other machines name, by
      their paths on this computer
    :param unsynced: See :class:`RemoteDependencies`
    """

    processes: tuple[ProcessDependencies, ...] = ()
    packages: tuple[PackageDependencies, ...] = ()
    plan_files: frozenset[str] = frozenset()
    reads_more: bool = False
    is_plan_broken: bool = False
    products: tuple[str, ...] = ()
    remote_files: frozenset[str] = frozenset()
    unsynced: Mapping[str, str] = field(default_factory=dict)

    def folders(self) -> tuple[str, ...]:
        """Return the folders to watch with everything below them."""
        return tuple(sorted({package.path for package in self.packages}))

    def files(self) -> tuple[str, ...]:
        """Return the other files to watch."""
        found = self.plan_files.union(
            self.remote_files,
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


def is_user_file(path: str, workspace: tuple[str, ...] = ()) -> bool:
    """
    Return whether users may edit `path`: installers did not put it there.

    :param workspace: Folders of the user, with a separator at the end; they
      may be below a system folder
    """
    return os.path.isabs(path) and (
        not path.startswith(_SYSTEM) or path.startswith(workspace)
    )
