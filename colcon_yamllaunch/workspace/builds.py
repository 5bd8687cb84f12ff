# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The builds of one launch, and the messages about them."""

from collections.abc import Callable, Collection, Sequence
from contextlib import redirect_stdout
from dataclasses import replace
import sys
from typing import Any

from colcon_yamllaunch.common.messages import ForgivingOutput, say_line
from colcon_yamllaunch.workspace.building.build_processes import interruption
from colcon_yamllaunch.workspace.building.build_report import (
    after_build,
    explanation,
)
from colcon_yamllaunch.workspace.building.update import (
    bring_up_to_date,
    BuildRequest,
    decide,
    Update,
)
from colcon_yamllaunch.workspace.freshness.build_record import Decision
from colcon_yamllaunch.workspace.workspace_session import WorkspaceSession


class Builds:
    """
    The builds of one launch.

    A launch may need more packages after a build, so there may be several
    builds; one line reports all of them.

    :param exactly: Whether to leave out the dependencies of packages
    :param force: Whether to build packages that are up to date, too
    :param why: Whether to print why each package is built or not
    """

    def __init__(
        self,
        session: WorkspaceSession,
        *,
        exactly: bool,
        force: bool = False,
        why: bool = False,
    ) -> None:
        self._session = session
        self._exactly = exactly
        self._force = force
        self._why = why
        self._built: dict[str, Decision] = {}
        self._fresh: set[str] | None = None
        self._explained: set[str] = set()

    @property
    def names(self) -> list[str]:
        """The packages that were built."""
        return list(self._built)

    def update(
        self,
        wanted: Collection[str],
        launch: str,
        look_first: Callable[[], None],
    ) -> Update:
        """
        Build packages that are stale, with what they need, and source again.

        :param launch: What the launch file is called in explanations
        :param look_first: Is called before anything is built, and may raise
        :raises WorkspaceError: when a package cannot be built
        """
        session = self._session
        session.refuse_invalid_manifests(wanted)
        environment = session.build_environment()
        output: Any = ForgivingOutput(sys.stdout)

        def decided(decisions: Sequence[Decision]) -> None:
            if self._why:
                self._explain(decisions, wanted, launch)
            if any(decision.is_stale for decision in decisions):
                look_first()

        with interruption() as interrupted, redirect_stdout(output):
            update = bring_up_to_date(
                session.colcon,
                self._request(wanted),
                environment,
                session.announce,
                decided,
                session.lock,
            )
        if interrupted.returncode is not None:
            update = replace(update, returncode=interrupted.returncode)
        elif update.returncode == 0 and update.changed:
            session.source()
        self._fresh = self._fresh or set()
        for decision in update.decisions:
            if decision.name in update.built:
                self._built.setdefault(decision.name, decision)
            elif not decision.is_stale:
                self._fresh.add(decision.name)
        return update

    def report(self) -> None:
        """Print in one line which packages were built, if any."""
        if self._fresh is not None:
            fresh = self._fresh - set(self._built)
            say_line(after_build(list(self._built.values()), len(fresh)))

    def explain(self, wanted: Collection[str], launch: str) -> None:
        """Print which packages would be built and why."""
        decisions = decide(
            self._session.colcon,
            self._request(wanted),
            self._session.build_environment(),
            self._session.announce,
        )
        self._explain(decisions, wanted, launch)

    def _request(self, wanted: Collection[str]) -> BuildRequest:
        return BuildRequest(wanted, self._exactly, self._force, self._built)

    def _explain(
        self,
        decisions: Sequence[Decision],
        wanted: Collection[str],
        launch: str,
    ) -> None:
        ways = self._session.needed_by(wanted)
        for decision in decisions:
            if decision.name not in self._explained:
                self._explained.add(decision.name)
                say_line(explanation(decision, ways[decision.name], launch))
