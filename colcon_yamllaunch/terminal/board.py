# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the status block tells of a launch, as plain data."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.outcome import signal_name
from colcon_yamllaunch.engine.outcome import STOP_SIGNALS
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import Entry
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.plan import Timer

#: The keys that choose a process, in the order in which they are given out:
#: those that mean something for all processes are left out.
KEYS = '1234567890abcdefghijklmnoprsuvxyzABCDFGHIJKNOPQRSTUVWXYZ'
#: The share of a processor from which on it is told.
MUCH_CPU = 0.5

#: `waiting` for a timer, `starting`, that is waiting for its turn or being
#: loaded or activated, `running`, `stopping`, `held` as by Ctrl-Z, waiting for
#: its `respawn`, `ended` as it should, `stopped` on request, or `failed`.
Phase = Literal[
    'waiting',
    'starting',
    'running',
    'stopping',
    'held',
    'respawn',
    'ended',
    'stopped',
    'failed',
]
_UP = ('starting', 'running', 'held')
#: States in which lifecycle nodes are on their way (lifecycle_msgs/State).
BETWEEN_STATES = ('configuring', 'activating')


@dataclass(slots=True, eq=False)
class Row:
    """
    A process, or a component, in the status block.

    :param key: The key that chooses it, empty if there are not enough
    :param is_process: Whether it is a process, and no component
    :param group: Its process group while it runs, else 0
    :param starts: How often it has been started, or loaded
    :param failure: How it failed last, in short; empty if it has not since
      somebody started it
    :param turn: A number that is higher the later its phase changed, 0 until
      it has been up once
    :param cpu: The share of one processor that it takes, 1.0 for all of it;
      0.0 where that is not much
    :param lifecycle: The state of its lifecycle node, empty if it has none
    """

    label: str
    key: str = ''
    is_process: bool = True
    phase: Phase = 'starting'
    group: int = 0
    starts: int = 0
    failure: str = ''
    turn: int = 0
    cpu: float = 0.0
    lifecycle: str = ''


@dataclass(slots=True, eq=False)
class Countdown:
    """
    What stopping waits for.

    :param event: That, as it was told
    :param due: When the next signal is sent, by the clock of the board
    """

    event: events.StillRunning
    due: float


class Board:
    """
    Listens to what happens, and keeps what the status block tells of it.

    :param entries: Those of the plan
    :param clock: Returns seconds that never go back
    """

    def __init__(
        self, entries: Iterable[Entry], clock: Callable[[], float]
    ) -> None:
        self._clock = clock
        self._rows: dict[str, Row] = {}
        self._by_key: dict[str, str] = {}
        #: Grows by one whenever something of all this changes.
        self.version = 0
        #: Why all is being stopped; empty if it is not.
        self.stopping = ''
        self.countdown: Countdown | None = None
        #: What came of the last change of files, or what is done about it.
        self.watched: events.Watched | events.Checked | None = None
        #: What the last build or evaluation that failed has said, below what
        #: came of it; empty if none has.
        self.errors: tuple[str, ...] = ()
        #: When files were changed that something is done about, by the clock;
        #: None if all is done.
        self.changed: float | None = None
        for entry in entries:
            self._expect(entry, 'starting')

    @property
    def rows(self) -> tuple[Row, ...]:
        """The processes and components, in the order of the plan."""
        return tuple(self._rows.values())

    def row(self, label: str) -> Row | None:
        """Return what has a label."""
        return self._rows.get(label)

    def label_of(self, key: str) -> str | None:
        """Return the label of what a key chooses."""
        return self._by_key.get(key)

    def groups(self) -> Mapping[str, int]:
        """Return the process groups that run, by label."""
        return {r.label: r.group for r in self.rows if r.group}

    def handle(self, event: events.Event) -> None:
        """Listen to an event."""
        match event:
            case events.Planned():
                for part in event.parts:
                    if part.label not in self._rows:
                        self._expect(part, 'starting')
            case events.Dropped():
                gone = self._rows.pop(event.process.label, None)
                if gone is not None:
                    self._by_key.pop(gone.key, None)
            case events.ShuttingDown():
                self.stopping = event.reason
                for row in self.rows:
                    if row.phase == 'respawn' or not row.starts:
                        row.phase = 'ended' if row.starts else 'waiting'
                    elif row.phase in _UP:
                        row.phase = 'stopping'
            case events.StillRunning():
                due = self._clock() + event.seconds
                self.countdown = Countdown(event, due)
            case events.Changed():
                self.changed = self._clock()
            case events.Watched(is_paused=bool()):
                # what came of the last change is still that
                pass
            case events.Watched() | events.Checked():
                self.watched = event
                if isinstance(event, events.Watched):
                    self.errors = event.errors or self.errors
                if is_settled(event):
                    self.changed = None
            case events.Loaded() | events.LoadFailed() | events.Unloaded():
                self._take_component(event)
            case _:
                if not self._take(event):
                    return
        self.version += 1

    def take_cpu(self, shares: Mapping[str, float]) -> None:
        """Take what processes take of a processor, by label."""
        for row in self.rows:
            cpu = shares.get(row.label, 0.0)
            # whole per cents, so that not every look is a change
            cpu = round(cpu, 2) if cpu >= MUCH_CPU else 0.0
            if cpu != row.cpu:
                row.cpu = cpu
                self.version += 1

    def _expect(self, entry: Entry, phase: Phase) -> None:
        match entry:
            case Timer():
                for one in entry.entries:
                    self._expect(one, 'waiting')
            case Process() | Component():
                key = next((k for k in KEYS if k not in self._by_key), '')
                if key:
                    self._by_key[key] = entry.label
                is_process = isinstance(entry, Process)
                self._rows[entry.label] = Row(
                    entry.label, key, is_process, phase
                )
            case _:
                return

    def _take(self, event: events.Event) -> bool:
        """Take what happened to one process; return whether it matters."""
        process = getattr(event, 'process', None)
        row = None if process is None else self._rows.get(process.label)
        if row is None:
            return False
        match event:
            case events.Started():
                row.starts += 1
                row.group = event.pid
                row.lifecycle = ''
                self._turn(row, 'running', is_first=row.starts == 1)
            case events.StartFailed():
                row.failure = 'cannot start'
                again = event.respawn_delay is not None
                self._turn(row, 'respawn' if again else 'failed')
            case events.Exited():
                self._take_end(row, event)
            case events.Requested():
                ends = event.action in ('stop', 'kill')
                # what has failed is not another thing by being stopped
                if not (ends and row.is_process and row.phase == 'failed'):
                    row.failure = ''
                if row.phase in _UP:
                    self._turn(row, 'stopping')
                elif event.action in ('restart', 'debug'):
                    self._turn(row, 'starting')
                elif row.phase == 'respawn':
                    self._turn(row, 'stopped')
            case events.Signalled():
                if event.signal not in STOP_SIGNALS or row.phase not in _UP:
                    return False
                self._turn(row, 'stopping')
            case events.Suspended():
                if row.phase not in _UP:
                    return False
                self._turn(row, 'running' if event.signal is None else 'held')
            case events.StateChanged():
                row.lifecycle = event.state
            case events.TransitionFailed():
                row.failure = event.transition
            case _:
                return False
        return True

    def _take_end(self, row: Row, event: events.Exited) -> None:
        row.group = 0
        row.cpu = 0.0
        row.lifecycle = ''
        if event.failed:
            row.failure = _in_short(event.outcome)
        if event.respawn_delay is not None:
            self._turn(row, 'respawn')
        elif event.failed:
            self._turn(row, 'failed')
        else:
            is_stopped = event.asked or row.phase == 'stopping'
            self._turn(row, 'stopped' if is_stopped else 'ended')

    def _take_component(
        self, event: events.Loaded | events.LoadFailed | events.Unloaded
    ) -> None:
        row = self._rows.get(event.component.label)
        if row is None:
            return
        match event:
            case events.Loaded():
                row.starts += 1
                self._turn(row, 'running', is_first=row.starts == 1)
            case events.LoadFailed():
                row.failure = 'cannot load'
                self._turn(row, 'respawn' if event.again else 'failed')
            case events.Unloaded():
                is_stopped = event.reason == events.REQUESTED
                self._turn(row, 'stopped' if is_stopped else 'ended')

    def _turn(self, row: Row, phase: Phase, *, is_first: bool = False) -> None:
        row.phase = phase
        row.turn = 0 if is_first else self.version + 1


def is_settled(event: events.Watched | events.Checked) -> bool:
    """Tell whether nothing more follows from a change of files."""
    return isinstance(event, events.Checked) or event.is_final


def is_between_states(row: Row) -> bool:
    """Tell whether a lifecycle node is on its way to another state."""
    return row.lifecycle in BETWEEN_STATES


def _in_short(outcome: Outcome) -> str:
    if outcome.lost:
        return 'lost'
    if outcome.signal is not None:
        return signal_name(outcome.signal)
    return f'exit {outcome.code}'
