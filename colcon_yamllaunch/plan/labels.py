# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What the parts of a launch are called, in front of their output and elsewhere.

ROS 2 calls a process by its program and its number in the launch, as
`talker.py-2`. Two processes of one program are hard to tell apart by that, so
a label is the name of the node where the launch file gives one.
"""

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import chain, count
from typing import NamedTuple

from colcon_yamllaunch.plan.plan import (
    changed_entries,
    Component,
    Entry,
    Plan,
    Process,
)

#: What stands between the name of a machine and that of a process there.
MACHINE_SEPARATOR = '│'
#: What no node is called in output: the launcher's own lines have it.
RESERVED = frozenset({'launch'})


def machine_of(label: str) -> str:
    """Return the machine in a label, with what follows it; or nothing."""
    name, separator, _ = label.partition(MACHINE_SEPARATOR)
    return name + separator if separator else ''


class Unlabelled(NamedTuple):
    """
    Something that gets a label.

    :param name: What it is called without a node name; nothing else in the
      launch has the same
    :param node: The full name of its node, None when the launch file gives it
      none
    """

    name: str
    node: str | None


def labels_of(
    things: Sequence[Unlabelled], taken: Collection[str] = ()
) -> list[str]:
    """
    Return a label for each of some things, all different.

    It is the name of the node; its full name without the first slash where
    nodes in several namespaces have that name; and the name of the thing
    where there is no node name, or several nodes have the same full name.

    :param taken: The labels of what runs already, which stay as they are
    """
    short = [_last_part(thing.node) for thing in things]
    full = [(thing.node or '').lstrip('/') for thing in things]
    kept = {*RESERVED, *taken, *(thing.name for thing in things)}
    uses = Counter(short), Counter(full)
    labels = []
    for thing, *wishes in zip(things, short, full, strict=True):
        fitting = (
            wish
            for wish, used in zip(wishes, uses, strict=True)
            if wish and used[wish] == 1 and wish not in kept
        )
        labels.append(next(fitting, None) or _free(thing.name, taken))
    return labels


def with_labels(plan: Plan, taken: Collection[str] = ()) -> Plan:
    """
    Return a plan whose processes and components have their labels.

    :param taken: The labels of what runs already, which stay as they are
    """
    things = [Unlabelled(p.ros_name, p.node_name) for p in plan.processes()]
    things += [Unlabelled(c.label, c.node_name) for c in plan.components()]
    labels = dict(
        zip((t.name for t in things), labels_of(things, taken), strict=True)
    )

    def labelled(entry: Entry) -> Entry:
        if isinstance(entry, Process | Component):
            return replace(entry, label=labels[entry.label])
        return entry

    return replace(plan, entries=changed_entries(plan.entries, labelled))


def _free(name: str, taken: Collection[str]) -> str:
    """Return a name, or one like it if something that runs has it."""
    names = chain([name], (f'{name}-{number}' for number in count(2)))
    return next(n for n in names if n not in taken)


def _last_part(node: str | None) -> str:
    return (node or '').rpartition('/')[2]
