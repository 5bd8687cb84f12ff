# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the full screen shows of a launch, received in its event loop."""

from asyncio import AbstractEventLoop
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
import os
from typing import Any

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.table import size
from colcon_yamllaunch.control import subscription
from colcon_yamllaunch.control.client import (
    ControlError,
    LaunchEndedError,
    RunningLaunch,
)
from colcon_yamllaunch.control.resource_usage import Usage, use_of
from colcon_yamllaunch.engine import commands, events
from colcon_yamllaunch.engine.description import Branch
from colcon_yamllaunch.engine.loop import do_nothing
from colcon_yamllaunch.engine.state import ComponentState, LaunchState
from colcon_yamllaunch.observers.log_levels import Level, level_of
from colcon_yamllaunch.terminal.full_screen.output_store import (
    Line,
    OutputStore,
    OutputView,
)
from colcon_yamllaunch.terminal.line_filter import Filtering
from colcon_yamllaunch.terminal.status_model import (
    Look,
    StatusModel,
    StatusRow,
)

#: The number of measurements that are kept of each process.
HISTORY = 120
#: Reads in an interval, each of some 64 KiB at most. Users cannot read more,
#: and the launch saves the work: it only counts what is missed.
READS = 3
#: The seconds of such an interval.
INTERVAL = 0.2
#: Bytes of output that the screen may be behind before it loses some: enough
#: for a burst, and little enough to stay up to date in a flood.
BEHIND = 8 * 1024 * 1024

#: Events after which the plan may have changed.
_PLANNED = frozenset(('planned', 'dropped', 'replanned'))
#: What stands before a launch file, a group, a timer.
_BLOCKS: Mapping[str, Look] = {
    kind: Look(sign, sign, '', 'cyan')
    for kind, sign in (('file', '▤'), ('group', '▣'), ('timer', '◷'))
}
#: What each event says, with its fields of `events.jsonl` in braces; nothing
#: where it says nothing of its own.
SENTENCES: Mapping[str, str] = {
    'started': 'started, pid {pid}',
    'start_failed': 'could not be started: {reason}',
    'held': 'held by {signal}',
    'continued': 'goes on',
    'silent': 'no output for {seconds:g} s',
    'requested': '{action} requested',
    'attached': 'attached to a terminal',
    'detached': 'detached',
    'left_behind': 'pid {pid} cannot be stopped, not even by SIGKILL',
    'ready': 'ready after {seconds:.1f} s',
    'restart_limit': 'not started again, after {restarts} restarts',
    'loaded': 'loaded into {container}',
    'load_failed': 'could not be loaded into {container}: {reason}',
    'unloaded': 'unloaded from {container}: {reason}',
    'state_changed': '{state}',
    'transition_failed': "the transition '{transition}' failed: {reason}",
    'ros_lost': '{reason}; no component is loaded any more',
    'link_lost': '{machine}: the link is lost: {reason}',
    'link_back': '{machine}: the link is back after {seconds:.1f} s',
    'machine_gone': '{machine} is gone: {reason}',
    'watched': '{text}',
    'plan_failed': '{text}',
    'host_lost': 'the worker for Python launch files {reason}',
    'message': '{text}',
    'warning': 'warning: {text}',
    'shutdown': 'stopping: {reason}',
    'ended': 'the launch has ended, exit code {exit_code}',
    # other events say this, or the list of processes shows it
    **dict.fromkeys(('planned', 'dropped', 'respawned', 'signalled'), ''),
    **dict.fromkeys(('changed', 'built', 'replanned', 'restarted'), ''),
    # functions make these sentences
    'exited': '',
    'checked': '',
    **dict.fromkeys(('waiting', 'not_started', 'not_ready'), ''),
}
_FAILURES = frozenset(
    (
        'host_lost',
        'left_behind',
        'load_failed',
        'machine_gone',
        'not_ready',
        'not_started',
        'plan_failed',
        'restart_limit',
        'ros_lost',
        'start_failed',
        'transition_failed',
    )
)
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
        # the loop that reads the connection
        self._loop: AbstractEventLoop | None = None
        # when the interval began, and the number of reads in it
        self._begin, self._reads = 0.0, 0
        # the processes whose output is read, None for all; and the missed
        # bytes when the filter last changed
        self._wanted: Collection[str] | None = None
        self._missed_before = 0

    @property
    def state(self) -> LaunchState:
        """The state of the launch."""
        return self._launch.state

    @property
    def failed(self) -> set[str]:
        """The labels of what failed since somebody started it."""
        return {p.label for p in self.state.by_label.values() if p.failure}

    def open(
        self,
        loop: AbstractEventLoop,
        changed: Callable[[], None],
        ended: Callable[[str], None],
    ) -> None:
        """
        Receive what happens, in the loop of the full screen.

        :param changed: Is called after something has changed
        :param ended: Is called with the reason when nothing more is received;
          it is empty where the launch has ended as it should
        """
        self._loop, self._changed, self._ended = loop, changed, ended
        self._begin = loop.time()
        loop.add_reader(self._launch.fileno(), self._read)
        self._follow_up()

    def close(self) -> None:
        """Close the connection."""
        loop, self._loop = self._loop, None
        if loop is not None:
            loop.remove_reader(self._launch.fileno())
            self._launch.close()

    def send(self, send: Callable[..., None], *what: Any, **more: Any) -> None:
        """
        Send something, unless the launch has ended.

        :param send: `RunningLaunch.ask` or `send_request`, which gets the rest
        """
        if self._loop is not None:
            try:
                send(*what, **more)
            except ControlError as error:
                self._fail(error)

    def choose(self, filtering: Filtering) -> None:
        """Show and read the output that a filter lets through."""
        self.view.choose(filtering)
        self._missed_before = self.missed_bytes
        self._subscribe()

    def ask_for_usage(self) -> None:
        """Request the CPU and memory use of processes on other machines."""
        if any(process.machine for process in self.state.processes):
            # the answer updates the state
            self.send(self._launch.send_request, 'status', do_nothing)

    def receive(self, received: subscription.Received) -> None:
        """Add an event, output or gap."""
        match received:
            case subscription.ReceivedOutput():
                self._gap = None
                self.view.add(self.store.add(received))
            case subscription.ReceivedEvent():
                self._gap = None
                name, fields = received.name, received.fields
                self.wants_tree |= name in _PLANNED
                text = sentence_of(name, fields)
                if text:
                    label, time = fields.get('label'), fields.get('time')
                    self.say(
                        text,
                        label if isinstance(label, str) else None,
                        time if isinstance(time, float) else 0.0,
                        level_of_event(name, fields),
                    )
            case subscription.LostData():
                self.missed_bytes += received.bytes
                self.wants_tree |= bool(received.events)
                if self._gap is None:
                    self._gap_bytes = 0
                    self._gap = self.say('')
                self._gap_bytes += received.bytes
                text = f'… {size(self._gap_bytes)} not shown …'
                self.store.alter(self._gap, text)

    def add_usage(self, usage: Mapping[int, Usage]) -> None:
        """
        Add what process groups of this machine use.

        What runs on other ones is part of the state of the launch.
        """
        shares = {}
        for process in self.state.processes:
            used = use_of(process, usage)
            if used is None and process.label not in self.usage:
                continue
            history = self.usage.setdefault(
                process.label, deque[Usage](maxlen=HISTORY)
            )
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
        # a killed launcher did not report how these ended
        for member in tuple(state.by_label.values()):
            named: Any = member
            if isinstance(member, ComponentState):
                if member.phase in ('loading', 'loaded', 'unloading'):
                    state.apply(events.MemberChanged(named, 'unloaded'))
            elif member.phase not in ('ended', 'waiting'):
                state.apply(events.MemberChanged(named, 'ended', 'ended'))
        if reason:
            self.say(reason)

    def say(
        self,
        text: str,
        label: str | None = None,
        time: float = 0.0,
        level: Level = Level.FATAL,
    ) -> Line:
        """
        Add a line about the launch, or about a process, to the output.

        :param label: The process, None for the launch
        :param time: Seconds since the epoch, 0 for none
        :param level: The level, by default one that no filter hides
        """
        line = self.store.add_note(label, text, time, level)
        self.view.add((line,))
        return line

    def rows(self) -> list[StatusRow]:
        """Return a row for each process, with its components below it."""
        rows: list[StatusRow] = []
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

    def plan_rows(self) -> list[StatusRow]:
        """Return the plan: files, groups, timers, and what is in them."""
        return list(self._branch_rows(self.tree, 0))

    def _branch_rows(
        self, branches: Sequence[Branch], depth: int
    ) -> Iterator[StatusRow]:
        for branch in branches:
            kind, title = branch.kind, branch.title
            member = self.member(title)
            if kind in _BLOCKS:
                shown = os.path.basename(title) if kind == 'file' else title
                name = one_line(shown) or kind
                # the name of the file is enough, as its path is long
                position = os.path.basename(one_line(branch.position))
                if not depth and kind == 'file':
                    # no file includes the launched one
                    position = ''
                yield _block_row(_BLOCKS[kind], name, position, depth)
            elif member is not None:
                yield self.row(member, depth)
            yield from self._branch_rows(branch.children, depth + 1)

    def _assign(self) -> None:
        """Assign digits to the first processes."""
        if self._assigned != self.state.version:
            self._assigned = self.state.version
            labels = [process.label for process in self.state.processes]
            self._keys = dict(zip(labels, _DIGITS, strict=False))

    # -- what is received

    def _read(self) -> None:
        loop = self._loop
        if loop is None:
            return
        now = loop.time()
        if now - self._begin > INTERVAL:
            self._begin = now
            self._reads = 0
        self._reads += 1
        try:
            self._launch.read()
            for received in self._launch.received():
                self.receive(received)
            self._follow_up()
        except ControlError as error:
            self._fail(error)
            return
        if self._loop is not None and self._reads >= READS:
            loop.remove_reader(self._launch.fileno())
            loop.call_at(self._begin + INTERVAL, self._resume_reading)

    def _resume_reading(self) -> None:
        if self._loop is not None:
            self._loop.add_reader(self._launch.fileno(), self._read)

    def _follow_up(self) -> None:
        if self.wants_tree:
            self.wants_tree = False
            self.send(self._launch.ask, commands.Tree(), self._set_tree)
        self._subscribe()
        self._changed()

    def _set_tree(
        self, response: commands.PlanTree | commands.Refused
    ) -> None:
        if isinstance(response, commands.PlanTree):
            self.tree = response.tree

    def _subscribe(self) -> None:
        """
        Read the shown output only, if reading all of it is too much.

        Otherwise read all, so that it is there when the filter changes.
        """
        is_too_much = self.missed_bytes > self._missed_before
        filtering = self.view.filtering
        wanted = None
        if (self._wanted is not None or is_too_much) and (
            filtering.only or filtering.muted
        ):
            labels = (process.label for process in self.state.processes)
            wanted = sorted(filter(filtering.has, labels))
        if wanted == self._wanted:
            return
        if self._wanted is None:
            self.say('… too much: of what is not shown, nothing is read …')
        elif wanted is None:
            self.say('… all is read again …')
        self._wanted = wanted
        self.send(
            self._launch.send_request,
            'subscribe',
            do_nothing,
            processes=wanted,
            behind=BEHIND,
            raw=True,
            states=True,
        )

    def _fail(self, error: ControlError) -> None:
        self.close()
        reason = '' if isinstance(error, LaunchEndedError) else str(error)
        self._ended(reason)


def _block_row(look: Look, title: str, note: str, depth: int = 0) -> StatusRow:
    return StatusRow(None, title, look, look.style, state=note, depth=depth)


# events of a launch, as lines among its output


def sentence_of(name: str, fields: Mapping[str, Any]) -> str:
    """
    Return the sentence about an event, without the name of the process.

    It is empty for an event that is not worth a line.
    """
    try:
        if name == 'requested' and fields['action'] == 'change':
            return ''
        if name == 'exited':
            text = _ending(fields)
        elif name == 'checked':
            text = 'green: all was seen'
            if not fields['passed']:
                missing = [f"'{t}' was not seen" for t in fields['missing']]
                text = f'red: {", ".join((*fields["failures"], *missing))}'
        elif name == 'waiting':
            text = f'waiting for {events.listed(fields["labels"])}'
        elif name == 'not_started':
            labels = events.listed(fields['labels'])
            text = f'not started, as it waits for {labels}'
        elif name == 'not_ready':
            text = events.not_ready_text(
                fields['conditions'], fields['seconds'], fields['found']
            )
        else:
            text = SENTENCES.get(name, '').format_map(fields)
    except (KeyError, TypeError, ValueError):
        # the event is of a later version
        return name
    delay = fields.get('respawn_delay')
    if delay is not None:
        text += ', starts again' + (f' in {delay:g} s' if delay else '')
    return one_line(text)


def level_of_event(name: str, fields: Mapping[str, Any]) -> Level:
    """Return how severe an event is."""
    if name == 'message':
        return level_of(f'[{fields.get("level")}]'.encode()) or Level.INFO
    is_late = name == 'not_ready' and fields.get('action') != 'fail'
    if name == 'warning' or is_late:
        return Level.WARN
    failed = (
        name in _FAILURES
        or fields.get('failed') is True
        or fields.get('passed') is False
        or (name == 'ended' and fields.get('exit_code') != 0)
    )
    return Level.ERROR if failed else Level.INFO


def _ending(fields: Mapping[str, Any]) -> str:
    if fields['signal'] is not None:
        text = f'died by {fields["signal"]}'
    elif fields['exit_code']:
        text = f'exited with code {fields["exit_code"]}'
    elif fields['exit_code'] is None:
        # it ran on a machine that is gone, so how it ended is unknown
        text = 'lost'
    else:
        text = 'finished'
    if fields['asked'] and not fields['failed']:
        text = 'stopped'
    return f'{text} after {fields["seconds"]:.1f} s'
