# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Running launches and their processes, for completion."""

from collections import Counter
from collections.abc import Callable
from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path

from colcon_yamllaunch.control.client import ControlError
from colcon_yamllaunch.control.client import running_launches
from colcon_yamllaunch.control.orphaned_launches import orphaned_launches
from colcon_yamllaunch.control.process_names import ProcessNames
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.engine.state import Part
from colcon_yamllaunch.engine.state import ProcessState
from colcon_yamllaunch.engine.state import UNKNOWN
from colcon_yamllaunch.plan.plan import TRANSITIONS
from colcon_yamllaunch.plan.plan import transitions_of
from colcon_yamllaunch.verb.candidates import Candidates
from colcon_yamllaunch.verb.selecting import is_selected
from colcon_yamllaunch.verb.selecting import matches

#: Seconds that a running launch may take to answer: one that is suspended
#: must not hold up the user.
PATIENCE = 0.2


def anything(part: Part) -> bool:  # noqa: ARG001
    """Whatever has a name."""
    return True


def has_keyboard(part: Part) -> bool:
    """Tell whether keys get there."""
    return isinstance(part, ProcessState) and part.terminal


def has_lifecycle(part: Part) -> bool:
    """Tell whether it has a lifecycle node."""
    return part.lifecycle is not None


def parts(
    environment: Mapping[str, str],
    launch: str | None,
    prefix: str,
    only: Callable[[Part], bool] = anything,
) -> Candidates:
    """
    Return the names of processes and components of running launches.

    They are those of their output, shortened where that is clear; other names
    when none of those is begun.

    :param launch: Which launch is meant, as `--of` takes it
    :param prefix: What the names begin with
    :param only: Tells which of them are meant
    """
    found = [
        (state, part)
        for state in _chosen(environment, launch)
        for part in state.parts()
        if only(part)
    ]
    named = [(ProcessNames.of_state(p), p, state) for state, p in found]
    shared = Counter(names.program for names, _, _ in named)
    texts: dict[str, str] = {}
    others: dict[str, str] = {}
    for names, part, state in named:
        phase: str = part.phase
        if part.lifecycle not in (None, UNKNOWN):
            phase = f'{phase}, {part.lifecycle}'
        text = f'{phase} in {state.title}'
        best = names.label
        if best == names.name and shared[names.program] == 1:
            best = names.program
        texts[best] = text
        others |= dict.fromkeys(names, text)
    begun = any(name.startswith(prefix) for name in texts)
    return texts if begun else others


def transitions(
    environment: Mapping[str, str], launch: str | None, names: Sequence[str]
) -> Candidates:
    """
    Return the transitions that the states of lifecycle nodes have.

    :param names: The words in front: the nodes that are meant
    """
    texts: dict[str, str] = {}
    if not TRANSITIONS.keys().isdisjoint(names):
        return texts
    for state in _chosen(environment, launch):
        for part in filter(has_lifecycle, chain(*matches(state, names))):
            for name in transitions_of(part.lifecycle) or TRANSITIONS:
                texts[name] = f'{part.label} is {part.lifecycle}'
    return texts


def launches(environment: Mapping[str, str]) -> Candidates:
    """Return what the running launches are called, as `--of` takes it."""
    found = {}
    for state in _running(environment):
        name = Path(state.file).name
        found[str(state.pid)] = found[name] = state.title
        if state.package is not None:
            found[state.package] = state.title
    return found


def _chosen(
    environment: Mapping[str, str], launch: str | None
) -> list[LaunchState]:
    return [
        state
        for state in _running(environment)
        if launch is None or is_selected(state, launch)
    ]


def _running(environment: Mapping[str, str]) -> list[LaunchState]:
    states = []
    for launch in running_launches(environment, lambda _: None):
        launch.connection.settimeout(PATIENCE)
        with suppress(ControlError):
            states.append(launch.status())
        launch.close()
    for orphaned in orphaned_launches(environment):
        with suppress(ControlError):
            states.append(orphaned.status())
    return states
