# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Nodes that a launch would start and that run already.

Two nodes of one name in one domain disturb each other: both are asked, both
publish, and nobody can distinguish them. Mostly somebody has launched
the same file twice.
"""

from collections.abc import Iterable, Mapping
import os

from colcon_yamllaunch.common.process_scan import arguments_of, variable_of
from colcon_yamllaunch.common.suggestions import enumeration
from colcon_yamllaunch.engine.state import LaunchState, ProcessState
from colcon_yamllaunch.plan.plan import Plan, Process

#: How many nodes are named.
_SHOWN = 3

_DOMAIN = 'ROS_DOMAIN_ID'
_NAMESPACE = '__ns:='


def doubled_nodes(
    plan: Plan, environment: Mapping[str, str], file: str, other: LaunchState
) -> list[str]:
    """
    Return the nodes of a plan that another launch runs already.

    They are those of the same full name and domain. One that gives itself its
    name is taken for that of the same program where the launch file and the
    namespace are the same.

    :param environment: The environment of the processes of the plan
    :param file: The launch file
    """
    if other.stopping:
        return []
    found: dict[str, None] = {}
    for process in plan.processes():
        own = {**environment, **dict(process.environment)}
        domain = own.get(_DOMAIN) or '0'
        if any(
            state.phase != 'ended'
            and _is_same_node(process, state, file == other.file)
            and _domain_of(state, other) == domain
            for state in other.processes
        ):
            found[process.node_name or process.label] = None
    return list(found)


def warning(nodes: Iterable[str], other: LaunchState) -> str:
    """Return the warning that nodes run already, with the way out."""
    names = list(nodes)
    verb = 'runs' if len(names) == 1 else 'run'
    if len(names) > _SHOWN:
        names[_SHOWN:] = [f'{len(names) - _SHOWN} more']
    return (
        f'{other.title} runs already (pid {other.pid}), so '
        f'{enumeration(names)} {verb} '
        f'twice: end that launch by colcon launch --stop --of {other.pid}, '
        f'or give one of both another {_DOMAIN}'
    )


def _is_same_node(
    process: Process, state: ProcessState, is_same_file: bool
) -> bool:
    if process.node_name is not None:
        return process.node_name == state.node
    pid = state.local_pid
    # a program that belongs to no package is no node
    return (
        is_same_file
        and process.package is not None
        and process.package == state.package
        and os.path.basename(str(process.argv[0])) == state.executable
        and _namespaces(process.argv)
        == _namespaces(() if pid is None else arguments_of(pid))
    )


def _namespaces(arguments: Iterable[object]) -> list[str]:
    words = (a for a in arguments if isinstance(a, str))
    return [word for word in words if word.startswith(_NAMESPACE)]


def _domain_of(state: ProcessState, launch: LaunchState) -> str:
    # one that is not started yet is going to have that of the launcher
    pid = launch.pid if state.local_pid is None else state.local_pid
    return variable_of(pid, _DOMAIN) or '0'
