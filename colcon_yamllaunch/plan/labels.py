# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The labels of processes and components, in front of their output.

ROS 2 names a process by its program and its number in the launch, such as
`talker.py-2`. Users cannot tell two processes of one program apart by that,
so a label is the name of the node if the launch file sets one.
"""

from collections import Counter
from collections.abc import Collection
from dataclasses import replace
from itertools import chain, count

from colcon_yamllaunch.plan.plan import changed_entries, Entry, Member, Plan

#: Separates the name of a machine from that of a process there.
MACHINE_SEPARATOR = '│'
#: Stands for all packages of a merged install space without build records.
ANY_PACKAGE = '*'
#: Labels that no node gets: the launcher's own lines have them.
RESERVED = frozenset({'launch'})


def machine_of(label: str) -> str:
    """Return the machine in a label, with what follows it; or nothing."""
    name, separator, _ = label.partition(MACHINE_SEPARATOR)
    return name + separator if separator else ''


def with_labels(plan: Plan, taken: Collection[str] = ()) -> Plan:
    """
    Return a plan whose processes and components have labels, all different.

    A label is the name of the node; its full name without the first slash
    where nodes in several namespaces have that name; and the name in ROS 2
    where there is no node name, or several nodes have the same full name.

    :param taken: The labels of what runs already, which stay as they are
    """
    full_names = {
        m.ros_name: (m.node_name or '').lstrip('/') for m in plan.members()
    }
    short_names = {n: f.rpartition('/')[2] for n, f in full_names.items()}
    kept = {*RESERVED, *taken, *full_names}
    choices = [
        (names, Counter(names.values())) for names in (short_names, full_names)
    ]

    def label_of(name: str) -> str:
        for names, uses in choices:
            label = names[name]
            if label and uses[label] == 1 and label not in kept:
                return label
        return _free(name, taken)

    def labelled(entry: Entry) -> Entry:
        if isinstance(entry, Member):
            return replace(entry, label=label_of(entry.ros_name))
        return entry

    return replace(plan, entries=changed_entries(plan.entries, labelled))


def _free(name: str, taken: Collection[str]) -> str:
    """Return a name, or one like it if something that runs has it."""
    names = chain([name], (f'{name}-{number}' for number in count(2)))
    return next(n for n in names if n not in taken)
