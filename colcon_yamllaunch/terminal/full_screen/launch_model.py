# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is known of a running launch: from its news to what is shown."""

from collections import deque
from collections.abc import Callable
from collections.abc import Mapping
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from colcon_yamllaunch.common.table import size
from colcon_yamllaunch.control.launch_states import LaunchState
from colcon_yamllaunch.control.launch_states import Part
from colcon_yamllaunch.control.launch_states import ProcessState
from colcon_yamllaunch.control.resource_usage import Usage
from colcon_yamllaunch.control.resource_usage import use_of
from colcon_yamllaunch.control.subscription import Happened
from colcon_yamllaunch.control.subscription import Missed
from colcon_yamllaunch.control.subscription import News
from colcon_yamllaunch.control.subscription import Wrote
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

_FAILED = frozenset(('start_failed', 'load_failed', 'transition_failed'))
_RECOVERED = frozenset(('loaded', 'dropped'))
#: Events after which the plan may be another.
_PLANNED = frozenset(('planned', 'dropped', 'replanned'))


class LaunchModel:
    """
    A launch.

    :param state: As it was when its news began
    :param clock: Returns seconds that never go back
    :param form: That of lines of output, see `log_levels.FORMAT`
    """

    def __init__(
        self,
        state: LaunchState,
        clock: Callable[[], float],
        form: str | None = None,
    ) -> None:
        self._clock = clock
        self.store = OutputStore(form=form)
        self.view = OutputView(self.store)
        #: The labels of what failed since somebody started it.
        self.failed: set[str] = set()
        #: Those of what was stopped on request, and of what is held.
        self.stopped: set[str] = set()
        self.held: set[str] = set()
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
        # how each process ended last
        self._endings: dict[str, str] = {}
        self._gap: Line | None = None
        self._gap_bytes = 0
        self._stopped = 0.0
        self.take_state(state)

    @property
    def seconds(self) -> float:
        """For how long the launch has been running."""
        return self.now_of(self.state.seconds)

    def now_of(self, seconds: float) -> float:
        """Return what a time span of the state has become by now."""
        now = self._stopped if self.ending else self._clock()
        return seconds + now - self._taken

    def part(self, label: str | None) -> Part | None:
        """Return the process or component with a label."""
        found = (p for p in self.state.parts() if p.label == label)
        return next(found, None)

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

    def take_state(self, state: LaunchState) -> None:
        """Take the state as the launch tells it."""
        self.state = state
        self._taken = self._clock()

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
        self._stopped = self._clock()
        self.ending = reason or 'the launch has ended'
        # what it was asked for last came before
        self.state = replace(
            self.state,
            stopping=False,
            processes=tuple(map(self._ended, self.state.processes)),
            components=tuple(
                replace(c, phase='unloaded')
                if c.phase in ('loading', 'loaded', 'unloading')
                else c
                for c in self.state.components
            ),
        )
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

    def _ended(self, process: ProcessState) -> ProcessState:
        if process.phase in ('ended', 'waiting'):
            return process
        ending = self._endings.get(process.label)
        if ending is None:
            # nobody has told; it was not of its own accord
            self.stopped.add(process.label)
            ending = 'ended'
        return replace(process, phase='ended', pid=None, ending=ending)

    def _take_event(self, name: str, fields: Mapping[str, Any]) -> None:
        label = fields.get('label')
        label = label if isinstance(label, str) else None
        self._gap = None
        if label is not None:
            if name in _FAILED or (name == 'exited' and fields.get('failed')):
                self.failed.add(label)
            elif name in _RECOVERED or self._is_new_try(label, name, fields):
                self.failed.discard(label)
            self._take_phase(label, name, fields)
        if name == 'ended':
            self.exit_code = fields.get('exit_code')
        if name == 'watched':
            self.errors = fields.get('errors') or self.errors
        self.wants_state = True
        self.wants_tree |= name in _PLANNED
        text = sentence_of(name, fields)
        if name == 'exited' and label is not None:
            self._endings[label] = text
        elif name == 'started' and label is not None:
            self._endings.pop(label, None)
        if text:
            time = fields.get('time')
            self._say(
                label,
                text,
                time if isinstance(time, float) else 0.0,
                level_of_event(name, fields),
            )

    def _is_new_try(
        self, label: str, name: str, fields: Mapping[str, Any]
    ) -> bool:
        """Tell whether somebody asks for what makes a failure a past one."""
        if name != 'requested':
            return False
        part = self.part(label)
        has_ended = isinstance(part, ProcessState) and part.phase == 'ended'
        return not has_ended or fields.get('action') not in ('stop', 'kill')

    def _take_phase(
        self, label: str, name: str, fields: Mapping[str, Any]
    ) -> None:
        """Keep what the state of a process or component does not tell."""
        self.held.discard(label)
        if name == 'held':
            self.held.add(label)
        elif name == 'exited' and fields.get('asked'):
            self.stopped.add(label)
        elif name in ('started', 'exited'):
            self.stopped.discard(label)

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
