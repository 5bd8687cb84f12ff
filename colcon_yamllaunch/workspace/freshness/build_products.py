# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The files that builds make in the build and install space.

Products are the files in the build folder that later steps of a build read,
or that installed files are made of or linked to. Files that tests, programs
and colcon write there, such as `Testing`, `test_results` and logs, are none.

After a workspace was copied or moved, CMake would still build the old folder
(it prints an error and colcon returns 0), and links would point to the old
files: :func:`former_place` tells of which place a build is.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
import os
from pathlib import Path
import re
import shutil
import stat
import sys

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.files import text_of
from colcon_yamllaunch.common.fingerprint import (
    digest,
    Fingerprint,
    with_content,
)
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.freshness.source_changes import (
    HEADER_SUFFIXES,
    INTERFACE_SUFFIXES,
    SOURCE_SUFFIXES,
    tree,
)
from colcon_yamllaunch.workspace.packages.package import entries_of, prefix_of

CACHE = 'CMakeCache.txt'
#: What CMake writes for the build tool.
CONFIGURED = {
    *(CACHE, 'cmake_install.cmake', 'Makefile', 'Makefile2', 'build.make'),
    *('flags.make', 'link.txt', 'build.ninja', 'rules.ninja'),
}
#: What compilers and linkers write, beside programs; not compiled, as each
#: launch imports this module and few need it.
_COMPILED = r'.+\.(?:o|obj|lo|a|so(?:\.[\d.]+)?|mod|gch|pch)'
_CODE = ('.py', *HEADER_SUFFIXES, *SOURCE_SUFFIXES, *INTERFACE_SUFFIXES)
#: Written by tests and programs, or by CMake while it tries things out.
_SKIPPED_FOLDERS = {
    *('Testing', 'test_results', '__pycache__', '.pytest_cache', '.cmake'),
    *('CMakeTmp', 'CMakeScratch', 'CompilerIdC', 'CompilerIdCXX'),
}
#: colcon writes these at each build.
_OF_COLCON = 'colcon_'
_METADATA = '.egg-info'
#: What a user or a CMakeLists.txt set; what CMake found out for itself may
#: differ between one run and the next.
_CACHE_ENTRY = rb'(?m)^(?!#|//)[^:\n]+:(?!INTERNAL|STATIC)[A-Z]+=.*$'


#: Where each package of a merged install space has files of its own.
_OWN_FOLDERS = ('share/{}', 'lib/{}', 'include/{}')
#: Lists of what was installed: those of CMake, of ament_cmake for links, and
#: of colcon for Python packages.
_CMAKE_MANIFESTS = ('install_manifest.txt', 'symlink_install_manifest.txt')
_MANIFESTS = (*_CMAKE_MANIFESTS, 'install.log')
#: colcon writes these whenever it builds a package (colcon-core,
#: colcon-cmake, colcon-package-selection).
ARGUMENTS = 'cmake_args.last'
_TRACES = (
    'colcon_command_prefix_build.sh',
    'colcon_command_prefix_setup_py.sh',
    ARGUMENTS,
    'colcon_build.rc',
)
_CACHE_FOLDER = re.compile(
    r'^(CMAKE_HOME_DIRECTORY|CMAKE_CACHEFILE_DIR):INTERNAL=(.*)$', re.M
)


@dataclass(frozen=True, slots=True)
class Comparison:
    """
    The difference between products then and now.

    :param missing: Products that are gone
    :param changed: Products with another content
    :param touched: Products with the same content and other times, with
      their fingerprints now
    """

    missing: tuple[str, ...]
    changed: tuple[str, ...]
    touched: dict[str, Fingerprint]


def state(path: Path, before: Fingerprint | None = None) -> Fingerprint | None:
    """
    Return the fingerprint of a file or link; None if it is gone.

    The content of a link is its target.

    :param before: An earlier fingerprint; the file is read only if it was
      written since
    """
    try:
        status = path.lstat()
        now = Fingerprint.of(status)
        if stat.S_ISLNK(status.st_mode):
            content = f'link to {path.readlink()}'
        elif path.name == CACHE:
            entries = re.findall(_CACHE_ENTRY, path.read_bytes())
            content = digest(b'\n'.join(entries))
        else:
            return with_content(path, now, before, limit=sys.maxsize)
    except OSError:
        return None
    mtime = now.mtime if now.is_settled else 0
    return now._replace(mtime=mtime, digest=content, inode=0)


def compare(base: Path, before: Mapping[str, Fingerprint]) -> Comparison:
    """
    Compare products with earlier fingerprints.

    :param base: The folder of the products
    :param before: The fingerprints, by the paths in that folder
    """
    missing, changed = [], []
    touched: dict[str, Fingerprint] = {}
    for name, then in before.items():
        try:
            status = os.lstat(f'{base}/{name}')
        except OSError:
            missing.append(name)
            continue
        if (
            status.st_mtime_ns == then.mtime
            and status.st_ctime_ns == then.ctime
            and status.st_size == then.size
        ):
            continue
        now = state(base / name)
        if now is None or not _is_same(then, now):
            changed.append(name)
        else:
            touched[name] = now
    return Comparison(tuple(missing), tuple(changed), touched)


def are_same(
    before: Mapping[str, Fingerprint], now: Mapping[str, Fingerprint]
) -> bool:
    """Return whether the same products have the same contents."""
    return before.keys() == now.keys() and all(
        _is_same(before[name], now[name]) for name in before
    )


def _is_same(before: Fingerprint, now: Fingerprint) -> bool:
    return (before.digest, before.executable) == (now.digest, now.executable)


def is_compiled(name: str, found: Fingerprint) -> bool:
    """Return whether the build tool makes a product again if it is missing."""
    file = os.path.basename(name)
    if re.fullmatch(_COMPILED, file):
        return True
    return found.executable and '.' not in file


def _products(
    folder: str, below: str, targets: Collection[str]
) -> Iterator[str]:
    for entry in entries_of(folder):
        name = below + entry.name
        if not entry.is_dir(follow_symlinks=False):
            if _is_product(entry, name, targets):
                yield name
        elif entry.name not in _SKIPPED_FOLDERS:
            yield from _products(entry.path, f'{name}/', targets)


def _is_product(
    entry: os.DirEntry[str], name: str, targets: Collection[str]
) -> bool:
    file = entry.name
    if file in CONFIGURED or name in targets or entry.is_symlink():
        return True
    if file.startswith(_OF_COLCON) or not entry.is_file():
        return False
    return (
        file.endswith(_CODE)
        or re.fullmatch(_COMPILED, file) is not None
        or f'{_METADATA}/' in name
        or bool(entry.stat().st_mode & stat.S_IXUSR)
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

    def installed(self, name: str, known: Iterable[str]) -> list[Path]:
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
        Return what each installed file is like, by its relative path.

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
        Return what the products in a package's build folder are like.

        :param installed: As :meth:`states` returns it
        :param known: What they were like before
        """
        start = f'link to {self.build(name)}/'
        targets = {
            found.digest.removeprefix(start)
            for found in installed.values()
            if found.digest.startswith(start)
        }
        build = self.build(name)
        found = {}
        for path in _products(str(build), '', targets):
            now = state(build / path, known.get(path))
            if now is not None:
                found[path] = now
        return found

    def listed(self, name: str, *, python: bool = False) -> set[Path]:
        """
        Return what the last installation of a package says it installed.

        CMake leaves out links that were there before.
        """
        manifests = _MANIFESTS if python else _CMAKE_MANIFESTS
        paths: set[Path] = set()
        for manifest in manifests:
            with suppress(OSError, UnicodeDecodeError):
                text = (self.build(name) / manifest).read_text('utf-8')
                # a name may have what else ends a line in Unicode
                paths.update(map(Path, text.split('\n')))
        own = {p for p in paths if p.is_relative_to(self.install_base)}
        return set(filter(os.path.lexists, own))

    def traces(self, name: str) -> dict[str, int]:
        """Return the times of files that colcon writes at each build."""
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

    def remove_links(
        self, name: str, known: Iterable[str]
    ) -> dict[Path, Path]:
        """
        Remove the links that a package installed, and return their targets.

        The next build makes those again that it still installs. The
        parameters are those of :meth:`installed`.
        """
        paths = self.installed(name, known)
        links = {path: path.readlink() for path in paths if path.is_symlink()}
        self.remove_files(links)
        return links

    def restore_links(self, links: Mapping[Path, Path]) -> None:
        """Restore links that :meth:`remove_links` removed."""
        for path, target in links.items():
            with suppress(OSError):
                path.parent.mkdir(parents=True, exist_ok=True)
                path.symlink_to(target)

    def remove_obsolete(self, name: str, before: Collection[Path]) -> None:
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


def former_place(source: Path, build: Path, recorded: Path) -> Path | None:
    """
    Return the folder that a build belongs to, if that is another one.

    That is the folder that it was built from, or in if only that one changed.

    :param source: The folder of the package
    :param build: Its folder in the build space
    :param recorded: The folder that its record names
    """
    cache = dict(_CACHE_FOLDER.findall(text_of(build / CACHE)))
    places = [
        (Path(cache.get('CMAKE_HOME_DIRECTORY', source)), source),
        (Path(cache.get('CMAKE_CACHEFILE_DIR', build)), build),
        (recorded, source),
    ]
    # colcon links the setup.py of a Python package into its build space
    with suppress(OSError):
        places.append(((build / 'setup.py').readlink().parent, source))
    for found, expected in places:
        if os.path.realpath(found) != os.path.realpath(expected):
            return found
    return None


def remove_builds(relocated: Mapping[str, Path], products: Products) -> None:
    """
    Remove the builds of packages, so that they are built from scratch.

    Only folders of these packages directly below `build/` and `install/` are
    removed. Links are removed, never followed. In a merged install space only
    links to the old place are removed, as builds would trip over them.

    :param relocated: Their names, with the folders that they were built from
    :raises WorkspaceError: when something cannot be removed
    """
    for name in relocated:
        for base in (products.build_base, products.install_base):
            path = base / name
            if path.parent != base or name in ('', '.', '..'):
                raise WorkspaceError(f"'{name}' is no name of a package")
            if base is products.build_base or not products.merge_install:
                remove_folder(path, ', which was built in another place')
    if products.merge_install:
        _remove_links(relocated, products.build_base, products.install_base)


def _remove_links(
    relocated: Mapping[str, Path], build_base: Path, install_base: Path
) -> None:
    for path in list(tree(install_base)):
        if not path.is_symlink():
            continue
        target = path.readlink()
        # the old build folder is not known of all types of packages
        if not target.is_relative_to(build_base) and any(
            target.is_relative_to(old)
            or f'/{build_base.name}/{name}/' in str(target)
            for name, old in relocated.items()
        ):
            path.unlink()
