# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The names of processes, and which processes a name matches."""

from collections.abc import Iterator, Sequence
from fnmatch import fnmatchcase
import os
import re

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine.state import ComponentState, MemberState
from colcon_yamllaunch.plan.labels import MACHINE_SEPARATOR
from colcon_yamllaunch.plan.plan import Component, Member

_SCRIPTS = ('.py', '.sh')
_NUMBER = re.compile(r'-\d+$')


@dataclass(frozen=True, slots=True)
class ProcessNames:
    """
    The names that a process goes by.

    :param label: Its label, unique in the launch; that of a process on
      another machine, `arm│driver`, counts as `arm/driver` and `driver`, too
    :param name: What ROS 2 calls it, as `counter.py-1`, likewise unique; it
      counts without the number, and that of a script without the suffix, too
    :param executable: The name of its program, or the class of a component
    :param node: The full name of its ROS node, as `/demo/counter`; without
      the first slash, its last part and each namespace around it count, too
    """

    label: str
    name: str
    executable: str
    node: str | None

    @classmethod
    def of_plan(cls, member: Member) -> 'ProcessNames':
        """Return the names of a process or component of a plan."""
        if isinstance(member, Component):
            label = member.label
            return cls(label, label, member.plugin, member.node_name)
        return cls(
            member.label,
            member.ros_name,
            os.path.basename(str(member.argv[0])),
            member.node_name,
        )

    @classmethod
    def of_state(cls, member: MemberState) -> 'ProcessNames':
        """Return the names of a process or component that runs."""
        if isinstance(member, ComponentState):
            return cls(member.label, member.label, member.plugin, member.node)
        name = member.name or member.label
        return cls(member.label, name, member.executable, member.node)

    def __iter__(self) -> Iterator[str]:
        """Iterate over all names, the best one first."""
        yield self.label
        yield from self._shorter
        if self.name != self.label:
            yield self.name
        yield self.program
        stem, suffix = os.path.splitext(self.program)
        if suffix in _SCRIPTS:
            yield stem
        yield self.executable
        if self.node is not None:
            yield self.node
            yield self.node.removeprefix('/')
            namespace, _, last = self.node.rpartition('/')
            yield last
            while namespace:
                yield namespace
                namespace = namespace.rpartition('/')[0]

    @property
    def _shorter(self) -> tuple[str, ...]:
        """The label as it is typed easily, with the machine and without."""
        machine, separator, label = self.label.partition(MACHINE_SEPARATOR)
        return (f'{machine}/{label}', label) if separator else ()

    def is_called(self, name: str) -> bool:
        """Return whether a name means this process only."""
        return name in (self.label, self.name, *self._shorter)

    @property
    def program(self) -> str:
        """The name of ROS 2 without the number."""
        return _NUMBER.sub('', self.name)


def meant_by(pattern: str, known: Sequence[ProcessNames]) -> list[int]:
    """
    Return the indices of the processes that a name or a glob means.

    What is the label of a process, or what ROS 2 calls it, means that one
    only, whatever others go by the same.

    :param pattern: A name, or a pattern with `*`, `?` and `[…]`
    """
    meant = [i for i, names in enumerate(known) if names.is_called(pattern)]
    return meant or [
        index
        for index, names in enumerate(known)
        if any(n == pattern or fnmatchcase(n, pattern) for n in names)
    ]
