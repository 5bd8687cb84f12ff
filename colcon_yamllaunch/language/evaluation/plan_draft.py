# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The plan of a launch while it is made."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace

from colcon_yamllaunch.plan.labels import with_labels
from colcon_yamllaunch.plan.plan import Block, Entry, EvaluatedCondition, Plan
from colcon_yamllaunch.plan.position import Position


class PlanDraft:
    """What is to be run so far, and the blocks that are open."""

    def __init__(self) -> None:
        self.entries: list[Entry] = []
        self.conditions: list[EvaluatedCondition] = []
        #: All blocks so far.
        self.blocks: list[Block] = []
        self._open_blocks: list[int] = []
        #: How many processes have got their names.
        self.process_count = 0
        self._components: set[str] = set()

    def plan(self) -> Plan:
        """Return the plan."""
        return with_labels(
            Plan(
                tuple(self.entries),
                tuple(self.blocks),
                tuple(self.conditions),
            )
        )

    @property
    def block(self) -> int | None:
        """The index of the block that is open."""
        return self._open_blocks[-1] if self._open_blocks else None

    @contextmanager
    def within_block(
        self, kind: str, title: str, position: Position
    ) -> Iterator[None]:
        """Note a block for the time of the context."""
        self.blocks.append(Block(kind, title, position, self.block))
        self._open_blocks.append(len(self.blocks) - 1)
        try:
            yield
        finally:
            self._open_blocks.pop()

    def name_block(self, title: str) -> None:
        """Change the title of the open block."""
        index = self._open_blocks[-1]
        self.blocks[index] = replace(self.blocks[index], title=title)

    def reopen_block(self, block: int | None) -> None:
        """Reopen an earlier block for the next entries."""
        self._open_blocks = [] if block is None else [block]

    def snapshot(self) -> 'PlanDraft':
        """Return the draft as it is, for :meth:`restore`."""
        copy = PlanDraft()
        copy.restore(self)
        return copy

    def restore(self, before: 'PlanDraft') -> None:
        """Forget what was added since a snapshot."""
        self.entries[:] = before.entries
        self.conditions[:] = before.conditions
        self.blocks[:] = before.blocks
        self._open_blocks[:] = before._open_blocks
        self.process_count = before.process_count
        self._components = set(before._components)

    @contextmanager
    def collect(self) -> Iterator[list[Entry]]:
        """Return the entries that are added within the context."""
        before = self.entries
        collected: list[Entry] = []
        self.entries = collected
        try:
            yield collected
        finally:
            self.entries = before

    def process_name(self, program: str) -> str:
        """
        Return what ROS 2 calls the next process.

        The number counts all processes of the launch, as in ROS 2.
        """
        self.process_count += 1
        return f'{program}-{self.process_count}'

    def reserve_labels(self, labels: Iterable[str]) -> None:
        """Reserve labels, so that no further component gets them."""
        self._components.update(labels)

    def component_label(self, plugin: str) -> str:
        """Return a label for the next component, made of its class."""
        label = name = plugin.rpartition(':')[2] or 'component'
        number = 1
        while label in self._components:
            number += 1
            label = f'{name}#{number}'
        self._components.add(label)
        return label
