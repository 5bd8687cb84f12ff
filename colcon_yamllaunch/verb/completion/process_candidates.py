# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Running launches and their processes, for completion."""

from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from colcon_yamllaunch.runtime.control.client import ControlError
from colcon_yamllaunch.runtime.control.client import running_launches
from colcon_yamllaunch.runtime.control.launch_states import LaunchState
from colcon_yamllaunch.runtime.control.orphaned_launches import (
    orphaned_launches,
)
from colcon_yamllaunch.runtime.control.process_names import ProcessNames
from colcon_yamllaunch.verb.completion.candidates import Candidates
from colcon_yamllaunch.verb.sessions.selecting import is_selected

#: Seconds that a running launch may take to answer: one that is suspended
#: must not hold up the user.
PATIENCE = 0.2


def processes(
    environment: Mapping[str, str],
    launch: str | None,
    prefix: str,
    *,
    only_terminals: bool = False,
) -> Candidates:
    """
    Return the names of the processes of running launches.

    They are those of their output, shortened where that is clear; other names
    when none of those is begun.

    :param launch: Which launch is meant, as `--of` takes it
    :param prefix: What the names begin with
    :param only_terminals: Whether keys must be able to get there
    """
    found = [
        (state, process)
        for state in _running(environment)
        if launch is None or is_selected(state, launch)
        for process in state.processes
        if process.terminal or not only_terminals
    ]
    named = [(ProcessNames.of_state(p), p, state) for state, p in found]
    shared = Counter(names.program for names, _, _ in named)
    texts: dict[str, str] = {}
    others: dict[str, str] = {}
    for names, process, state in named:
        text = f'{process.phase} in {state.title}'
        best = names.label
        if best == names.name and shared[names.program] == 1:
            best = names.program
        texts[best] = text
        others |= dict.fromkeys(names, text)
    begun = any(name.startswith(prefix) for name in texts)
    return texts if begun else others


def launches(environment: Mapping[str, str]) -> Candidates:
    """Return what the running launches are called, as `--of` takes it."""
    found = {}
    for state in _running(environment):
        name = Path(state.file).name
        found[str(state.pid)] = found[name] = state.title
        if state.package is not None:
            found[state.package] = state.title
    return found


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
