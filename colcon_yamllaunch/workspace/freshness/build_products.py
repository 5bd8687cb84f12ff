# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What builds leave in the build and install space, package by package."""

from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Mapping
from contextlib import suppress
import os
from pathlib import Path
import shutil

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.workspace.freshness.product_states import built_files
from colcon_yamllaunch.workspace.freshness.product_states import state
from colcon_yamllaunch.workspace.freshness.source_links import tree
from colcon_yamllaunch.workspace.packages.package import prefix_of

#: Where each package of a merged install space has files of its own.
_OWN_FOLDERS = ('share/{}', 'lib/{}', 'include/{}')
#: Lists of what was installed: those of CMake, of ament_cmake for links, and
#: of colcon for Python packages.
_MANIFESTS = ('install_manifest.txt', 'symlink_install_manifest.txt')
_PYTHON_MANIFEST = 'install.log'
#: colcon writes these whenever it builds a package (colcon-core,
#: colcon-cmake, colcon-package-selection).
ARGUMENTS = 'cmake_args.last'
_TRACES = (
    'colcon_command_prefix_build.sh',
    'colcon_command_prefix_setup_py.sh',
    ARGUMENTS,
    'colcon_build.rc',
)


class Products:
    """The products of a workspace."""

    def __init__(
        self, build_base: Path, install_base: Path, merge_install: bool
    ) -> None:
        self.build_base = build_base
        self.install_base = install_base
        self.merge_install = merge_install

    def build(self, name: str) -> Path:
        """Return a package's folder in the build space."""
        return self.build_base / name

    def folders(self, name: str) -> list[Path]:
        """Return a package's own folders in the install space."""
        if not self.merge_install:
            return [self.install_base / name]
        own = [folder.format(name) for folder in _OWN_FOLDERS]
        return [self.install_base / folder for folder in own]

    def installed(self, name: str, known: Iterable[str] = ()) -> list[Path]:
        """
        Return the files and links that a package has installed.

        :param known: Those that it is known to have installed before, relative
          to the install space
        """
        found = {p for folder in self.folders(name) for p in tree(folder)}
        found |= self.listed(name, python=True)
        earlier = (self.install_base / relative for relative in known)
        found.update(filter(os.path.lexists, earlier))
        return sorted(p for p in found if p.suffix != '.pyc')

    def states(
        self, name: str, known: Mapping[str, Fingerprint]
    ) -> dict[str, Fingerprint]:
        """
        Tell what each installed file is like, by its relative path.

        :param known: What those were like that it is known to have installed
          before
        """
        found = {}
        for path in self.installed(name, known):
            relative = os.path.relpath(path, self.install_base)
            now = state(path, known.get(relative))
            if now is not None and os.path.exists(path):
                found[relative] = now
        return found

    def built(
        self,
        name: str,
        installed: Mapping[str, Fingerprint],
        known: Mapping[str, Fingerprint],
    ) -> dict[str, Fingerprint]:
        """
        Tell what the products in a package's build folder are like.

        :param installed: As :meth:`states` returns it
        :param known: What they were like before
        """
        start = f'link to {self.build(name)}/'
        targets = {
            found.digest.removeprefix(start)
            for found in installed.values()
            if found.digest.startswith(start)
        }
        return built_files(self.build(name), targets, known)

    def listed(self, name: str, *, python: bool = False) -> set[Path]:
        """
        Return what the last installation of a package says it installed.

        CMake leaves out links that were there before.
        """
        manifests = (*_MANIFESTS, _PYTHON_MANIFEST) if python else _MANIFESTS
        paths: set[Path] = set()
        for manifest in manifests:
            with suppress(OSError, UnicodeDecodeError):
                text = (self.build(name) / manifest).read_text('utf-8')
                # a name may have what else ends a line in Unicode
                paths.update(map(Path, text.split('\n')))
        own = {p for p in paths if p.is_relative_to(self.install_base)}
        return set(filter(os.path.lexists, own))

    def traces(self, name: str) -> dict[str, int]:
        """Return when colcon wrote what it leaves at each build."""
        prefix = prefix_of(name, self.install_base, self.merge_install)
        paths = [self.build(name) / trace for trace in _TRACES]
        paths.append(prefix / 'share' / name / 'package.sh')
        traces = {}
        for path in paths:
            with suppress(OSError):
                traces[str(path)] = path.stat().st_mtime_ns
        return traces

    def remove_installed(self, name: str, known: Iterable[str]) -> None:
        """
        Remove what a package installed.

        :param known: As for :meth:`installed`
        :raises WorkspaceError: when something cannot be removed
        """
        files = self.installed(name, known)
        for folder in self.folders(name):
            remove_folder(folder)
        self.remove_files(files)

    def remove_files(self, files: Iterable[Path]) -> None:
        """Remove files from the install space, and folders left empty."""
        for path in files:
            with suppress(OSError):
                path.unlink()
            with suppress(OSError):
                for folder in path.parents:
                    if not folder.is_relative_to(self.install_base):
                        break
                    folder.rmdir()

    def take_links(self, name: str, known: Iterable[str]) -> dict[Path, Path]:
        """
        Remove the links that a package installed, and return their targets.

        Those that are still to be there are made again by the next build. The
        parameters are those of :meth:`installed`.
        """
        paths = self.installed(name, known)
        links = {path: path.readlink() for path in paths if path.is_symlink()}
        self.remove_files(links)
        return links

    def put_back(self, links: Mapping[Path, Path]) -> None:
        """Make links again that :meth:`take_links` removed."""
        for path, target in links.items():
            with suppress(OSError):
                path.parent.mkdir(parents=True, exist_ok=True)
                path.symlink_to(target)

    def prune(self, name: str, before: Collection[Path]) -> None:
        """
        Remove files that a package installed before but does not any more.

        :param name: The package, which was just installed
        :param before: What :meth:`listed` returned before the build, which
          began without links
        """
        old = set(before) - self.listed(name)
        if not old:
            return
        if self.merge_install:
            for other in os.listdir(self.build_base):
                old -= self.listed(other)
        self.remove_files(old)


def remove_folder(path: Path, why: str = ' to build it from scratch') -> None:
    """
    Remove a folder, or the link to one; nothing if there is none.

    :param why: Why, as a part of a sentence
    :raises WorkspaceError: when it cannot be removed
    """
    try:
        if path.is_symlink():
            path.unlink()
        elif os.path.isdir(path):
            shutil.rmtree(path)
    except OSError as e:
        raise WorkspaceError(
            f'cannot remove {path}{why}: {e.strerror}',
            'remove it, then try again',
        ) from e
