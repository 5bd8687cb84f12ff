# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Bringing the packages that a launch needs up to date."""

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache
from pathlib import Path

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.building.build_lock import WorkspaceLock
from colcon_yamllaunch.workspace.building.build_processes import mark
from colcon_yamllaunch.workspace.building.build_report import (
    after_failure,
    before_build,
    setup_missing,
)
from colcon_yamllaunch.workspace.colcon.colcon_cache import (
    BuildResult,
    CachedColcon,
)
from colcon_yamllaunch.workspace.environment.sourcing import Environment
from colcon_yamllaunch.workspace.freshness.build_products import Products
from colcon_yamllaunch.workspace.freshness.build_record import (
    build_identifier,
    BuildContext,
    BuildMode,
    Decision,
    mode_for_dependents,
    Reason,
    relevant_environment,
)
from colcon_yamllaunch.workspace.freshness.freshness import Attempt, Freshness
from colcon_yamllaunch.workspace.packages.package import (
    build_closure,
    closure,
    index,
    Package,
)
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator


@dataclass(frozen=True, slots=True)
class BuildRequest:
    """
    What is to be brought up to date.

    :param names: Packages, and with them all that they need; those that are
      not in the workspace are left out
    :param exactly: Whether what they need is left as it is
    :param force: Whether to build those that are up to date as well
    :param built: Packages that are not forced, as they have just been built
    """

    names: Collection[str]
    exactly: bool = False
    force: bool = False
    built: Collection[str] = ()


@dataclass(frozen=True, slots=True)
class Update:
    """
    What was done to bring packages up to date.

    :param returncode: 0, or that of the build
    :param decisions: What was decided of each package, in build order
    :param built: The packages that were built successfully
    :param failed: Those that were begun in vain, as far as is known
    :param waited: Whether another launch has built in the meantime
    """

    returncode: int
    decisions: tuple[Decision, ...] = ()
    built: frozenset[str] = frozenset()
    failed: frozenset[str] = frozenset()
    waited: bool = False

    @property
    def changed(self) -> bool:
        """Whether the install space may be another one than before."""
        return self.waited or any(d.is_stale for d in self.decisions)

    def failure(self) -> str:
        """Return how far a build came that did not succeed, in one line."""
        stale = [name for name, _ in self.stale]
        done = self.built | self.failed
        return after_failure(
            [name for name in stale if name in self.failed],
            [name for name in stale if name in self.built],
            [name for name in stale if name not in done],
        )

    @property
    def stale(self) -> tuple[tuple[str, str], ...]:
        """The packages that had to be built, each with the first reason."""
        return tuple((d.name, d.reason) for d in self.decisions if d.is_stale)


def bring_up_to_date(
    colcon: CachedColcon,
    request: BuildRequest,
    environment: Environment,
    announce: Callable[[str], None],
    explain: Callable[[Sequence[Decision]], None] | None = None,
    lock: WorkspaceLock | None = None,
) -> Update:
    """
    Build what is not up to date.

    Another launch that builds in this workspace is waited for.

    :param announce: Is called with a line that the user should see at once
    :param explain: Is called with what was decided
    :param lock: Is taken, and held on return; without it one ends here
    :raises WorkspaceError: when the build cannot start
    """
    needed = _needed(colcon, request)
    if not needed:
        return Update(0)
    if lock is None:
        with WorkspaceLock() as lock:
            return bring_up_to_date(
                colcon, request, environment, announce, explain, lock
            )
    waited = lock.acquire(colcon.build_base, announce)
    work = _Builder(colcon, environment.variables)
    work.freshness.remove_relocated(needed, announce)
    decisions = work.decide(needed, request)
    if explain is not None:
        explain(decisions)
    stale = [d for d in decisions if d.is_stale]
    if not stale:
        return Update(0, decisions, waited=waited)
    fresh = len(decisions) - len(stale)
    lock.publish_build(d.name for d in stale)
    for line in (*environment.notes, before_build(stale, fresh)):
        announce(line)
    by_name = {package.name: package for package in needed}
    result = work.build([(by_name[d.name], d.mode) for d in stale])
    lock.publish_start()
    for line in setup_missing(by_name[name] for name in result.failed):
        announce(line)
    return Update(result.returncode, decisions, result.built, result.failed)


def decide(
    colcon: CachedColcon,
    request: BuildRequest,
    environment: Environment,
    announce: Callable[[str], None],
) -> tuple[Decision, ...]:
    """
    Decide what would be built, and build nothing.

    The parameters are those of :func:`bring_up_to_date`.
    """
    needed = _needed(colcon, request)
    if not needed:
        return ()
    with WorkspaceLock() as lock:
        lock.acquire(colcon.build_base, announce)
        return _Builder(colcon, environment.variables).decide(needed, request)


def _needed(colcon: CachedColcon, request: BuildRequest) -> list[Package]:
    packages = colcon.packages()
    names = closure(packages, request.names)
    by_name = {package.name: package for package in packages}
    return [
        by_name[name]
        for name in names
        if name in request.names or not request.exactly
    ]


class _Builder:
    """Deciding and building under the same context."""

    def __init__(
        self, colcon: CachedColcon, environment: Mapping[str, str]
    ) -> None:
        self._colcon = colcon
        self._known = index(colcon.packages())
        self._environment = environment
        self._relevant = relevant_environment(environment, colcon.install_base)
        self._products = Products(
            colcon.build_base, colcon.install_base, colcon.merge_install
        )
        self.freshness = Freshness(self._products, environment)
        self._underlays = PackageLocator(
            (), colcon.install_base, colcon.merge_install, environment
        )
        # as it was before this build, which may have seen either if that one
        # was built meanwhile
        self._build_in_underlay = cache(self._find_in_underlay)

    def decide(
        self, needed: Sequence[Package], request: BuildRequest
    ) -> tuple[Decision, ...]:
        """Decide about packages that are given in build order."""
        decisions: dict[str, Decision] = {}
        for package in needed:
            name = package.name
            own, _ = build_closure(self._known, name)
            before = [
                _after(other)
                for other in decisions.values()
                if other.is_stale and other.name in own
            ]
            context = self._context(name)
            decision = self.freshness.decide(package, context, before, own)
            if request.force and name not in request.built:
                is_damaged = any(r.is_damage for r in decision.reasons)
                mode = BuildMode.CLEAN if is_damaged else BuildMode.CONFIGURE
                reasons = (Reason('asked for', mode), *decision.reasons)
                decision = replace(decision, reasons=reasons)
            decisions[name] = decision
        return tuple(decisions.values())

    def build(self, stale: Sequence[tuple[Package, BuildMode]]) -> BuildResult:
        """Build packages, and record how that went."""
        freshness, colcon = self.freshness, self._colcon
        # before what was built is forgotten
        colcon.mark()
        begun: dict[str, Attempt] = {}
        built: frozenset[str] = frozenset()
        try:
            for package, mode in stale:
                begun[package.name] = freshness.prepare(package, mode)
            result = colcon.build(
                list(begun), {**self._environment, **mark(colcon.build_base)}
            )
            built = result.built
        finally:
            for name, attempt in begun.items():
                if name in built:
                    freshness.record_success(attempt, self._context(name))
                else:
                    freshness.record_failure(attempt)
            # most launches build nothing
            from colcon_yamllaunch.common.files import sync_file_systems

            # the records, and what they vouch for
            sync_file_systems([colcon.build_base, colcon.install_base])
        return result

    def _context(self, name: str) -> BuildContext:
        own, others = build_closure(self._known, name)
        dependencies = {n: self.freshness.last_build(n) for n in sorted(own)}
        for needed in sorted(others):
            build = self._build_in_underlay(needed)
            if build is not None:
                dependencies[needed] = build
        settings = self._colcon.settings(name)
        return BuildContext(settings, self._relevant, dependencies)

    def _find_in_underlay(self, name: str) -> str | None:
        """Return which build of a package an underlay has."""
        share = self._underlays.share(name)
        if share is None:
            return None
        # colcon writes the script at each build, installers the manifest
        times = []
        for file in ('package.sh', 'package.xml'):
            with suppress(OSError):
                times.append(Path(share, file).stat().st_mtime_ns)
        return build_identifier(' '.join([share, *map(str, times)]), '', '')


def _after(dependency: Decision) -> Reason:
    """Return the reason to build a package again after one it needs."""
    is_new = dependency.built_at is None or dependency.mode is BuildMode.CLEAN
    mode = mode_for_dependents(BuildMode.CLEAN if is_new else dependency.mode)
    return Reason(f'{dependency.name} is built', mode)
