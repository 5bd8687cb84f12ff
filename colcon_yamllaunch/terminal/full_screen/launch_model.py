# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is known of a running launch: from its news to what is shown."""

from collections import deque
from collections.abc import Mapping
from collections.abc import Sequence
import signal
from typing import Any

from colcon_yamllaunch.common.table import size
from colcon_yamllaunch.control.resource_usage import Usage
from colcon_yamllaunch.control.resource_usage import use_of
from colcon_yamllaunch.control.subscription import Happened
from colcon_yamllaunch.control.subscription import Missed
from colcon_yamllaunch.control.subscription import News
from colcon_yamllaunch.control.subscription import Wrote
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.state import ComponentState
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.engine.state import Part
from colcon_yamllaunch.observers.log_levels import Level
from colcon_yamllaunch.terminal.full_screen.event_sentences import (
    level_of_event,
)
from colcon_yamllaunch.terminal.full_screen.event_sentences import sentence_of
from colcon_yamllaunch.terminal.full_screen.output_store import Line
from colcon_yamllaunch.terminal.full_screen.output_store import OutputStore
from colcon_yamllaunch.terminal.full_screen.output_view import OutputView

#: How often in a row the use of resources is remembered.
HISTORY = 120

#: Events after which the plan may be another.
_PLANNED = frozenset(('planned', 'dropped', 'replanned'))


class LaunchModel:
    """
    A launch.

    :param state: As it was when its news began
    :param form: That of lines of output, see `log_levels.FORMAT`
    """

    def __init__(self, state: LaunchState, form: str | None = None) -> None:
        #: The launch as it was described last.
        self.state = state
        self.store = OutputStore(form=form)
        self.view = OutputView(self.store)
        #: The plan as a tree, as `protocol` has it.
        self.tree: Sequence[Mapping[str, Any]] = ()
        #: What the last build or evaluation that failed has said.
        self.errors: Sequence[str] = ()
        #: Bytes of output that were lost.
        self.missed_bytes = 0
        #: What processes used, the latest last.
        self.usage: dict[str, deque[Usage]] = {}
        #: Why there are no more news; empty as long as there are.
        self.ending = ''
        #: What the launcher exited with, None where that is not known.
        self.exit_code: int | None = None
        #: Whether the launch is to be asked for its state, or its plan, as
        #: something happened.
        self.wants_state = False
        self.wants_tree = True
        # how processes ended since they were started last
        self._exits: dict[str, events.Exited] = {}
        self._gap: Line | None = None
        self._gap_bytes = 0

    @property
    def failed(self) -> set[str]:
        """The labels of what failed since somebody started it."""
        return {p.label for p in self.state.by_label.values() if p.failure}

    def part(self, label: str | None) -> Part | None:
        """Return the process or component with a label."""
        return None if label is None else self.state.by_label.get(label)

    def take(self, news: News) -> None:
        """Take what happened."""
        match news:
            case Wrote():
                self._gap = None
                self.view.add(self.store.take(news))
            case Happened():
                self._take_event(news.name, news.fields)
            case Missed():
                self._take_gap(news)

    def take_usage(self, usage: Mapping[int, Usage]) -> None:
        """
        Take what process groups of this machine use.

        What runs on other ones is part of the state of the launch.
        """
        self.wants_state |= any(p.machine for p in self.state.processes)
        for process in self.state.processes:
            used = use_of(process, usage)
            history = self.usage.get(process.label)
            if used is None and history is None:
                continue
            if history is None:
                history = deque[Usage](maxlen=HISTORY)
                self.usage[process.label] = history
            history.append(used or Usage(0.0, 0))

    def end(self, reason: str) -> None:
        """
        There are no more news.

        :param reason: Why, as a sentence; empty where the launch said it
        """
        self.ending = reason or 'the launch has ended'
        state = self.state
        stopped = state.clock()
        state.clock = lambda: stopped
        # what it was asked for last came before
        for part in state.parts():
            event: events.Event | None = None
            if isinstance(part, ComponentState):
                if part.phase in ('loading', 'loaded', 'unloading'):
                    event = events.PartChanged(_named(part), 'unloaded')
            elif part.phase not in ('ended', 'waiting'):
                # where nobody has said how, it was not by itself
                event = self._exits.get(
                    part.label,
                    events.PartChanged(_named(part), 'ended', 'ended'),
                )
            if event is not None:
                state.apply(event)
        if reason:
            self.say(reason)

    @property
    def shown_labels(self) -> frozenset[str]:
        """Those of the processes whose output is to be seen."""
        has = self.view.filtering.has
        labels = (p.label for p in self.state.processes)
        return frozenset(label for label in labels if has(label))

    @property
    def shows_all(self) -> bool:
        """Whether the output of all processes is to be seen."""
        filtering = self.view.filtering
        return not filtering.only and not filtering.muted

    def say(self, text: str) -> None:
        """Say something of the launch that stands among its output."""
        self._say(None, text, 0.0, Level.FATAL)

    def _take_event(self, name: str, fields: Mapping[str, Any]) -> None:
        label = fields.get('label')
        label = label if isinstance(label, str) else None
        self._gap = None
        if name == 'ended':
            self.exit_code = fields.get('exit_code')
        if name == 'watched':
            self.errors = fields.get('errors') or self.errors
        self.wants_state = True
        self.wants_tree |= name in _PLANNED
        text = sentence_of(name, fields)
        part = self.part(label)
        if part is not None and name in ('started', 'exited'):
            self._exits.pop(part.label, None)
            if name == 'exited':
                self._exits[part.label] = _exited(part, fields)
        if text:
            time = fields.get('time')
            self._say(
                label,
                text,
                time if isinstance(time, float) else 0.0,
                level_of_event(name, fields),
            )

    def _say(
        self, label: str | None, text: str, time: float, level: Level
    ) -> Line:
        line = self.store.tell(label, text, time, level)
        self.view.add((line,))
        return line

    def _take_gap(self, missed: Missed) -> None:
        self.missed_bytes += missed.bytes
        if missed.events:
            # what it would have told is in the state
            self.wants_state = self.wants_tree = True
        if self._gap is None:
            self._gap_bytes = 0
            self._gap = self._say(None, '', 0.0, Level.FATAL)
        self._gap_bytes += missed.bytes
        text = f'… {size(self._gap_bytes)} not shown …'
        self.store.alter(self._gap, text)


def _named(part: Part) -> Any:
    """Return what stands for a part of the plan in events to apply."""
    return part


def _exited(part: Part, fields: Mapping[str, Any]) -> events.Exited:
    """Return the end of a process from its line in `events.jsonl`."""
    name = fields.get('signal')
    number = getattr(signal, name, None) if isinstance(name, str) else None
    outcome = Outcome(
        fields.get('exit_code'), number, bool(fields.get('core_dumped'))
    )
    return events.Exited(
        _named(part),
        pid=0,
        outcome=outcome,
        seconds=0.0,
        asked=bool(fields.get('asked')),
        failed=bool(fields.get('failed')),
    )
