# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Select running launches, and their processes and components."""

from collections.abc import Iterable, Mapping, Sequence
from fnmatch import fnmatchcase
import os
from pathlib import Path

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.messages import say
from colcon_yamllaunch.common.process_scan import need_proc
from colcon_yamllaunch.common.suggestions import did_you_mean, listing
from colcon_yamllaunch.control import client
from colcon_yamllaunch.control.orphaned_launches import (
    orphaned_launches,
    OrphanedLaunch,
)
from colcon_yamllaunch.control.process_names import meant_by, ProcessNames
from colcon_yamllaunch.control.socket_folder import services_of_others
from colcon_yamllaunch.engine.state import (
    LaunchState,
    MemberState,
    ProcessState,
)


@dataclass(frozen=True, slots=True)
class Candidate:
    """
    A running launch, or what is left of one.

    :param launch: The connection to it, or what stands for that
    :param state: Its state when it was found
    """

    launch: client.RunningLaunch | OrphanedLaunch
    state: LaunchState

    @property
    def is_orphaned(self) -> bool:
        """Whether its launcher was killed."""
        return isinstance(self.launch, OrphanedLaunch)


def find_launches(
    environment: Mapping[str, str], selector: str | None
) -> list[Candidate]:
    """
    Return the running launches that may be meant.

    :param selector: A package, launch file, title or process id, or a
      pattern with `*`, `?` and `[…]` for one; or None
    :raises UserError: when there is none
    """
    need_proc()
    launches: list[client.RunningLaunch | OrphanedLaunch] = [
        *client.running_launches(environment, _warn),
        *orphaned_launches(environment),
    ]
    candidates = []
    silent = 0
    for launch in launches:
        try:
            candidates.append(Candidate(launch, launch.refresh()))
        except client.LaunchEndedError:
            # it was just about to end
            continue
        except client.ControlError as e:
            # others can be looked at all the same
            _warn(str(e))
            silent += 1
    if not candidates:
        nothing = 'no launch answers' if silent else 'no launch is running'
        raise UserError(nothing, '\n'.join(hidden_services()) or None)
    if selector is None:
        return candidates
    chosen = [c for c in candidates if is_selected(c.state, selector)]
    if not chosen:
        raise UserError(
            f"no running launch is '{selector}'; there is "
            f'{_launches(candidates)}'
        )
    return chosen


def hidden_services() -> list[str]:
    """Return a line about each running service that others may not see."""
    return [
        f'the service {name} of {_user_name(user)} runs, too: '
        'sudo colcon launch --status shows it'
        for name, user in services_of_others().items()
    ]


def _user_name(number: int) -> str:
    # few computers have such services
    import pwd

    try:
        return pwd.getpwuid(number).pw_name
    except KeyError:
        return f'user {number}'


def nearest_first(
    candidates: Iterable[Candidate], root: Path | None
) -> list[Candidate]:
    """Return launches, those of a workspace before all others."""
    return sorted(candidates, key=lambda c: not is_of(c.state, root))


def is_of(state: LaunchState, root: Path | None) -> bool:
    """Return whether a launch belongs to a workspace, by file or folder."""
    return root is not None and any(
        Path(os.path.realpath(path)).is_relative_to(root)
        for path in (state.file, state.folder)
        if path
    )


def choose_launch(
    candidates: Sequence[Candidate],
    names: Sequence[str],
    root: Path | None = None,
    *,
    ends: bool = False,
) -> Candidate:
    """
    Return the one launch that is meant.

    :param names: The processes and components that are meant, by name or glob
    :param root: The workspace whose launches are meant before all others
    :param ends: Whether it is to be ended, which may be done to all at once
    :raises UserError: when it is not clear
    """
    if len(candidates) == 1:
        return candidates[0]
    fitting = [c for c in candidates if names and all(matches(c.state, names))]
    which = fitting or candidates
    which = [c for c in which if is_of(c.state, root)] or which
    if len(which) == 1:
        return which[0]
    every = ", or --of '*' to stop all" if ends else ''
    raise UserError(
        'more than one launch is running: choose by --of LAUNCH, such as '
        f'--of {which[0].state.pid}{every}; there is {_launches(which)}'
    )


def is_pattern(selector: str | None) -> bool:
    """Return whether `selector` (of `--of`) may mean several launches."""
    return selector is not None and not set('*?[').isdisjoint(selector)


def choose_members(
    state: LaunchState, names: Sequence[str]
) -> list[MemberState]:
    """
    Return the processes and components that are meant, in the plan's order.

    :param names: Names or globs; none means all
    :raises UserError: when a name means nothing
    """
    members = list(state.members())
    if not names:
        return members
    meant: set[str] = set()
    for name, found in zip(names, matches(state, names), strict=True):
        meant.update(p.label for p in found)
        if not found:
            known = [n for p in members for n in ProcessNames.of_state(p)]
            labels = listing(p.label for p in members)
            hint = did_you_mean(name, known) or f'there is {labels or "none"}'
            others = ' or component' if state.components else ''
            raise UserError(
                f"{state.title} has no process{others} '{name}': {hint}"
            )
    return [p for p in members if p.label in meant]


def choose_processes(
    state: LaunchState, names: Sequence[str]
) -> list[ProcessState]:
    """
    Return the processes that are meant; a component means its container.

    :param names: As for :func:`choose_members`
    :raises UserError: when a name means nothing, or no process of the launch
    """
    meant = set()
    for member in choose_members(state, names):
        if isinstance(member, ProcessState):
            meant.add(member.label)
        elif member.process is not None:
            meant.add(member.process)
        elif names:
            raise UserError(
                f'{member.label} is in {member.container}, which is no '
                f'container of {state.title}'
            )
    return [p for p in state.processes if p.label in meant]


def matches(
    state: LaunchState, names: Iterable[str]
) -> list[list[MemberState]]:
    """Return for each name the processes and components that it means."""
    members = list(state.members())
    known = [ProcessNames.of_state(p) for p in members]
    return [
        [members[index] for index in meant_by(name, known)] for name in names
    ]


def is_selected(state: LaunchState, selector: str) -> bool:
    """Return whether `selector` (of `--of`) means a launch."""
    file = Path(state.file)
    names = (
        state.title,
        state.package or '',
        state.file,
        file.name,
        file.stem,
        str(state.pid),
    )
    return (
        selector in names
        or str(Path(selector).absolute()) == state.file
        or any(fnmatchcase(name, selector) for name in names)
    )


def _launches(candidates: Iterable[Candidate]) -> str:
    return '; '.join(
        f'{c.state.title} (pid {c.state.pid})' for c in candidates
    )


def _warn(text: str) -> None:
    say(f'colcon launch: warning: {text}')
