# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What `colcon launch` does about launches that run already."""

from collections.abc import Mapping
from collections.abc import Sequence
from dataclasses import asdict
import json
import shutil
import sys
import time
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.runtime.control.client import ControlError
from colcon_yamllaunch.runtime.control.client import LaunchEndedError
from colcon_yamllaunch.runtime.control.launch_states import ProcessState
from colcon_yamllaunch.runtime.control.resource_usage import Usage
from colcon_yamllaunch.runtime.control.resource_usage import usage_of
from colcon_yamllaunch.verb.cli.launch_options import ControlOptions
from colcon_yamllaunch.verb.cli.messages import say_line
from colcon_yamllaunch.verb.cli.messages import show
from colcon_yamllaunch.verb.cli.messages import show_json
from colcon_yamllaunch.verb.sessions.selecting import Candidate
from colcon_yamllaunch.verb.sessions.selecting import choose_launch
from colcon_yamllaunch.verb.sessions.selecting import choose_processes
from colcon_yamllaunch.verb.sessions.selecting import find_launches
from colcon_yamllaunch.verb.sessions.status_table import table

#: Seconds between two questions to a launch that was asked for something.
POLL_INTERVAL = 0.05
#: Seconds after which it is said what is waited for.
PROGRESS_INTERVAL = 1.0


def control(options: ControlOptions, environment: Mapping[str, str]) -> int:
    """
    Do what was asked, and return the exit code.

    :raises UserError: when no launch or no process is meant
    """
    candidates = find_launches(environment, options.launch)
    if options.action == 'status':
        return _status(candidates, options.status_format)
    chosen = choose_launch(candidates, options.names)
    try:
        if options.action == 'stop' and not options.names:
            return _stop_launch(chosen)
        processes = choose_processes(chosen.state, options.names)
        if options.action in ('stop', 'restart'):
            return _end(chosen, processes, options.action)
        if options.action == 'attach':
            from colcon_yamllaunch.verb.sessions.attaching import attach

            return attach(chosen, processes)
        from colcon_yamllaunch.verb.sessions.reading_logs import show_logs

        return show_logs(chosen, processes, follow=options.follow)
    except ControlError as e:
        raise UserError(f'{chosen.state.title}: {e}') from e


def _status(candidates: Sequence[Candidate], form: str) -> int:
    states = [c.state for c in candidates]
    usage = usage_of(
        {p.pid for s in states for p in s.processes if p.pid is not None}
    )
    # what runs without a launcher is nothing that is as it should be
    code = int(any(c.is_orphaned for c in candidates))
    if form == 'json':
        launches = [_described(candidate, usage) for candidate in candidates]
        show_json(json.dumps({'launches': launches}, indent=2))
        return code
    width = None
    if sys.stdout.isatty():
        width = shutil.get_terminal_size().columns
    tables = [table(c.state, usage, width, c.is_orphaned) for c in candidates]
    show('\n\n'.join(tables))
    return code


def _described(
    candidate: Candidate, usage: Mapping[int, Usage]
) -> dict[str, Any]:
    described = asdict(candidate.state)
    described['orphaned'] = candidate.is_orphaned
    for process in described['processes']:
        used = usage.get(process['pid'])
        process['cpu'] = None if used is None else round(used.cpu, 4)
        process['memory'] = None if used is None else used.memory
    return described


def _stop_launch(chosen: Candidate) -> int:
    state = chosen.state
    chosen.launch.request('shutdown')
    say_line(f'stopping {state.title} (pid {state.pid})')
    chosen.launch.wait_for_end(state.pid)
    say_line(f'stopped {state.title}')
    return 0


def _end(
    chosen: Candidate, processes: Sequence[ProcessState], action: str
) -> int:
    """Stop processes, or start them anew."""
    for process in processes:
        chosen.launch.request(action, process=process.label)
    failed = False
    for process in processes:
        now = _wait_for(chosen, process)
        ending = 'the launch has ended' if now is None else now.ending
        if action == 'restart':
            if now is not None and now.pid is not None:
                ending = f'started anew, pid {now.pid}'
            else:
                failed = True
        say_line(f'{process.label}: {ending}')
    return int(failed)


def _wait_for(chosen: Candidate, process: ProcessState) -> ProcessState | None:
    """Wait until a process is stopped; None when the launch has ended."""
    asked = time.monotonic()
    is_told = False
    while True:
        try:
            state = chosen.launch.status()
        except LaunchEndedError:
            return None
        for now in state.processes:
            if now.label == process.label and now.phase != 'stopping':
                return now
        if not is_told and time.monotonic() - asked > PROGRESS_INTERVAL:
            is_told = True
            say_line(f'waiting for {process.label}')
        time.sleep(POLL_INTERVAL)
