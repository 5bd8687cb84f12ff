# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The workspace of a launch, as far as it has been built and sourced."""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.verb.launching.interruption import interruption
from colcon_yamllaunch.workspace.building.update import bring_up_to_date
from colcon_yamllaunch.workspace.building.update import decide
from colcon_yamllaunch.workspace.building.update import Update
from colcon_yamllaunch.workspace.environment.environment_cache import (
    remembered,
)
from colcon_yamllaunch.workspace.environment.sourcing import Environment
from colcon_yamllaunch.workspace.environment.underlays import build_environment
from colcon_yamllaunch.workspace.environment.underlays import BuildEnvironment
from colcon_yamllaunch.workspace.freshness.build_decision import Decision
from colcon_yamllaunch.workspace.index.colcon_cache import RememberedColcon
from colcon_yamllaunch.workspace.packages.closure import needed_by
from colcon_yamllaunch.workspace.packages.manifest import broken_manifests
from colcon_yamllaunch.workspace.packages.manifest import BrokenManifest
from colcon_yamllaunch.workspace.packages.manifest import invalid_manifest
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator


class InstalledWorkspace:
    """
    A workspace, or none: then there are only the underlays.

    :param root: The root of the workspace, or None
    :param build_arguments: Further arguments for `colcon build`
    :param environment: The user's environment
    :param announce: Is called with a line that the user should see at once
    """

    def __init__(
        self,
        root: Path | None,
        build_arguments: Sequence[str],
        environment: Mapping[str, str],
        announce: Callable[[str], None],
    ) -> None:
        self.root = root
        self._announce = announce
        self._user_environment = environment
        self._sourced = Environment(environment)
        self._packages: dict[str, Package] = {}
        self._colcon: RememberedColcon | None = None
        if root is not None:
            self._colcon = RememberedColcon(root, build_arguments)
            self._find_packages()
            if self._setup.is_file():
                self._source()
        self._make_locator()

    @property
    def environment(self) -> Mapping[str, str]:
        """The user's environment with the workspace sourced."""
        return self._sourced.variables

    @property
    def package_names(self) -> set[str]:
        """The names of the packages of the workspace."""
        return set(self._packages)

    def broken_manifests(self) -> tuple[BrokenManifest, ...]:
        """Return the manifests in the workspace that make no package."""
        if self._colcon is None:
            return ()
        return broken_manifests(
            self._colcon.base_paths(), self._packages.values()
        )

    def select(self, paths: Iterable[str], cwd: Path) -> tuple[str, ...]:
        """
        Return the names of the packages at paths.

        :raises WorkspaceError: if there is none at a path
        """
        if self._colcon is None:
            raise WorkspaceError('there is no workspace to build in')
        names = self._colcon.select(paths, cwd)
        self._find_packages()
        self._make_locator()
        return names

    def update(
        self,
        wanted: set[str],
        *,
        exactly: bool,
        force: bool = False,
        built: Collection[str] = (),
        explain: Callable[[Sequence[Decision]], None] | None = None,
    ) -> Update:
        """
        Build packages that are stale, with what they need, and source again.

        :param wanted: Their names
        :param exactly: Whether what they need is left as it is
        :param force: Whether to build those that are up to date as well
        :param built: Those that are not forced, as they have just been built
        :param explain: Is called with what was decided
        :raises WorkspaceError: if a package cannot be built
        """
        assert self._colcon is not None
        self._refuse_invalid_manifests(wanted)
        build = self._build_environment()
        with interruption() as interrupted:
            update = bring_up_to_date(
                self._colcon,
                wanted,
                build.variables,
                self._announce,
                force=force,
                exactly=exactly,
                notes=[n for n in build.notes if n not in self._sourced.notes],
                built=built,
                explain=explain,
            )
        if interrupted.returncode is not None:
            return replace(update, returncode=interrupted.returncode)
        if update.returncode == 0 and update.has_news:
            self._source()
            self._make_locator()
        return update

    def decide(
        self, wanted: set[str], *, exactly: bool, force: bool
    ) -> tuple[Decision, ...]:
        """
        Decide what :meth:`update` would build.

        :raises WorkspaceError: if that cannot be told
        """
        if self._colcon is None:
            return ()
        build = self._build_environment()
        return decide(
            self._colcon,
            wanted,
            build.variables,
            self._announce,
            force=force,
            exactly=exactly,
        )

    def needed_by(self, wanted: Iterable[str]) -> dict[str, tuple[str, ...]]:
        """Tell by which dependencies packages come to be needed."""
        return needed_by(self._packages.values(), wanted)

    def _build_environment(self) -> BuildEnvironment:
        assert self._colcon is not None
        build = build_environment(
            self._user_environment, self._colcon.install_base
        )
        # what colcon sets for the programs that it calls
        return replace(build, variables={'COLCON': '1', **build.variables})

    def check_sourced(self, names: Sequence[str], *, may_build: bool) -> None:
        """
        Check that packages arrived in the environment.

        :param names: Packages of the workspace
        :param may_build: Whether the launch was allowed to build
        :raises WorkspaceError: if one did not
        """
        if self._colcon is None:
            return
        colcon = self._colcon
        for name in names:
            prefix = Path(self.locator.prefix(name) or '')
            if not (prefix / 'share' / name / 'package.sh').is_file():
                raise WorkspaceError(_not_built(name, may_build=may_build))
        if self._sourced.arrived.issuperset(names):
            return
        # most launches need not look for them
        from colcon_yamllaunch.workspace.environment.environment_check import (
            missing_packages,
        )

        missing = missing_packages(
            self._sourced, names, colcon.install_base, colcon.merge_install
        )
        for reason in missing.values():
            raise WorkspaceError(reason)

    @property
    def _setup(self) -> Path:
        assert self._colcon is not None
        install_base: Path = self._colcon.install_base
        return install_base / 'setup.bash'

    def _find_packages(self) -> None:
        assert self._colcon is not None
        self._packages = {p.name: p for p in self._colcon.packages()}

    def _source(self) -> None:
        assert self._colcon is not None
        self._sourced = remembered(
            self._setup, self._user_environment, self._colcon.build_base
        )
        for note in self._sourced.notes:
            self._announce(note)

    def _make_locator(self) -> None:
        colcon = self._colcon
        self.locator = PackageLocator(
            self._packages.values(),
            Path() if colcon is None else colcon.install_base,
            colcon is not None and colcon.merge_install,
            self.environment,
        )

    def _refuse_invalid_manifests(self, names: set[str]) -> None:
        for name in sorted(names & self.package_names):
            package = self._packages[name]
            reason = invalid_manifest(package)
            if reason is not None:
                raise WorkspaceError(
                    f'{package.path / "package.xml"} is invalid, so colcon '
                    f'would build {name} as a {package.type} package without '
                    f'its dependencies: {reason}'
                )


def _not_built(name: str, *, may_build: bool) -> str:
    cure = (
        'its path is not among --paths'
        if may_build
        else 'leave out --no-build, or build it'
    )
    return f'the package {name} is not built: {cure}'
