# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""States of launches, their processes and components."""

from collections.abc import Callable
import time
from typing import Any

from colcon_yamllaunch.engine.state import (
    _condition_of,
    About,
    ComponentState,
    LaunchState,
    MemberState,
    ProcessState,
)
from colcon_yamllaunch.plan.plan import Entry

ABOUT = About('my_pkg demo.yaml', 'my_pkg', '/ws/demo.yaml', '/ws')


def process_state(label: str, **more: Any) -> ProcessState:
    """Return a process that runs, unless told otherwise."""
    known = {'phase': 'running', 'executable': label, 'is_due': False}
    state = ProcessState(label, **{**known, **more})
    state.condition = more.get('condition', _condition_of(state))
    return state


def component_state(
    label: str, process: str | None = 'box-1', **more: Any
) -> ComponentState:
    """Return a component that is loaded, unless told otherwise."""
    known = {
        'phase': 'loaded',
        'plugin': 'demo::Talker',
        'node': f'/{label}',
        'package': 'demo',
        'container': '/box',
        'process': process,
        'is_due': False,
    }
    state = ComponentState(label, **{**known, **more})
    state.condition = more.get('condition', _condition_of(state))
    return state


def planned_state(*entries: Entry, now: float = 100.0) -> LaunchState:
    """Return a launch of which nothing has been started yet."""
    state = LaunchState(ABOUT, clock=lambda: now)
    state.expect(entries)
    return state


def launch_state(
    *members: MemberState,
    about: About = ABOUT,
    seconds: float = 9.0,
    clock: Callable[[], float] = time.monotonic,
    stopping: bool = False,
    **more: Any,
) -> LaunchState:
    """Return a launch of processes and components."""
    now = clock()
    for member in members:
        member.since = now - member.seconds
    return LaunchState(
        about,
        **{'pid': 4242, **more},
        started=now - seconds,
        clock=clock,
        stop_reason='requested' if stopping else '',
        by_label={member.label: member for member in members},
        log_files={p.label: p.log for p in members if p.log is not None},
    )
