# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the full screen shows of a launch, and how it receives that."""

from asyncio import AbstractEventLoop
from collections import deque
from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
import os
from typing import Any

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.table import size
from colcon_yamllaunch.control.client import ControlError
from colcon_yamllaunch.control.client import LaunchEndedError
from colcon_yamllaunch.control.client import RunningLaunch
from colcon_yamllaunch.control.resource_usage import Usage
from colcon_yamllaunch.control.resource_usage import use_of
from colcon_yamllaunch.control.subscription import Happened
from colcon_yamllaunch.control.subscription import Missed
from colcon_yamllaunch.control.subscription import Received
from colcon_yamllaunch.control.subscription import Wrote
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.commands import PlanTree
from colcon_yamllaunch.engine.commands import Refused
from colcon_yamllaunch.engine.commands import Tree
from colcon_yamllaunch.engine.description import Branch
from colcon_yamllaunch.engine.state import ComponentState
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.observers.log_levels import Level
from colcon_yamllaunch.terminal.full_screen.event_sentences import (
    level_of_event,
)
from colcon_yamllaunch.terminal.full_screen.event_sentences import sentence_of
from colcon_yamllaunch.terminal.full_screen.output_store import Line
from colcon_yamllaunch.terminal.full_screen.output_store import OutputStore
from colcon_yamllaunch.terminal.full_screen.output_store import OutputView
from colcon_yamllaunch.terminal.status_model import Look
from colcon_yamllaunch.terminal.status_model import Row
from colcon_yamllaunch.terminal.status_model import StatusModel

#: How often in a row the use of resources is remembered.
HISTORY = 120
#: Reads in an interval, each of some 64 KiB at most. Nobody reads more than
#: that, and the launch need not prepare it: it counts what we miss.
READS = 3
#: Seconds.
INTERVAL = 0.2
#: Bytes of output that the screen may be behind before it misses some. So it
#: shows all of a burst, and stays up to date beside an endless flood.
BEHIND = 8 * 1024 * 1024

#: Events after which the plan may be another.
_PLANNED = frozenset(('planned', 'dropped', 'replanned'))
#: What stands before a launch file, a group, a timer.
_BLOCKS: Mapping[str, Look] = {
    kind: Look(sign, sign, '', 'cyan')
    for kind, sign in (('file', '▤'), ('group', '▣'), ('timer', '◷'))
}
_CONTAINER = Look('▢', '▢', '', 'dim')
_DIGITS = '1234567890'


class LaunchModel(StatusModel):
    """
    A launch, its output, and what its processes use.

    :param launch: The launch, whose state follows its events
    :param form: The form of lines of output, see `log_levels.FORMAT`
    """

    def __init__(self, launch: RunningLaunch, form: str | None = None) -> None:
        super().__init__(launch.state)
        self._launch = launch
        self.store = OutputStore(form=form)
        self.view = OutputView(self.store)
        #: The plan as a tree.
        self.tree: Sequence[Branch] = ()
        #: Bytes of output that were lost.
        self.missed_bytes = 0
        #: What processes used, the latest last.
        self.usage: dict[str, deque[Usage]] = {}
        #: Why nothing more is received; empty as long as there may be more.
        self.ending = ''
        #: Whether to ask for the plan, as it may have changed.
        self.wants_tree = True
        self._gap: Line | None = None
        self._gap_bytes = 0

    @property
    def state(self) -> LaunchState:
        """The state of the launch."""
        return self._launch.state

    @property
    def failed(self) -> set[str]:
        """The labels of what failed since somebody started it."""
        return {p.label for p in self.state.by_label.values() if p.failure}

    def receive(self, received: Received) -> None:
        """Add an event, output or gap."""
        match received:
            case Wrote():
                self._gap = None
                self.view.add(self.store.add(received))
            case Happened():
                self._gap = None
                self._add_event(received.name, received.fields)
            case Missed():
                self._add_gap(received)

    def add_usage(self, usage: Mapping[int, Usage]) -> None:
        """
        Add what process groups of this machine use.

        What runs on other ones is part of the state of the launch.
        """
        shares = {}
        for process in self.state.processes:
            used = use_of(process, usage)
            history = self.usage.get(process.label)
            if used is None and history is None:
                continue
            if history is None:
                history = deque[Usage](maxlen=HISTORY)
                self.usage[process.label] = history
            history.append(used or Usage(0.0, 0))
            if process.pid is not None:
                shares[process.label] = history[-1].cpu
        self.measure(shares)

    def end(self, reason: str) -> None:
        """
        Show the launch as it was at its end.

        :param reason: Why nothing more is received, as a sentence; empty
          where the launch said it
        """
        self.ending = reason or 'the launch has ended'
        state = self.state
        stopped = state.clock()
        state.clock = lambda: stopped
        # a launcher that was killed could not say what became of these
        for part in tuple(state.by_label.values()):
            named: Any = part
            if isinstance(part, ComponentState):
                if part.phase in ('loading', 'loaded', 'unloading'):
                    state.apply(events.PartChanged(named, 'unloaded'))
            elif part.phase not in ('ended', 'waiting'):
                state.apply(events.PartChanged(named, 'ended', 'ended'))
        if reason:
            self.say(reason)

    @property
    def shown_labels(self) -> Collection[str] | None:
        """The processes whose output is shown; None for all."""
        filtering = self.view.filtering
        if not filtering.only and not filtering.muted:
            return None
        labels = (process.label for process in self.state.processes)
        return sorted(filter(filtering.has, labels))

    def say(self, text: str) -> None:
        """Add a line about the launch to its output."""
        self._say(None, text, 0.0, Level.FATAL)

    def rows(self) -> list[Row]:
        """Return a row for each process, with its components below it."""
        rows: list[Row] = []
        state = self.state
        for process in state.processes:
            rows.append(self.row(process))
            components = state.components_of(process.label)
            rows += (self.row(component, 1) for component in components)
        others = list(state.components_of(None))
        for container in dict.fromkeys(c.container for c in others):
            title = one_line(container)
            rows.append(_block_row(_CONTAINER, title, 'not of this launch'))
            rows += (
                self.row(c, 1) for c in others if c.container == container
            )
        return rows

    def plan_rows(self) -> list[Row]:
        """Return the plan: files, groups, timers, and what is in them."""
        return list(self._branch_rows(self.tree, 0))

    def _branch_rows(
        self, branches: Sequence[Branch], depth: int
    ) -> Iterator[Row]:
        for branch in branches:
            kind, title = branch.kind, branch.title
            part = self.part(title)
            if kind in _BLOCKS:
                shown = os.path.basename(title) if kind == 'file' else title
                name = one_line(shown) or kind
                # the place in a file, as its path is long
                position = os.path.basename(one_line(branch.position))
                if not depth and kind == 'file':
                    # what was launched is included nowhere
                    position = ''
                yield _block_row(_BLOCKS[kind], name, position, depth)
            elif part is not None:
                yield self.row(part, depth)
            yield from self._branch_rows(branch.children, depth + 1)

    def _assign(self) -> None:
        """Assign digits to the first processes."""
        if self._assigned != self.state.version:
            self._assigned = self.state.version
            labels = [process.label for process in self.state.processes]
            self._keys = dict(zip(labels, _DIGITS, strict=False))
            self._labels = {key: label for label, key in self._keys.items()}

    def _add_event(self, name: str, fields: Mapping[str, Any]) -> None:
        label = fields.get('label')
        self.wants_tree |= name in _PLANNED
        text = sentence_of(name, fields)
        if text:
            time = fields.get('time')
            self._say(
                label if isinstance(label, str) else None,
                text,
                time if isinstance(time, float) else 0.0,
                level_of_event(name, fields),
            )

    def _say(
        self, label: str | None, text: str, time: float, level: Level
    ) -> Line:
        line = self.store.add_note(label, text, time, level)
        self.view.add((line,))
        return line

    def _add_gap(self, missed: Missed) -> None:
        self.missed_bytes += missed.bytes
        self.wants_tree |= bool(missed.events)
        if self._gap is None:
            self._gap_bytes = 0
            self._gap = self._say(None, '', 0.0, Level.FATAL)
        self._gap_bytes += missed.bytes
        text = f'… {size(self._gap_bytes)} not shown …'
        self.store.alter(self._gap, text)


def _block_row(look: Look, title: str, note: str, depth: int = 0) -> Row:
    return Row(None, title, look, look.style, state=note, depth=depth)


class LaunchReader:
    """
    Receives what happens in a launch, in the loop of the full screen.

    :param changed: Is called after something has changed
    :param ended: Is called with the reason when nothing more is received; it
      is empty where the launch has ended as it should
    """

    def __init__(
        self,
        launch: RunningLaunch,
        loop: AbstractEventLoop,
        model: LaunchModel,
        changed: Callable[[], None],
        ended: Callable[[str], None],
    ) -> None:
        self._launch = launch
        self._loop = loop
        self._model = model
        self._changed = changed
        self._ended = ended
        self._begin = loop.time()
        self._reads = 0
        # the processes whose output is read, None for all; and what was
        # missed when somebody last chose what is shown
        self._wanted: Collection[str] | None = None
        self._missed_before = 0
        self._is_open = True
        loop.add_reader(launch.fileno(), self._read)
        self._settle()

    def close(self) -> None:
        """Close the connection."""
        if self._is_open:
            self._is_open = False
            self._loop.remove_reader(self._launch.fileno())
            self._launch.close()

    def send(self, send: Callable[..., None], *what: Any, **more: Any) -> None:
        """
        Send something, unless the launch has ended.

        :param send: `RunningLaunch.ask` or `send_request`, which gets the rest
        """
        if self._is_open:
            try:
                send(*what, **more)
            except ControlError as error:
                self._end(error)

    def choose(self) -> None:
        """Read the output that somebody chose to see."""
        self._missed_before = self._model.missed_bytes
        self._narrow()

    def look_again(self) -> None:
        """Ask for what processes on other machines use."""
        if any(process.machine for process in self._model.state.processes):
            # it comes with the state
            self.send(self._launch.send_request, 'status', bool)

    def _read(self) -> None:
        now = self._loop.time()
        if now - self._begin > INTERVAL:
            self._begin = now
            self._reads = 0
        self._reads += 1
        try:
            self._launch.read()
            for received in self._launch.received():
                self._model.receive(received)
            self._settle()
        except ControlError as error:
            self._end(error)
            return
        if self._is_open and self._reads >= READS:
            self._loop.remove_reader(self._launch.fileno())
            self._loop.call_at(self._begin + INTERVAL, self._go_on)

    def _go_on(self) -> None:
        if self._is_open:
            self._loop.add_reader(self._launch.fileno(), self._read)

    def _settle(self) -> None:
        model = self._model
        if model.wants_tree:
            model.wants_tree = False
            self.send(self._launch.ask, Tree(), self._take_tree)
        self._narrow()
        self._changed()

    def _take_tree(self, response: PlanTree | Refused) -> None:
        if isinstance(response, PlanTree):
            self._model.tree = response.tree

    def _narrow(self) -> None:
        """
        Read what is shown only, where all of it is too much.

        Else all is read, so that it is there when somebody wants to see it.
        """
        model = self._model
        is_too_much = model.missed_bytes > self._missed_before
        wanted = None
        if self._wanted is not None or is_too_much:
            wanted = model.shown_labels
        if wanted == self._wanted:
            return
        if self._wanted is None:
            model.say('… too much: of what is not shown, nothing is read …')
        elif wanted is None:
            model.say('… all is read again …')
        self._wanted = wanted
        self.send(
            self._launch.send_request,
            'subscribe',
            bool,
            processes=wanted,
            behind=BEHIND,
            raw=True,
            states=True,
        )

    def _end(self, error: ControlError) -> None:
        self.close()
        reason = '' if isinstance(error, LaunchEndedError) else str(error)
        self._ended(reason)
