# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Changing the states of lifecycle nodes."""

from collections.abc import Sequence

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.suggestions import listing
from colcon_yamllaunch.control.client import ControlError
from colcon_yamllaunch.control.client import LaunchEndedError
from colcon_yamllaunch.engine.commands import ChangeState
from colcon_yamllaunch.engine.components.transitions import TRANSITIONS
from colcon_yamllaunch.engine.components.transitions import transitions_of
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.engine.state import Part
from colcon_yamllaunch.verb.cli.messages import say_line
from colcon_yamllaunch.verb.sessions.selecting import Candidate
from colcon_yamllaunch.verb.sessions.selecting import choose_parts
from colcon_yamllaunch.verb.sessions.selecting import matches


def change_states(
    chosen: Candidate, names: Sequence[str], transition: str
) -> int:
    """
    Change the states of lifecycle nodes, one after the other.

    Return the exit code.

    :param names: The nodes, by name or glob
    :param transition: One of `TRANSITIONS`
    :raises UserError: when a name means no lifecycle node
    :raises ControlError: when the launch ended
    """
    # what a launch leaves that was killed has no states, and says so
    choose = choose_parts if chosen.is_orphaned else choose_lifecycle_nodes
    failed = False
    for node in choose(chosen.state, names):
        reason = _change(chosen, node.label, transition)
        if reason is None:
            text = TRANSITIONS[transition].goal
        else:
            failed = True
            text = f'{transition} failed: {reason}'
        say_line(f'{node.label}: {text}')
    return int(failed)


def choose_lifecycle_nodes(
    state: LaunchState, names: Sequence[str]
) -> list[Part]:
    """
    Return the processes and components whose nodes have a lifecycle.

    :param names: As for :func:`choose_parts`
    :raises UserError: when a name means none
    """
    known = [p for p in state.parts() if p.lifecycle is not None]
    for found in matches(state, names):
        if found and all(p.lifecycle is None for p in found):
            raise UserError(
                f'{listing(p.label for p in found)} of {state.title} is no '
                'lifecycle_node or composable_lifecycle_node; there is '
                f'{listing(p.label for p in known) or "none"}'
            )
    return [p for p in choose_parts(state, names) if p.lifecycle is not None]


def _change(chosen: Candidate, label: str, transition: str) -> str | None:
    """Change the state of a node; return why that failed, if it did."""
    try:
        chosen.launch.do(
            ChangeState(label, transition),  # type: ignore[arg-type]
            waiting=lambda: say_line(f'waiting for {label}'),
        )
    except LaunchEndedError:
        raise
    except ControlError as e:
        states = {p.label: p.lifecycle for p in chosen.launch.status().parts()}
        possible = transitions_of(states.get(label))
        if not possible or transition in possible:
            return str(e)
        return f'{e}; it could {" or ".join(possible)}'
    return None
