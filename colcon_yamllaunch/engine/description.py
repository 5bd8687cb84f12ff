# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""All that is to be told of a process or component of a launch."""

from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.codec import Codec
from colcon_yamllaunch.common.codec import only
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine.components.composition import ComponentTask
from colcon_yamllaunch.plan.plan import Block
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.plan import SetParameter


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
class Surrounding:
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
    within: tuple[Surrounding, ...]
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


def process_description(
    process: Process,
    argv: Sequence[str],
    parameters: Iterable[SetParameter],
    blocks: Sequence[Block],
    log: Path | None,
) -> Description:
    """
    Describe a process.

    :param argv: Its command line as it is started
    :param parameters: All that it is given
    :param blocks: The launch files, groups and timers of the plan
    :param log: The log with all of its output, if there is one
    """
    return Description(
        process.label,
        process.ros_name,
        process.node_name,
        process.package,
        str(process.position),
        _within(process.block, blocks),
        tuple(map(_parameter, parameters)),
        None if log is None else str(log),
        argv=tuple(argv),
        cwd=process.cwd,
        environment=process.environment,
    )


def told_description(
    part: Process | Component,
    told: Mapping[str, Any],
    blocks: Sequence[Block],
    log: Path | None,
) -> Description:
    """
    Describe what runs on another machine.

    What comes from there and makes no sense is passed over.

    :param part: It as it is known here
    :param told: The attributes of its description there
    :param blocks: The launch files, groups and timers of the plan
    :param log: The log with all of its output here, if there is one
    """
    process = part if isinstance(part, Process) else None
    component = part if isinstance(part, Component) else None
    variables = told.get('environment')
    return Description(
        part.label,
        part.ros_name,
        _text(told.get('node')) or part.node_name,
        part.package,
        str(part.position),
        _within(part.block, blocks),
        tuple(map(_parameter, part.parameters)),
        None if log is None else str(log),
        argv=tuple(map(str, _list(told.get('argv')))) if process else (),
        cwd=_text(told.get('cwd')) if process else None,
        environment=tuple(
            (str(name), _text(value))
            for name, value in (
                variables.items() if isinstance(variables, Mapping) else ()
            )
        ),
        plugin=component.plugin if component else None,
        container=component.container if component else None,
        remaps=component.remaps if component else (),
    )


def _text(told: object) -> str | None:
    return told if isinstance(told, str) else None


def _list(told: object) -> list[Any]:
    return told if isinstance(told, list) else []


def component_description(
    task: ComponentTask, blocks: Sequence[Block], log: Path | None
) -> Description:
    """
    Describe a component.

    :param blocks: The launch files, groups and timers of the plan
    :param log: The log of its container, if there is one
    """
    component = task.successor or task.component
    return Description(
        component.label,
        component.ros_name,
        task.full_name or component.node_name,
        component.package,
        str(component.position),
        _within(component.block, blocks),
        tuple(map(_parameter, component.parameters)),
        None if log is None else str(log),
        plugin=component.plugin,
        container=component.container,
        remaps=component.remaps,
    )


def _parameter(parameter: SetParameter) -> Parameter:
    return Parameter(
        parameter.name,
        parameter.value,
        str(parameter.position),
        tuple(map(str, parameter.origins)),
    )


def _within(
    index: int | None, blocks: Sequence[Block]
) -> tuple[Surrounding, ...]:
    """Return what a part of the plan stands in, the outermost first."""
    found = []
    # what a change of the plan drops may have the index of a former one
    while index is not None and index < len(blocks):
        block = blocks[index]
        position = str(block.position)
        found.append(Surrounding(block.kind, block.title, position))
        index = block.parent
    return tuple(reversed(found))
