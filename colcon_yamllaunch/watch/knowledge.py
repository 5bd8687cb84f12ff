# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launch uses, file by file: plain data."""

from collections.abc import Iterable
from collections.abc import Mapping
from dataclasses import field
import os

from colcon_yamllaunch.common.frozen import dataclass

#: Where installers put things; nobody edits them.
_SYSTEM = tuple(
    f'/{name}/'
    for name in (
        *('bin', 'boot', 'dev', 'etc', 'lib', 'lib32', 'lib64', 'nix', 'opt'),
        *('proc', 'run', 'sbin', 'snap', 'sys', 'usr'),
    )
)


@dataclass(frozen=True, slots=True)
class RunsThere:
    """
    What a launch runs on other machines.

    :param machines: The machine of each process and component, by label
    :param files: The files that each of these names, by the paths that they
      would have here
    :param packages: The packages of the workspace that each machine needs
    :param kept: The machines that are sent no code, and why
    """

    machines: Mapping[str, str] = field(default_factory=dict)
    files: Mapping[str, frozenset[str]] = field(default_factory=dict)
    packages: Mapping[str, frozenset[str]] = field(default_factory=dict)
    kept: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ProcessUse:
    """
    What a process or component of the launch uses.

    Its files on another machine begin with the name of that, as
    `arm│/ws/src/a.py`, and may differ from those here.

    :param label: Its label
    :param program: The file that it runs, behind all links; None when that is
      not known
    :param package: The package that it belongs to
    :param packages: The packages of the workspace whose code may be in it:
      its own, those of components in it, and what these need
    :param files: Other files that its plan names, behind all links
    :param may_run_python: Whether it is or may start a Python
    :param libraries: The files that are mapped into it, or were when it was
      looked at last; None if it never was
    :param is_component: Whether it is a component
    :param container: The label of the component's container, if the launch
      has that
    :param machine: The machine that it runs on, empty for here
    """

    label: str
    program: str | None = None
    package: str | None = None
    packages: frozenset[str] = frozenset()
    files: frozenset[str] = frozenset()
    may_run_python: bool = False
    libraries: frozenset[str] | None = None
    is_component: bool = False
    container: str | None = None
    machine: str = ''


@dataclass(frozen=True, slots=True)
class PackageUse:
    """
    A package of the workspace that the launch uses.

    All files below are relative to its source, but for `inputs`.

    :param path: The folder of its source, as colcon names it
    :param live: Those whose edits show without a build, as they are linked
    :param modules: Those of them that programs in Python import
    :param module_folders: Folders where a new file would be such a module
    :param inputs: Files elsewhere that its last build read
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
class Knowledge:
    """
    What a launch uses.

    :param processes: The processes and components, in the order of the launch
    :param packages: The packages of the workspace that it needs
    :param plan_files: The files that its plan was made from, behind all
      links: launch files, and what they read
    :param reads_more: Whether its plan was made with programs, which may have
      read other files, too
    :param is_plan_broken: Whether the launch file had mistakes when it was
      read last
    :param products: The folders of builds, in which nothing is watched
    :param files_there: The files that what runs on other machines names, by
      their paths here
    :param kept: See :class:`RunsThere`
    """

    processes: tuple[ProcessUse, ...] = ()
    packages: tuple[PackageUse, ...] = ()
    plan_files: frozenset[str] = frozenset()
    reads_more: bool = False
    is_plan_broken: bool = False
    products: tuple[str, ...] = ()
    files_there: frozenset[str] = frozenset()
    kept: Mapping[str, str] = field(default_factory=dict)

    def folders(self) -> tuple[str, ...]:
        """Return the folders to be watched, with all below them."""
        return tuple(sorted({package.path for package in self.packages}))

    def files(self) -> tuple[str, ...]:
        """Return the files to be watched besides."""
        found = {*self.plan_files, *self.files_there}
        products = tuple(folder + os.sep for folder in self.products)
        for process in self.processes:
            found |= process.files
            if process.program is not None:
                found.add(process.program)
        for package in self.packages:
            found |= package.inputs
        return tuple(
            sorted(
                path
                for path in found
                if is_edited(path) and not path.startswith(products)
            )
        )

    def labels(self, wanted: Iterable[str]) -> tuple[str, ...]:
        """Return labels in the order of the launch."""
        names = set(wanted)
        return tuple(p.label for p in self.processes if p.label in names)


def is_edited(path: str, own: tuple[str, ...] = ()) -> bool:
    """
    Tell whether a file may be edited, and does not come from installers.

    :param own: What the paths of the workspace begin with, wherever that is
    """
    return os.path.isabs(path) and (
        not path.startswith(_SYSTEM) or path.startswith(own)
    )
