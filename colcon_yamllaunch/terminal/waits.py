# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launch waits for, in words."""

import math
from typing import NamedTuple

from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.terminal.status_block import next_second


class Waits(NamedTuple):
    """
    What is waited for.

    :param text: That, empty if it is nothing
    :param until: When it is another text if nothing happens, None for never
    """

    text: str
    until: float | None


def waits(
    engine: Engine, conditions: ExitConditions, now: float, *, is_idle: bool
) -> Waits:
    """
    Return what a launch waits for.

    :param is_idle: Whether no process runs
    """
    parts = []
    times = []
    seen = [f"'{text}'" for text in conditions.waited_for()]
    if seen:
        parts.append(f'waits for {", ".join(seen)}')
    due = conditions.due()
    if due is not None and due > now:
        parts.append(f'{_seconds(due - now)} left')
        times.append(next_second(due, now))
    if not engine.supervisor.is_stopping:
        due = engine.supervisor.next_timer()
        if due is not None and due > now:
            parts.append(f'timer in {_seconds(due - now)}')
            times.append(next_second(due, now))
        if engine.state.watch is not None:
            if engine.state.watch_paused:
                parts.append('--watch is off')
            elif is_idle:
                parts.append('waits for a change')
    return Waits(', '.join(parts), min(times, default=None))


def _seconds(seconds: float) -> str:
    whole = math.ceil(seconds)
    if whole < 100:
        return f'{whole} s'
    minutes, whole = divmod(whole, 60)
    return f'{minutes}:{whole:02}'
