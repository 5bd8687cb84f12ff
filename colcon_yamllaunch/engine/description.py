# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launch responds about its plan: a process, or the whole tree."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field, replace
from typing import Any

from colcon_yamllaunch.common.codec import Codec, only
from colcon_yamllaunch.common.frozen import dataclass, mutable
from colcon_yamllaunch.plan.plan import (
    Block,
    Component,
    Member,
    Process,
    SetParameter,
)


@dataclass(frozen=True, slots=True)
class Parameter:
    """
    A parameter that a node is given.

    :param value: Its value as YAML
    :param position: Where it is set, as `PATH:LINE:COLUMN`
    :param origins: Where the launch configurations that its value is made of
      were set, nearest first
    """

    name: str
    value: str
    position: str
    origins: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class EnclosingBlock:
    """
    What a process or component stands in.

    :param kind: `file`, `group` or `timer`
    :param title: What to call it: a path, a namespace, a time
    :param position: Where it is written; a file, where it is included
    """

    kind: str
    title: str
    position: str


@dataclass(frozen=True, slots=True)
class Description:
    """
    A process or component.

    :param label: Its name in output and logs
    :param name: What ROS 2 calls it
    :param node: The full name of its ROS node as far as it is known
    :param package: The package that it comes from, if any
    :param position: Where the launch file has it, as `PATH:LINE:COLUMN`
    :param within: What it stands in, the outermost first
    :param parameters: Its parameters in order; the last of several with one
      name counts
    :param log: The path of the log with all of its output, if there is one;
      of a component, that of its container
    :param argv: The command line of a process; a component has none
    :param cwd: Its working directory, None for a component
    :param environment: Its variables that differ from those of the launch;
      None where one is unset
    :param plugin: The class of a component, None for a process
    :param container: The full name of the node of its container, likewise
    :param remaps: The remapping rules of a component as `from:=to`
    """

    label: str
    name: str
    node: str | None
    package: str | None
    position: str
    within: tuple[EnclosingBlock, ...]
    parameters: tuple[Parameter, ...]
    log: str | None
    argv: tuple[str, ...] = ()
    cwd: str | None = None
    environment: tuple[tuple[str, str | None], ...] = ()
    plugin: str | None = None
    container: str | None = None
    remaps: tuple[str, ...] = ()


#: A description as JSON has it: an object for variables, and what a later
#: version added is ignored.
_CODEC = Codec(
    special={
        tuple[tuple[str, str | None], ...]: (
            dict,
            lambda data: tuple(sorted(only(dict, data).items())),
        )
    },
    accept_unknown=True,
)


def from_json(data: object) -> Description:
    """
    Return the description that the control protocol has.

    :raises CodecError: when it is malformed
    """
    return _CODEC.from_json(Description, data, 'description')


def described(
    member: Member,
    node: str | None,
    parameters: Iterable[SetParameter],
    blocks: Sequence[Block],
    log: str | None,
    argv: Sequence[str] = (),
) -> Description:
    """
    Describe a process or component.

    :param node: The full name of its node, if it is known better than in the
      plan
    :param parameters: All that it is given
    :param blocks: The launch files, groups and timers of the plan
    :param log: The log with all of its output, if there is one
    :param argv: Its command line as it is started
    """
    more: dict[str, Any] = {}
    if isinstance(member, Component):
        more['plugin'] = member.plugin
        more['container'] = member.container
        more['remaps'] = member.remaps
    else:
        more['argv'] = tuple(argv)
        more['cwd'] = member.cwd
        more['environment'] = member.environment
    return Description(
        member.label,
        member.ros_name,
        node or member.node_name,
        member.package,
        str(member.position),
        _within(member.block, blocks),
        tuple(map(_parameter, parameters)),
        log,
        **more,
    )


def received_description(
    member: Member,
    received: Mapping[str, Any],
    blocks: Sequence[Block],
    log: str | None,
) -> Description:
    """
    Describe what runs on another machine.

    What comes from there and makes no sense is passed over.

    :param member: It as it is known here
    :param received: The attributes of its description there
    :param blocks: The launch files, groups and timers of the plan
    :param log: The log with all of its output here, if there is one
    """
    node = _text(received.get('node'))
    found = described(member, node, member.parameters, blocks, log)
    variables = received.get('environment')
    if not isinstance(variables, Mapping):
        variables = {}
    environment = tuple((str(n), _text(v)) for n, v in variables.items())
    if isinstance(member, Component):
        return replace(found, environment=environment)
    argv = received.get('argv')
    return replace(
        found,
        environment=environment,
        argv=tuple(map(str, argv)) if isinstance(argv, list) else (),
        cwd=_text(received.get('cwd')),
    )


def _text(received: object) -> str | None:
    return received if isinstance(received, str) else None


def _parameter(parameter: SetParameter) -> Parameter:
    return Parameter(
        parameter.name,
        parameter.value,
        str(parameter.position),
        tuple(map(str, parameter.origins)),
    )


def _within(
    index: int | None, blocks: Sequence[Block]
) -> tuple[EnclosingBlock, ...]:
    """Return the blocks around a member, the outermost first."""
    found = []
    # what a change of the plan drops may have the index of a former one
    while index is not None and index < len(blocks):
        block = blocks[index]
        position = str(block.position)
        found.append(EnclosingBlock(block.kind, block.title, position))
        index = block.parent
    return tuple(reversed(found))


@mutable
class Branch:
    """
    A node of the tree of a plan.

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


def tree_from_json(data: object) -> tuple[Branch, ...]:
    """
    Return the tree that the control protocol has.

    :raises CodecError: when it is malformed
    """
    return tuple(
        _CODEC.from_json(Branch, branch, 'tree') for branch in only(list, data)
    )


def plan_tree(
    blocks: Sequence[Block],
    processes: Iterable[Process],
    components: Iterable[tuple[Component, Process | None]],
) -> tuple[Branch, ...]:
    """
    Return the outermost branches, with all that stands in them.

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
    # groups and timers with nothing in them
    for index in range(len(blocks)):
        inside(index)
    return tuple(roots)
