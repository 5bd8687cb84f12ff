# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the status block shows of the state of a launch."""

from collections.abc import Mapping

from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.engine.state import Part

#: The keys that choose a process, in the order in which they are assigned:
#: those that mean something for all processes are left out.
KEYS = '1234567890abcdefghijklmnoprsuvxyzABCDFGHIJKNOPQRSTUVWXYZ'
#: The share of a processor from which on it is shown.
MUCH_CPU = 0.5


class StatusModel:
    """
    The state of a launch, with a key and the CPU share of each process.

    :param state: The state of the launch
    """

    def __init__(self, state: LaunchState) -> None:
        self.state = state
        #: The shares of a processor, by label; those that are not much are
        #: left out.
        self.cpu: dict[str, float] = {}
        self._keys: dict[str, str] = {}
        self._labels: dict[str, str] = {}
        self._assigned = -1
        self._measured = 0

    @property
    def version(self) -> tuple[int, int]:
        """Another value whenever something of all this has changed."""
        return self.state.version, self._measured

    @property
    def parts(self) -> tuple[Part, ...]:
        """The processes and components, in the order of the plan."""
        return tuple(self.state.by_label.values())

    def part(self, label: str) -> Part | None:
        """Return the process or component with a label."""
        return self.state.by_label.get(label)

    @property
    def keys(self) -> Mapping[str, str]:
        """The keys that choose processes and components, by their labels."""
        self._assign()
        return self._keys

    def label_of(self, key: str) -> str | None:
        """Return the label of what a key chooses."""
        self._assign()
        return self._labels.get(key)

    def measure(self, shares: Mapping[str, float]) -> None:
        """Show the shares of a processor that processes take, by label."""
        # whole per cents, so that not every look is a change
        cpu = {
            label: round(share, 2)
            for label, share in shares.items()
            if share >= MUCH_CPU
        }
        if cpu != self.cpu:
            self.cpu = cpu
            self._measured += 1

    def _assign(self) -> None:
        """Assign keys to new processes; others keep theirs."""
        if self._assigned == self.state.version:
            return
        self._assigned = self.state.version
        for label in self._keys.keys() - self.state.by_label.keys():
            del self._labels[self._keys.pop(label)]
        if len(self._labels) == len(KEYS):
            return
        free = [key for key in KEYS if key not in self._labels]
        new = [p for p in self.state.by_label if p not in self._keys]
        for label, key in zip(new, free, strict=False):
            self._keys[label] = key
            self._labels[key] = label
