# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the launcher itself says about what happens."""

from typing import Literal

from colcon_yamllaunch.runtime.core import limits
from colcon_yamllaunch.runtime.core.events import Attached
from colcon_yamllaunch.runtime.core.events import Detached
from colcon_yamllaunch.runtime.core.events import Ended
from colcon_yamllaunch.runtime.core.events import Event
from colcon_yamllaunch.runtime.core.events import Exited
from colcon_yamllaunch.runtime.core.events import Held
from colcon_yamllaunch.runtime.core.events import LeftBehind
from colcon_yamllaunch.runtime.core.events import Requested
from colcon_yamllaunch.runtime.core.events import Respawned
from colcon_yamllaunch.runtime.core.events import Said
from colcon_yamllaunch.runtime.core.events import ShuttingDown
from colcon_yamllaunch.runtime.core.events import Signalled
from colcon_yamllaunch.runtime.core.events import Started
from colcon_yamllaunch.runtime.core.events import StartFailed
from colcon_yamllaunch.runtime.core.events import StillRunning
from colcon_yamllaunch.runtime.core.events import Warned
from colcon_yamllaunch.runtime.core.outcome import ending_of
from colcon_yamllaunch.runtime.core.outcome import signal_name

Verbosity = Literal['quiet', 'normal', 'verbose']

#: The label of the launcher's own lines.
LAUNCHER = 'launch'
#: The name that messages of the launch file have, as in ROS 2.
MESSENGER = 'launch.user'


def report(event: Event) -> tuple[str, ...]:
    """Return the lines about an event; some need none."""
    match event:
        case Started():
            return (f'{event.process.label}: started, pid {event.pid}',)
        case StartFailed():
            return (
                f'{event.process.label}: could not be started: {event.reason}',
            )
        case Exited():
            return (_exited(event),)
        case Held():
            return (_held(event),)
        case Signalled(group=False):
            name = signal_name(event.signal)
            return (
                f'{event.process.label}: {name} to what it left running, '
                f'pid {event.pid}',
            )
        case Requested():
            return (f'{event.process.label}: {event.action} requested',)
        case Attached():
            where = event.hint or 'attached to another terminal'
            return (f'{event.process.label}: {where}',)
        case Detached():
            return (f'{event.process.label}: detached',)
        case ShuttingDown():
            hint = ' (Ctrl-C again to hurry)' if event.interactive else ''
            return (f'stopping: {event.reason}{hint}',)
        case StillRunning():
            return (_still_running(event),)
        case LeftBehind():
            return (
                f'{event.label}: pid {event.pid} cannot be stopped, not even '
                'by SIGKILL; it is left behind',
            )
        case Warned():
            return (f'warning: {event.text}',)
        case Ended():
            return event.summary
        case Respawned() | _:
            return ()


def is_alarming(event: Event) -> bool:
    """Tell whether an event is bad news."""
    match event:
        case Exited():
            return event.failed
        case StartFailed() | LeftBehind() | Warned():
            return True
        case Ended():
            return event.exit_code != 0
        case _:
            return False


def level(event: Event) -> str:
    """Return the severity of an event, by its name in ROS 2's launch."""
    match event:
        case Said():
            return event.level
        case Warned():
            return 'WARNING'
        case _:
            return 'ERROR' if is_alarming(event) else 'INFO'


def _exited(event: Exited) -> str:
    ending = ending_of(event.outcome, event.asked)
    text = f'{event.process.label}: {ending} after {event.seconds:.1f} s'
    if event.respawn_delay is None:
        return text
    if event.respawn_delay:
        return f'{text}, starts again in {event.respawn_delay:g} s'
    return f'{text}, starts again'


def _held(event: Held) -> str:
    if event.signal is None:
        return f'{event.process.label}: goes on'
    return (
        f'{event.process.label}: held by {signal_name(event.signal)}; '
        f'to let it go on: kill -CONT -- -{event.pid}'
    )


def _still_running(event: StillRunning) -> str:
    names = event.labels[: limits.NAMES_SHOWN]
    parts = [', '.join(names)] if names else []
    if len(event.labels) > len(names):
        parts.append(f'{len(event.labels) - len(names)} more')
    if event.timers:
        parts.append(f'{event.timers} timer' + 's' * (event.timers > 1))
    waited = ' and '.join(parts)
    if not event.labels:
        return f'waiting for {waited}'
    return f'waiting for {waited} after {signal_name(event.signal)}'
