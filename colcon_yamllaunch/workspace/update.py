# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Bringing the packages that a launch needs up to date."""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from colcon_yamllaunch.workspace.closure import build_closure
from colcon_yamllaunch.workspace.closure import closure
from colcon_yamllaunch.workspace.closure import index
from colcon_yamllaunch.workspace.freshness import Conditions
from colcon_yamllaunch.workspace.freshness import Freshness
from colcon_yamllaunch.workspace.freshness import relevant_environment
from colcon_yamllaunch.workspace.locate import PackageLocator
from colcon_yamllaunch.workspace.lock import build_lock
from colcon_yamllaunch.workspace.moved import moved_packages
from colcon_yamllaunch.workspace.moved import remove_builds
from colcon_yamllaunch.workspace.package import Package


class Result(Protocol):
    """How a build ended, as `colcon.BuildResult`."""

    @property
    def returncode(self) -> int:
        """0 when all went well."""

    @property
    def built(self) -> frozenset[str]:
        """The packages that were built successfully."""


class Builder(Protocol):
    """What builds packages, as `colcon.Colcon`."""

    build_base: Path
    install_base: Path

    @property
    def merge_install(self) -> bool:
        """Whether all packages are installed into one prefix."""

    def packages(self) -> tuple[Package, ...]:
        """Get all packages of the workspace."""

    def settings(self, name: str) -> dict[str, str]:
        """Get the arguments that a package is built with."""

    def build(
        self, names: Collection[str], environment: Mapping[str, str]
    ) -> Result:
        """Build exactly these packages."""


@dataclass(frozen=True, slots=True)
class Update:
    """
    What was done to bring packages up to date.

    :param returncode: 0, or that of the build
    :param stale: The packages that had to be built, in order, each with the
      reason
    :param fresh: The packages that were up to date
    """

    returncode: int
    stale: tuple[tuple[str, str], ...] = ()
    fresh: tuple[str, ...] = ()

    @property
    def summary(self) -> str:
        """One line about what was built and why."""
        fresh = f'{len(self.fresh)} up to date'
        if not self.stale:
            return fresh
        why = '; '.join(f'{name}: {reason}' for name, reason in self.stale)
        noun = 'package' if len(self.stale) == 1 else 'packages'
        return f'{len(self.stale)} {noun} to build ({why}), {fresh}'


def bring_up_to_date(
    colcon: Builder,
    wanted: Collection[str],
    environment: Mapping[str, str],
    announce: Callable[[str], None],
    force: bool = False,
    exactly: bool = False,
    notes: Sequence[str] = (),
) -> Update:
    """
    Build what is not up to date of some packages and of what they need.

    Another launch that builds in this workspace is waited for.

    :param colcon: What builds
    :param wanted: Names of packages; those that are not in the workspace are
      left out
    :param environment: The variables of the build
    :param announce: Is called with a line that the user should see at once
    :param force: Whether to build all of them
    :param exactly: Whether what they need is left as it is
    :param notes: Lines that the user should see before a build
    :raises WorkspaceError: when the build cannot start
    """
    packages = colcon.packages()
    names = closure(packages, wanted)
    if exactly:
        names = [name for name in names if name in wanted]
    if not names:
        return Update(0)
    by_name = {package.name: package for package in packages}
    needed = [by_name[name] for name in names]
    with build_lock(colcon.build_base, announce):
        _forget_moved(colcon, needed, announce)
        work = _Work(colcon, packages, environment)
        stale = work.decide(needed, force)
        fresh = tuple(name for name in names if name not in stale)
        update = Update(0, tuple(stale.items()), fresh)
        if not stale:
            return update
        for line in (*notes, update.summary):
            announce(line)
        returncode = work.build([by_name[name] for name in stale])
        return Update(returncode, update.stale, fresh)


def _forget_moved(
    colcon: Builder,
    needed: Sequence[Package],
    announce: Callable[[str], None],
) -> None:
    moved = moved_packages(needed, colcon.build_base)
    if not moved:
        return
    place = next(iter(moved.values()))
    announce(
        f'the workspace was moved or copied since it was built ({place}): '
        f'building anew what belongs to the old place: {", ".join(moved)}'
    )
    remove_builds(
        moved,
        colcon.build_base,
        colcon.install_base,
        colcon.merge_install,
    )


class _Work:
    """Deciding and building under the same conditions."""

    def __init__(
        self,
        colcon: Builder,
        packages: Sequence[Package],
        environment: Mapping[str, str],
    ) -> None:
        self._colcon = colcon
        self._known = index(packages)
        self._environment = environment
        self._relevant = relevant_environment(environment, colcon.install_base)
        self._freshness = Freshness(
            colcon.build_base, colcon.install_base, colcon.merge_install
        )
        self._underlays = PackageLocator(
            (), colcon.install_base, colcon.merge_install, environment
        )

    def decide(self, needed: Sequence[Package], force: bool) -> dict[str, str]:
        """Get the packages to be built with the reasons, in build order."""
        stale: dict[str, str] = {}
        for package in needed:
            reason = self._reason(package, stale, force)
            if reason is not None:
                stale[package.name] = reason
        return stale

    def build(self, stale: Sequence[Package]) -> int:
        """Build packages and remember those that succeeded."""
        files = {
            package.name: self._freshness.prepare(package) for package in stale
        }
        result = self._colcon.build(list(files), self._environment)
        for package in stale:
            if package.name in result.built:
                self._freshness.remember(
                    package,
                    files[package.name],
                    self._conditions(package.name),
                )
        return result.returncode

    def _reason(
        self, package: Package, stale: Mapping[str, str], force: bool
    ) -> str | None:
        if force:
            return 'asked for'
        needed, _ = build_closure(self._known, package.name)
        rebuilt = next((name for name in stale if name in needed), None)
        conditions = self._conditions(package.name)
        reason = self._freshness.stale(package, conditions)
        if reason is None and rebuilt is not None:
            return f'{rebuilt} is built'
        return reason

    def _conditions(self, name: str) -> Conditions:
        own, others = build_closure(self._known, name)
        dependencies: dict[str, str | None] = {}
        for needed in sorted(own):
            record = self._freshness.record(needed)
            dependencies[needed] = record.id if record else None
        for needed in sorted(others):
            build = self._build_in_underlay(needed)
            if build is not None:
                dependencies[needed] = build
        return Conditions(
            self._colcon.settings(name), self._relevant, dependencies
        )

    def _build_in_underlay(self, name: str) -> str | None:
        """Tell which build of a package an underlay has."""
        share = self._underlays.share(name)
        if share is None:
            return None
        # colcon writes the script at each build, installers the manifest
        times = []
        for file in ('package.sh', 'package.xml'):
            with suppress(OSError):
                times.append(Path(share, file).stat().st_mtime_ns)
        return ' '.join([share, *map(str, times)])
