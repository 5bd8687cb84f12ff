# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Requests to running launches: status, stop, restart and the like."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import partial
import json
from pathlib import Path
import shutil
import sys
import time
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import say, say_line, show, show_json
from colcon_yamllaunch.common.suggestions import listing
from colcon_yamllaunch.control.client import (
    ControlError,
    LaunchEndedError,
    PROGRESS_INTERVAL,
)
from colcon_yamllaunch.control.resource_usage import Usage, usage_of, use_of
from colcon_yamllaunch.control.selection import (
    Candidate,
    choose_launch,
    choose_members,
    choose_processes,
    find_launches,
    hidden_services,
    is_pattern,
    matches,
    nearest_first,
)
from colcon_yamllaunch.engine import commands
from colcon_yamllaunch.engine.state import (
    ComponentState,
    LaunchState,
    MemberState,
    ProcessState,
    to_json,
)
from colcon_yamllaunch.plan.plan import TRANSITIONS, transitions_of
from colcon_yamllaunch.terminal.status_table import table
from colcon_yamllaunch.verb.options import LaunchOptions, TEXT
from colcon_yamllaunch.workspace.packages.workspace_root import (
    find_root,
    UntrustedError,
)

#: Seconds between two questions to a launch that was asked for something.
POLL_INTERVAL = 0.05
# Seconds that a debugger gets to start; debugpy on a small computer is slow.
_DEBUGGER_TIMEOUT = 30.0
_UNSETTLED = ('waiting', 'stopping', 'loading', 'unloading', 'unknown')


def control(options: LaunchOptions, environment: Mapping[str, str]) -> int:
    """
    Execute a request to running launches, and return the exit code.

    :raises UserError: when no launch or no process is meant
    """
    names, root = options.names, None
    # without access to the workspace, all launches are treated alike
    with suppress(OSError, UntrustedError):
        root = find_root(Path.cwd())
    found = find_launches(environment, options.of)
    candidates = nearest_first(found, root)
    if options.request == 'status':
        return _status(candidates, options.status or TEXT)
    ends = options.request in ('stop', 'restart')
    if ends and is_pattern(options.of) and len(candidates) > 1:
        return _end_in_all(candidates, options)
    chosen = choose_launch(candidates, names, root, ends=ends)
    try:
        if options.request == 'stop' and not names:
            _begin_to_stop(chosen)
            return _wait_for_end(chosen)
        if ends:
            return _end_in(chosen, options)
        if options.request == 'lifecycle':
            return _change_states(chosen, names, options.transition)
        if options.debug is not None:
            return _debug(chosen, names, options.debug[1])
        if options.request == 'attach':
            from colcon_yamllaunch.terminal.client_attachment import attach

            return attach(chosen, choose_members(chosen.state, names))
        if options.request == 'ui':
            from colcon_yamllaunch.terminal.full_screen.session import (
                show_launch,
            )

            return show_launch(chosen, environment)
        from colcon_yamllaunch.verb.reading_logs import show_logs

        processes = choose_processes(chosen.state, names)
        return show_logs(chosen, processes, follow=options.follow)
    except ControlError as e:
        raise UserError(f'{chosen.state.title}: {e}') from e


def _end_in(chosen: Candidate, options: LaunchOptions) -> int:
    """Stop or restart processes and components of a launch."""
    members = choose_members(chosen.state, options.names)
    labels = {member.label for member in members}
    # components go with their container
    members = [
        member
        for member in members
        if not isinstance(member, ComponentState)
        or member.process not in labels
    ]
    return _end(chosen, members, is_restart=options.request == 'restart')


def _end_in_all(
    candidates: Sequence[Candidate], options: LaunchOptions
) -> int:
    """Stop several launches, or processes of them; all begin at once."""
    if options.request == 'stop' and not options.names:
        stopping, code = _in_each(candidates, _begin_to_stop)
        return max(code, _in_each(stopping, _wait_for_end)[1])
    having = [c for c in candidates if all(matches(c.state, options.names))]
    # the first one says which name is unknown
    return _in_each(having or candidates[:1], lambda c: _end_in(c, options))[1]


def _in_each(
    candidates: Iterable[Candidate], act: Callable[[Candidate], int]
) -> tuple[list[Candidate], int]:
    """
    Call `act` for several launches, also if some of them refuse.

    Return the launches that did not refuse, and the exit code.
    """
    done, code = [], 0
    for candidate in candidates:
        try:
            code = max(code, act(candidate))
            done.append(candidate)
        except LaunchEndedError:
            continue
        except ControlError as e:
            say(f'colcon launch: error: {candidate.state.title}: {e}')
            code = 1
    return done, code


def _status(candidates: Sequence[Candidate], form: str) -> int:
    pids = (p.local_pid for c in candidates for p in c.state.processes)
    usage = usage_of({pid for pid in pids if pid is not None})
    # a launch whose launcher was killed is a failure
    code = int(any(c.is_orphaned for c in candidates))
    if form == 'json':
        launches = [_described(candidate, usage) for candidate in candidates]
        show_json(json.dumps({'launches': launches}, indent=2))
    else:
        is_terminal = sys.stdout.isatty()
        width = shutil.get_terminal_size().columns if is_terminal else None
        show(
            '\n\n'.join(
                table(c.state, usage, width, c.is_orphaned) for c in candidates
            )
        )
        for line in hidden_services():
            show(line)
    return code


def _described(
    candidate: Candidate, usage: Mapping[int, Usage]
) -> dict[str, Any]:
    described = to_json(candidate.state)
    described['orphaned'] = candidate.is_orphaned
    states = candidate.state.processes
    for process, state in zip(described['processes'], states, strict=True):
        used = use_of(state, usage)
        process['cpu'] = None if used is None else round(used.cpu, 4)
        process['memory'] = None if used is None else used.memory
    return described


def _begin_to_stop(chosen: Candidate) -> int:
    chosen.launch.do(commands.Shutdown())
    say_line(f'stopping {chosen.state.title} (pid {chosen.state.pid})')
    return 0


def _wait_for_end(chosen: Candidate) -> int:
    chosen.launch.wait_for_end(chosen.state.pid)
    say_line(f'stopped {chosen.state.title}')
    return 0


def _end(
    chosen: Candidate, members: Sequence[MemberState], *, is_restart: bool
) -> int:
    """Stop or restart processes and components; return the exit code."""
    command = commands.Restart if is_restart else commands.Stop
    waited: list[MemberState] = []
    refusals = []
    for member in members:
        try:
            chosen.launch.do(command(member.label))
            waited.append(member)
        except LaunchEndedError:
            raise
        except ControlError as e:
            refusals.append(e)
    if refusals and not waited:
        raise refusals[0]
    # of many that a pattern means, some may be as they should be
    for refusal in refusals:
        say_line(f'{chosen.state.title}: {refusal}')
    code = 1 if refusals else 0
    if is_restart:
        # containers load their components again
        waited += [
            component
            for member in waited
            for component in chosen.state.components_of(member.label)
            if component.phase != 'unloaded'
        ]
    for member in waited:
        text, is_done = _outcome(_wait_for(chosen, member), is_restart)
        code = code if is_done else 1
        say_line(f'{member.label}: {text}')
    return code


def _outcome(now: MemberState | None, is_restart: bool) -> tuple[str, bool]:
    """Return how a request ended, and whether it succeeded."""
    if now is None:
        return 'the launch has ended', not is_restart
    if isinstance(now, ProcessState):
        if is_restart and now.pid is not None:
            return f'started anew, pid {now.pid}', True
        return now.ending, not is_restart
    if now.phase == 'failed':
        return f'could not be loaded: {now.ending}', False
    if now.phase == 'waiting':
        return f'waits for the container {now.container}', False
    if now.phase == 'unloaded':
        return 'unloaded', not is_restart
    if is_restart and not now.ending:
        return f'loaded anew into {now.process or now.container}', True
    return now.ending or now.phase, False


def _wait_for(chosen: Candidate, member: MemberState) -> MemberState | None:
    """Wait until a member is settled; return None if the launch has ended."""
    asked = time.monotonic()
    is_announced = False
    while True:
        try:
            state = chosen.launch.refresh()
        except LaunchEndedError:
            return None
        is_long = time.monotonic() - asked > PROGRESS_INTERVAL
        for now in state.members():
            # nobody knows when a container of others comes
            is_stuck = (
                isinstance(now, ComponentState)
                and now.phase == 'waiting'
                and now.process is None
                and is_long
            )
            is_settled = is_stuck or now.phase not in _UNSETTLED
            if now.label == member.label and is_settled:
                return now
        if is_long and not is_announced:
            is_announced = True
            say_line(f'waiting for {member.label}')
        time.sleep(POLL_INTERVAL)


def _debug(chosen: Candidate, names: Sequence[str], port: int) -> int:
    """Restart a process under a debugger that waits for a connection."""
    # few requests need it
    from colcon_yamllaunch.engine.debugging import HOST

    members = choose_members(chosen.state, names)
    if len(members) != 1:
        found = listing(p.label for p in members)
        raise UserError(f'--debug takes one process, not {found}')
    process = members[0]
    chosen.launch.do(commands.Debug(process.label, port))
    now = _wait_for(chosen, process)
    # an editor that connects too early gives up
    deadline = time.monotonic() + _DEBUGGER_TIMEOUT
    while process.machine is None and not _is_listening(port):
        is_running = isinstance(now, ProcessState) and now.pid is not None
        if not is_running or time.monotonic() > deadline:
            say_line(f'{process.label}: {_outcome(now, True)[0]}')
            return 1
        time.sleep(POLL_INTERVAL)
        now = _wait_for(chosen, process)
    where = '' if process.machine is None else f' on {process.machine}'
    say_line(f'{process.label}: waits for a debugger at {HOST}:{port}{where}')
    return 0


def _is_listening(port: int) -> bool:
    """Return whether a program of this computer accepts connections."""
    sockets = Path('/proc/net/tcp').read_text().splitlines()[1:]
    fields = (line.split() for line in sockets)
    return any(f[1].endswith(f':{port:04X}') and f[3] == '0A' for f in fields)


def _change_states(
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
    launch, code = chosen.launch, 0
    nodes = choose_members(chosen.state, names)
    # an orphaned launch has no lifecycle states, and refuses with a reason
    if not chosen.is_orphaned:
        _refuse_other_nodes(chosen.state, names)
        nodes = [member for member in nodes if member.lifecycle is not None]
    for label in [node.label for node in nodes]:
        try:
            launch.do(
                commands.ChangeState(label, transition),  # type: ignore[arg-type]
                waiting=partial(say_line, f'waiting for {label}'),
            )
        except LaunchEndedError:
            raise
        except ControlError as e:
            code = 1
            states = {p.label: p.lifecycle for p in launch.refresh().members()}
            possible = transitions_of(states.get(label))
            text = f'{transition} failed: {e}'
            if possible and transition not in possible:
                text += f'; it could {" or ".join(possible)}'
        else:
            text = TRANSITIONS[transition].goal
        say_line(f'{label}: {text}')
    return code


def _refuse_other_nodes(state: LaunchState, names: Sequence[str]) -> None:
    """Refuse names that match only members without a lifecycle."""
    for found in matches(state, names):
        if found and all(p.lifecycle is None for p in found):
            known = [p for p in state.members() if p.lifecycle is not None]
            raise UserError(
                f'{listing(p.label for p in found)} of {state.title} is no '
                'lifecycle_node or composable_lifecycle_node; there is '
                f'{listing(p.label for p in known) or "none"}'
            )
