# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Holds entries of the plan back until other members are ready."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.plan.plan import (
    AfterReady,
    changed_entries,
    Entry,
    Member,
    Plan,
)

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.engine import Engine


class HeldEntries:
    """
    The entries of a plan that wait until others are ready.

    :param engine: Has the state of the launch, and emits events
    :param execute: Executes entries that are due
    """

    def __init__(
        self,
        engine: 'Engine',
        execute: Callable[[Iterable[Entry]], object],
    ) -> None:
        self._engine = engine
        self._execute = execute
        self._held: list[AfterReady] = []
        # the version of the readiness for which they were checked
        self._checked_version = 0

    def hold(self, entry: AfterReady) -> None:
        """Execute entries once what they wait for is ready."""
        state = self._engine.state
        missing = state.missing_of(entry.labels)
        if not missing:
            self._execute(entry.entries)
            return
        self._held.append(entry)
        for member in _members(entry):
            if state.by_label[member.label].waits_for != missing:
                self._engine.emit(events.Waiting(member, missing))

    def hold_again(self, member: Member) -> None:
        """Let a held member wait for what its settings name now."""
        settings = member.settings
        after = () if settings is None else settings.after
        held, self._held = self._held, []
        for entry in held:
            if entry.labels != after and _has(entry, member.label):
                self.hold(replace(entry, labels=after))
            else:
                self._held.append(entry)

    def release_ready(self) -> None:
        """Execute the entries whose dependencies are ready now."""
        version = self._engine.state.readiness_version
        if not self._held or version == self._checked_version:
            return
        self._checked_version = version
        held, self._held = self._held, []
        for entry in held:
            self.hold(entry)

    def abandon(self) -> None:
        """Report that held members never start, as no dependency runs."""
        held, self._held = self._held, []
        for entry in held:
            missing = self._engine.state.missing_of(entry.labels)
            for member in _members(entry):
                self._engine.emit(events.NotStarted(member, missing))

    def drop(self, label: str) -> None:
        """Remove the entries with a member, such as one to be stopped."""
        self._held = [e for e in self._held if not _has(e, label)]

    def change(self, change: Callable[[Entry], Entry | None]) -> None:
        """Change each entry; see :func:`.changed_entries`."""
        # without its entries, one is dropped
        self._held = [
            entry
            for entry in changed_entries(self._held, change)
            if isinstance(entry, AfterReady) and entry.entries
        ]

    def clear(self) -> None:
        """Remove all of them."""
        self._held.clear()


def _members(entry: AfterReady) -> Iterable[Member]:
    return Plan(entry.entries).members()


def _has(entry: AfterReady, label: str) -> bool:
    return any(member.label == label for member in _members(entry))
