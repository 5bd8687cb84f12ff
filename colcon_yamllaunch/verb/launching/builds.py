# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The builds of one launch, and what the user is told about them."""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Sequence

from colcon_yamllaunch.verb.cli.launch_options import LaunchOptions
from colcon_yamllaunch.verb.launching.workspace_session import (
    InstalledWorkspace,
)
from colcon_yamllaunch.workspace.building.build_report import after_build
from colcon_yamllaunch.workspace.building.build_report import after_failure
from colcon_yamllaunch.workspace.building.build_report import explanations
from colcon_yamllaunch.workspace.building.update import Update
from colcon_yamllaunch.workspace.freshness.build_decision import Decision


class Building:
    """
    The builds of one launch.

    What one build brings may make more packages necessary, so there may be
    several; the user gets one line about all of them.

    :param workspace: Where it is built
    :param options: What the user asks for
    :param say: Is called with a line that the user should see at once
    """

    def __init__(
        self,
        workspace: InstalledWorkspace,
        options: LaunchOptions,
        say: Callable[[str], None],
    ) -> None:
        self._workspace = workspace
        self._options = options
        self._say = say
        self._built: dict[str, Decision] = {}
        self._fresh: set[str] = set()
        self._explained: set[str] = set()
        self._has_decided = False

    def update(self, wanted: Collection[str], launch: str) -> Update:
        """
        Build what is stale of some packages and of what they need.

        :param wanted: Their names
        :param launch: What the launch file is called in explanations
        :raises WorkspaceError: if a package cannot be built
        """
        update = self._workspace.update(
            set(wanted),
            exactly=self._exactly,
            force=self._options.force,
            built=set(self._built),
            explain=self._explainer(wanted, launch)
            if self._options.why
            else None,
        )
        self._has_decided = True
        for decision in update.decisions:
            if decision.name in update.built:
                self._built.setdefault(decision.name, decision)
            elif not decision.is_stale:
                self._fresh.add(decision.name)
        if update.returncode:
            self._say(_failure(update))
        return update

    def tell(self) -> None:
        """Say in one line what was built, if it came to that."""
        if not self._has_decided or self._options.quiet:
            return
        fresh = self._fresh - set(self._built)
        self._say(after_build(list(self._built.values()), len(fresh)))

    def explain(self, wanted: Collection[str], launch: str) -> None:
        """
        Say what would be built and why, and build nothing.

        The parameters are those of :meth:`update`.
        """
        decisions = self._workspace.decide(
            set(wanted), exactly=self._exactly, force=self._options.force
        )
        self._explainer(wanted, launch)(decisions)

    @property
    def _exactly(self) -> bool:
        return self._options.paths is not None

    def _explainer(
        self, wanted: Collection[str], launch: str
    ) -> Callable[[Sequence[Decision]], None]:
        def explain(decisions: Sequence[Decision]) -> None:
            new = [d for d in decisions if d.name not in self._explained]
            self._explained.update(d.name for d in new)
            ways = self._workspace.needed_by(wanted)
            for line in explanations(new, ways, launch):
                self._say(line)

        return explain


def _failure(update: Update) -> str:
    stale = [name for name, _ in update.stale]
    done = update.built | update.failed
    return after_failure(
        [name for name in stale if name in update.failed],
        [name for name in stale if name in update.built],
        [name for name in stale if name not in done],
    )
