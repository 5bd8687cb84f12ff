# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The launch files, groups and timers of a plan, and what stands in them."""

from collections.abc import Iterable
from collections.abc import Sequence
from dataclasses import dataclass
from dataclasses import field

from colcon_yamllaunch.common.codec import Codec
from colcon_yamllaunch.common.codec import only
from colcon_yamllaunch.plan.plan import Block
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import Process


@dataclass(slots=True)
class Branch:
    """
    A part of the tree.

    :param kind: `file`, `group`, `timer`, `process` or `component`
    :param title: What to call it: a path, a namespace, a time, a label; it
      may be empty
    :param position: Where it is written, as `PATH:LINE:COLUMN`; a file, where
      it is included
    :param children: What stands in it, in the order of the plan; components
      stand in their container if that is of the launch
    """

    kind: str
    title: str
    position: str
    children: 'list[Branch]' = field(default_factory=list)


def from_json(data: object) -> tuple[Branch, ...]:
    """
    Return the tree that the control protocol has.

    :raises CodecError: when it is malformed
    """
    codec = Codec(accept_unknown=True)
    return tuple(
        codec.from_json(Branch, branch, 'tree') for branch in only(list, data)
    )


def plan_tree(
    blocks: Sequence[Block],
    processes: Iterable[Process],
    components: Iterable[tuple[Component, Process | None]],
) -> tuple[Branch, ...]:
    """
    Return what stands in no other part, with all that stands in that.

    :param blocks: The launch files, groups and timers of the plan, outer ones
      first
    :param processes: Its processes in order
    :param components: Its components in order, with the process of their
      container if it has one
    """
    branches = [
        Branch(block.kind, block.title, str(block.position))
        for block in blocks
    ]
    roots: list[Branch] = []
    placed: set[int | None] = {None}

    def inside(index: int | None) -> list[Branch]:
        """Return the children of a block, which is in its place then."""
        if index is None or index >= len(blocks):
            # what a change of the plan drops may have that of a former one
            return roots
        if index not in placed:
            placed.add(index)
            inside(blocks[index].parent).append(branches[index])
        return branches[index].children

    containers: dict[str, Branch] = {}
    for process in processes:
        position = str(process.position)
        branch = Branch('process', process.label, position)
        containers[process.label] = branch
        inside(process.block).append(branch)
    for component, container in components:
        position = str(component.position)
        branch = Branch('component', component.label, position)
        if container is not None and container.label in containers:
            containers[container.label].children.append(branch)
        else:
            inside(component.block).append(branch)
    # those with nothing in them
    for index in range(len(blocks)):
        inside(index)
    return tuple(roots)
