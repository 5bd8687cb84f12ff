# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Running launches and their processes, for completion."""

from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path

from colcon_yamllaunch.control.client import answering_launches, ControlError
from colcon_yamllaunch.control.orphaned_launches import orphaned_launches
from colcon_yamllaunch.control.process_names import ProcessNames
from colcon_yamllaunch.control.selection import is_selected, matches
from colcon_yamllaunch.engine.state import LaunchState, ProcessState, UNKNOWN
from colcon_yamllaunch.plan.plan import TRANSITIONS, transitions_of
from colcon_yamllaunch.verb.completing import Candidates, Cursor
from colcon_yamllaunch.verb.options import Completer


def candidates_of(
    cursor: Cursor, completer: Completer, words: Sequence[str] = ()
) -> Candidates:
    """
    Return running launches, or processes and components of these.

    :param completer: Which of them: `launches`, `members`, `processes`,
      `terminals` or `lifecycles`; with the latter, transitions follow the
      names of nodes
    :param words: The words in front that belong to no option
    """
    states = _running(cursor.environment)
    if completer == 'launches':
        return _launches(states)
    if selector := cursor.given('of'):
        states = [s for s in states if is_selected(s, selector)]
    names = (*(cursor.given('lifecycle') or ()), *words)
    if completer == 'lifecycles' and names:
        return _transitions(states, names)
    return _members(states, cursor.prefix, completer)


def _members(
    states: Sequence[LaunchState], prefix: str, completer: Completer
) -> Candidates:
    """
    Return the names of processes and components.

    They are those of their output, shortened where that is clear; other names
    when none of those is begun.

    :param prefix: What the names begin with
    :param completer: With `processes`, no components; with `terminals`, only
      processes that keys can be typed at; with `lifecycles`, only lifecycle
      nodes
    """
    named = [
        (ProcessNames.of_state(member), member, state)
        for state in states
        for member in state.members()
        if completer == 'members'
        or (completer == 'lifecycles' and member.lifecycle is not None)
        or (
            isinstance(member, ProcessState)
            and (
                completer == 'processes'
                or (completer == 'terminals' and member.terminal)
            )
        )
    ]
    shared = Counter(names.program for names, _, _ in named)
    texts: dict[str, str] = {}
    others: dict[str, str] = {}
    for names, member, state in named:
        phase: str = member.phase
        if member.lifecycle not in (None, UNKNOWN):
            phase = f'{phase}, {member.lifecycle}'
        text = f'{phase} in {state.title}'
        best = names.label
        if best == names.name and shared[names.program] == 1:
            best = names.program
        texts[best] = text
        others |= dict.fromkeys(names, text)
    begun = any(name.startswith(prefix) for name in texts)
    return texts if begun else others


def _transitions(
    states: Sequence[LaunchState], names: Sequence[str]
) -> Candidates:
    """Return the transitions that the states of some nodes have."""
    texts: dict[str, str] = {}
    if not TRANSITIONS.keys().isdisjoint(names):
        return texts
    for state in states:
        for member in chain(*matches(state, names)):
            if member.lifecycle is not None:
                for name in transitions_of(member.lifecycle) or TRANSITIONS:
                    texts[name] = f'{member.label} is {member.lifecycle}'
    return texts


def _launches(states: Sequence[LaunchState]) -> Candidates:
    """Return what launches are called, as `--of` takes it."""
    found = {}
    for state in states:
        name = Path(state.file).name
        found[str(state.pid)] = found[name] = state.title
        if state.package is not None:
            found[state.package] = state.title
    return found


def _running(environment: Mapping[str, str]) -> list[LaunchState]:
    states = list(answering_launches(environment))
    for orphaned in orphaned_launches(environment):
        with suppress(ControlError):
            states.append(orphaned.refresh())
    return states
