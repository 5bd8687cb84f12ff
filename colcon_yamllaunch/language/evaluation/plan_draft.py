# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A plan that is being made."""

from collections.abc import Iterable
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from colcon_yamllaunch.plan.labels import with_labels
from colcon_yamllaunch.plan.plan import Block
from colcon_yamllaunch.plan.plan import Condition
from colcon_yamllaunch.plan.plan import Entry
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.position import Position


class PlanDraft:
    """What is to be run so far, and the blocks that are open."""

    def __init__(self) -> None:
        self.entries: list[Entry] = []
        self.conditions: list[Condition] = []
        self._blocks: list[Block] = []
        self._open_blocks: list[int] = []
        self._count = 0
        self._components: set[str] = set()

    def plan(self) -> Plan:
        """Return the plan."""
        return with_labels(
            Plan(
                tuple(self.entries),
                tuple(self._blocks),
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
        self._blocks.append(Block(kind, title, position, self.block))
        self._open_blocks.append(len(self._blocks) - 1)
        try:
            yield
        finally:
            self._open_blocks.pop()

    def name_block(self, title: str) -> None:
        """Give the block that is open another title."""
        index = self._open_blocks[-1]
        self._blocks[index] = replace(self._blocks[index], title=title)

    @property
    def blocks(self) -> tuple[Block, ...]:
        """All blocks so far."""
        return tuple(self._blocks)

    def go_on_in(self, block: int | None) -> None:
        """Let what comes stand in a block that was there before."""
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
        self._blocks[:] = before._blocks
        self._open_blocks[:] = before._open_blocks
        self._count = before._count
        self._components = set(before._components)

    @contextmanager
    def collect(self) -> Iterator[list[Entry]]:
        """Give the entries that are added for the time of the context."""
        before = self.entries
        collected: list[Entry] = []
        self.entries = collected
        try:
            yield collected
        finally:
            self.entries = before

    @property
    def process_count(self) -> int:
        """How many processes have got their names."""
        return self._count

    def process_name(self, program: str) -> str:
        """
        Return what ROS 2 calls the next process.

        The number counts all processes of the launch, as in ROS 2.
        """
        self._count += 1
        return f'{program}-{self._count}'

    def take_labels(self, labels: Iterable[str]) -> None:
        """Take note of labels that no further component gets."""
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
