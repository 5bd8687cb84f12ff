# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A workspace as far as it has been built and sourced, and its packages."""

from collections.abc import (
    Callable,
    Collection,
    Container,
    Iterable,
    Mapping,
    Sequence,
)
import os
from pathlib import Path
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.workspace.building.build_lock import (
    is_locked,
    WorkspaceLock,
)
from colcon_yamllaunch.workspace.environment.sourcing import Environment
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator
from colcon_yamllaunch.workspace.packages.workspace_root import Trust

if TYPE_CHECKING:
    from colcon_yamllaunch.workspace.colcon.colcon_cache import CachedColcon
    from colcon_yamllaunch.workspace.packages.package import BrokenManifest


# what reads and builds packages is imported where it is needed: there may be
# no workspace


class WorkspaceSession:
    """
    A workspace, or none: then there are only the underlays.

    :param root: The root of the workspace, or None
    :param build_arguments: Further arguments for `colcon build`
    :param announce: Is called with a line that the user should see at once
    :param title: The command, for other launches that wait for this one
    :param runs: Whether what is in the workspace may be run; who only looks
      reads what there is to read, also of the setup scripts
    :raises UntrustedError: when the workspace belongs to somebody else
    """

    def __init__(
        self,
        root: Path | None,
        build_arguments: Sequence[str],
        environment: Mapping[str, str],
        announce: Callable[[str], None],
        title: str = '',
        *,
        runs: bool = True,
    ) -> None:
        self.root = root
        self._runs = runs
        #: What keeps others from building in the workspace meanwhile.
        self.lock = WorkspaceLock(title)
        self.announce = announce
        self._user_environment = environment
        self._sourced = Environment(environment)
        self._packages: dict[str, Package] = {}
        self._colcon: CachedColcon | None = None
        if root is not None:
            from colcon_yamllaunch.workspace.colcon import colcon_cache

            self._colcon = colcon = colcon_cache.CachedColcon(
                root, build_arguments, runs=runs
            )
            # the arguments may name other folders than the usual ones
            Trust(environment).check(
                colcon.root, colcon.build_base, colcon.install_base
            )
            self._packages = {p.name: p for p in colcon.packages()}
            if os.path.isfile(colcon.install_base / 'setup.bash'):
                self._source_existing()
        self._make_locator()

    @property
    def colcon(self) -> 'CachedColcon':
        """What knows and builds the packages; there must be a workspace."""
        assert self._colcon is not None
        return self._colcon

    @property
    def environment(self) -> Mapping[str, str]:
        """The user's environment with the workspace sourced."""
        return self._sourced.variables

    @property
    def package_names(self) -> set[str]:
        """The names of the packages of the workspace."""
        return set(self._packages)

    @property
    def packages(self) -> Collection[Package]:
        """The packages of the workspace."""
        return self._packages.values()

    def broken_manifests(self) -> 'tuple[BrokenManifest, ...]':
        """Return the manifests in the workspace that make no package."""
        if self._colcon is None:
            return ()
        from colcon_yamllaunch.workspace.packages import package

        return package.broken_manifests(
            self._colcon.base_paths(), self._packages.values()
        )

    def select(self, paths: Iterable[str], cwd: Path) -> tuple[str, ...]:
        """
        Return the names of the packages at paths.

        :raises WorkspaceError: when there is none at a path
        """
        if self._colcon is None:
            raise WorkspaceError('there is no workspace to build in')
        names = self._colcon.select(paths, cwd)
        self._packages = {p.name: p for p in self._colcon.packages()}
        self._make_locator()
        return names

    def needed_by(self, wanted: Iterable[str]) -> dict[str, tuple[str, ...]]:
        """Return by which dependencies each package is needed."""
        from colcon_yamllaunch.workspace.packages.package import needed_by

        return needed_by(self._packages.values(), wanted)

    def build_environment(self) -> Environment:
        """
        Return what packages are built in.

        :raises WorkspaceError: when an underlay's script fails
        """
        from colcon_yamllaunch.workspace.environment import sourcing

        source: Callable[[Path, Mapping[str, str]], Environment]
        source = sourcing.source
        if not self._runs:
            # most launches run
            from colcon_yamllaunch.workspace.environment import hooks

            source = hooks.described_environment
        build = sourcing.build_environment(
            self._user_environment, self.colcon.install_base, source
        )
        known = self._sourced.notes
        return Environment(
            # what colcon sets for the programs that it calls
            {'COLCON': '1', **build.variables},
            notes=tuple(n for n in build.notes if n not in known),
        )

    def source(self) -> None:
        """
        Source what has been built.

        :raises WorkspaceError: when the setup script fails
        """
        self._source()
        self._make_locator()

    def check_sourced(self, names: Sequence[str], *, may_build: bool) -> None:
        """
        Check that packages arrived in the environment.

        :param names: Packages of the workspace
        :param may_build: Whether the launch was allowed to build
        :raises WorkspaceError: when one did not
        """
        if self._colcon is None:
            return
        colcon = self._colcon
        for name in names:
            prefix = self.locator.prefix(name) or ''
            if not os.path.isfile(Path(prefix, 'share', name, 'package.sh')):
                cure = 'leave out --no-build, or build it'
                if may_build:
                    cure = 'its path is not among --paths'
                raise WorkspaceError(f'the package {name} is not built', cure)
        if self._sourced.packages.issuperset(names):
            return
        # most launches need not look for them
        from colcon_yamllaunch.workspace.environment import hooks

        missing = hooks.missing_packages(
            self._sourced, names, colcon.install_base, colcon.merge_install
        )
        for reason in missing.values():
            raise WorkspaceError(reason)

    @property
    def guessed(self) -> Mapping[str, Path]:
        """The packages whose names are guessed, with their `setup.py`."""
        return {} if self._colcon is None else self._colcon.guessed

    @property
    def setup_script(self) -> str | None:
        """The script that sources it, whether it is there yet or not."""
        if self._colcon is None:
            return None
        return str(self._colcon.install_base / 'setup.bash')

    def _source_existing(self) -> None:
        base = self.colcon.build_base
        self.lock.look(base)
        try:
            self._source()
        except WorkspaceError:
            if not is_locked(base):
                raise
            # it is being built; when that is done, it is sourced again
            with WorkspaceLock() as lock:
                lock.acquire(base, self.announce)
                self._source()

    def _source(self) -> None:
        from colcon_yamllaunch.workspace.environment import environment_cache

        find = environment_cache.known_environment
        if self._runs:
            find = environment_cache.cached_environment
        colcon = self.colcon
        self._sourced = find(
            colcon.install_base / 'setup.bash',
            self._user_environment,
            colcon.build_base,
        )
        for note in self._sourced.notes:
            self.announce(note)

    def _make_locator(self) -> None:
        colcon = self._colcon
        self.locator = PackageLocator(
            self._packages.values(),
            Path() if colcon is None else colcon.install_base,
            colcon is not None and colcon.merge_install,
            self.environment,
        )

    def refuse_invalid_manifests(self, names: Collection[str]) -> None:
        """
        Refuse packages whose manifests colcon passes over.

        :raises WorkspaceError: when one of them is such a package
        """
        from colcon_yamllaunch.workspace.packages import package

        for name in sorted(self.package_names.intersection(names)):
            reason = package.invalid_manifest(self._packages[name])
            if reason is not None:
                raise WorkspaceError(reason)


# what explains mistakes is imported where it is needed


class LaunchPackages:
    """
    The packages of a workspace and its underlays.

    :param built: Whether all that was to be built has been built
    :param remote_only: Packages that are not built here, as only what runs on
      other machines needs them
    """

    def __init__(
        self,
        locator: PackageLocator,
        *,
        built: bool,
        remote_only: Container[str] = (),
    ) -> None:
        self._locator = locator
        self._built = built
        self._remote_only = remote_only
        self.prefix = locator.prefix
        self.names = locator.names
        self.executable = locator.executable
        #: The paths that are not there, but taken for granted before a build.
        self.expected: set[str] = set()
        #: The launch files that were found in a source only, in order.
        self.not_installed: dict[str, None] = {}

    def own_names(self) -> Iterable[str]:
        """Return the names of the packages of the workspace."""
        return [package.name for package in self._locator.packages()]

    def explain_executable(self, package: str, name: str) -> str:
        """Return why a package has no such program, and the fix."""
        from colcon_yamllaunch.workspace.packages import missing_files

        found = missing_files.missing_executable(self._locator, package, name)
        return str(found or '')

    def locate(self, path: str) -> tuple[str, str] | None:
        """
        Find a launch file, in the source of a package of the workspace.

        It goes by the path that it has, or will have, in the install space,
        unless a build has shown that it is not installed.
        """
        if self._locator.shared(path) is not None:
            source = self._locator.source_of(path)
            if source is not None and os.path.isfile(Path(source)):
                if os.path.exists(Path(path)) or self.may_appear(path):
                    return path, source
                self.not_installed[path] = None
                return source, source
        return (path, path) if os.path.isfile(Path(path)) else None

    def may_appear(self, path: str) -> bool:
        """
        Return whether a build may create a missing path.

        Such a path is remembered as expected.
        """
        owner = self._locator.owner(path)
        if owner is None:
            return False
        if owner.name in self._remote_only:
            return True
        if self._built:
            return False
        self.expected.add(path)
        return True

    def rule_for(self, path: str) -> str | None:
        """Return how to install a file that only the source has, or None."""
        from colcon_yamllaunch.workspace.packages import missing_files

        found = missing_files.not_installed(self._locator, path)
        return None if found is None else found.hint

    def similar(self, path: str) -> Iterable[str]:
        """Return the names of files in its folder that could be meant."""
        from colcon_yamllaunch.workspace.packages import launch_files

        shared = self._locator.shared(path)
        if shared is not None:
            package, file = shared
            files = map(Path, launch_files.find_launch_files(package.path))
            return [f.name for f in files if f.parent == file.parent]
        try:
            return os.listdir(os.path.dirname(path))
        except OSError:
            return ()
