# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The part of a machine as a launch of its own."""

from collections.abc import Iterable
from dataclasses import replace

from colcon_yamllaunch.plan.labels import machine_of
from colcon_yamllaunch.plan.plan import AfterReady, Entry, Member, Plan, Timer


def own_part(part: Plan) -> tuple[Plan, dict[str, tuple[str, ...]]]:
    """
    Return a part that waits for nothing on other machines.

    Its labels have no names of machines. Also return what members would wait
    for elsewhere, by their labels.

    :param part: The part, as `deployment.placement` cuts it from a plan
    """
    separated = _Separated({member.label for member in part.members()})
    entries = tuple(map(separated.entry, part.entries))
    return replace(part, entries=entries), separated.missing


class _Separated:
    def __init__(self, own: set[str]) -> None:
        self._own = own
        self.missing: dict[str, tuple[str, ...]] = {}

    def entry(self, entry: Entry) -> Entry:
        """Return an entry that waits for nothing on other machines."""
        if isinstance(entry, Member):
            return self._member(entry)
        if isinstance(entry, AfterReady):
            entry = replace(entry, labels=self._here(entry.labels))
        if isinstance(entry, Timer | AfterReady):
            entries = tuple(map(self.entry, entry.entries))
            entry = replace(entry, entries=entries)
        return entry

    def _member(self, member: Member) -> Member:
        label, settings = _plain(member.label), member.settings
        if settings is not None:
            elsewhere = [n for n in settings.after if n not in self._own]
            if elsewhere:
                self.missing[label] = tuple(elsewhere)
            settings = replace(settings, after=self._here(settings.after))
            if (policy := settings.restart) is not None:
                together = self._here(policy.together)
                policy = replace(policy, together=together)
                settings = replace(settings, restart=policy)
        return replace(member, label=label, settings=settings)

    def _here(self, labels: Iterable[str]) -> tuple[str, ...]:
        return tuple(_plain(label) for label in labels if label in self._own)


def _plain(label: str) -> str:
    return label.removeprefix(machine_of(label))
