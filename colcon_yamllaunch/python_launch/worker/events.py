# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What launch files do when something happens.

Events are handled as `launch.LaunchService` does, by the event handlers of
launch files and of ROS 2. What it would do to processes and nodes is reported
to the launcher, which reports what happens to them.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
import importlib
import signal
from types import SimpleNamespace
from typing import Any, TYPE_CHECKING

from launch import event_handlers, events, LaunchDescriptionEntity
from launch.event_handler import BaseEventHandler
from launch.events import process as processes

from .channel import Json
from .descriptions import (
    Describer,
    entities_of,
    is_a,
    matches_event,
    may_hear,
    may_match_later,
    OF_WORKER,
    TRANSITIONS,
)
from .entries import is_shutdown, note_positions

if TYPE_CHECKING:
    from .visit import Visitor


#: The reason that `launch` has for Ctrl-C.
_SIGINT = 'ctrl-c (SIGINT)'
#: How `launch` keeps what is to be done when an action is done.
_COMPLETED = '_ExecuteLocal__completed_future'


class Future:
    """Stands for the asyncio future of an action; calls back at once."""

    def __init__(self) -> None:
        self._callbacks: list[Callable[[Any], object]] = []
        self._is_done = False

    def done(self) -> bool:
        """Return whether the action is done."""
        return self._is_done

    def add_done_callback(self, callback: Callable[[Any], object]) -> None:
        """Call something once the action is done."""
        if self._is_done:
            callback(self)
        else:
            self._callbacks.append(callback)

    def set_result(self, _result: object = None) -> None:
        """Record that the action is done."""
        if not self._is_done:
            self._is_done = True
            for callback in self._callbacks:
                callback(self)


class Queue:
    """
    Stands for the queue of events that the launch context has.

    :param here: Returns the position of what is being done
    """

    def __init__(self, here: Callable[[], Any]) -> None:
        #: Takes an event that is not to wait, and returns whether it did.
        self.handle_at_once: Callable[[Any], bool] = lambda _: False
        self._events: deque[tuple[Any, Any]] = deque()
        self._here = here

    def put_nowait(self, event: Any) -> None:
        """Add an event."""
        if not self.handle_at_once(event):
            self._events.append((event, self._here()))

    async def put(self, event: Any) -> None:
        """Add an event."""
        self.put_nowait(event)

    def empty(self) -> bool:
        """Return whether there are no events."""
        return not self._events

    def pop(self) -> tuple[Any, Any]:
        """Return the first event, and where it was emitted."""
        return self._events.popleft()

    def copy(self) -> list[tuple[Any, Any]]:
        """Return the events that there are."""
        return list(self._events)

    def restore(self, events: Iterable[tuple[Any, Any]]) -> None:
        """Replace the events by those that :meth:`copy` returned."""
        self._events = deque(events)


class Events:
    """
    The events of a launch, and what its launch files do about them.

    :param visitor: Visits what handlers return
    """

    def __init__(self, visitor: Visitor) -> None:
        self._visitor = visitor
        self.queue = Queue(visitor.position)
        #: The processes that have ended for good.
        self._over: set[int] = set()
        #: The processes that a launch file has had stopped.
        self._stopped: set[int] = set()
        #: The processes whose output is kept for whoever asks for it.
        self._kept: set[int] = set()
        #: The handlers that may be about output, and whose they take.
        self._listeners: list[Any] = []
        self._heard: dict[int, bool] = {}
        #: The ends of the launch that the launcher was told to begin.
        self._shutdowns: list[Any] = []
        #: Whether the launcher has told that the launch ends.
        self._is_ending = False
        #: Where the event that is handled was emitted.
        self._origin: Any = None
        self._reported: Json | None = None
        #: The handlers and processes that were reported.
        self._seen: Any = None
        note_positions(visitor, BaseEventHandler)
        visitor.requests['event'] = self.handle
        visitor.before_done.append(self.report_handlers)
        visitor.forget.append(self.forget)
        self.forget()

    def forget(self) -> None:
        """Begin anew, with the context that there is now."""
        self._context._event_queue = self.queue
        self._context._event_handlers.clear()
        self.queue.restore(())
        self._is_ending = self._visitor.is_running = False
        self._over.clear()
        self._stopped.clear()
        self._kept.clear()
        self._heard.clear()
        self._shutdowns.clear()
        self._follows_lifecycles = False
        self._reported = self._seen = None
        register = self._context.register_event_handler
        # as LaunchService does, so these two come last
        included = event_handlers.OnIncludeLaunchDescription()
        setattr(included, OF_WORKER, True)
        register(included)
        self._on(
            events.Shutdown, lambda _: self._context._set_is_shutdown(True)
        )
        self._on(
            processes.ShutdownProcess,
            lambda event: self._report_signal(event, 0),
        )
        self._on(processes.SignalProcess, self._signal_process)

    @property
    def _context(self) -> Any:
        return self._visitor.context

    # what launch files start

    def add_process(self, action: Any, number: int) -> None:
        """Record the action of a process."""
        setattr(action, _COMPLETED, Future())
        # for those who look for a process by it
        action.process_details.setdefault('pid', None)
        if is_a(action, 'LifecycleNode') and not self._follows_lifecycles:
            self._follows_lifecycles = True
            kinds = importlib.import_module('launch_ros.events.lifecycle')
            self._on(kinds.ChangeState, self._change_state)
        if getattr(action, '_ExecuteLocal__cached_output', False):
            self._kept.add(number)
            self._on(
                processes.ProcessIO,
                lambda event: self._keep_output(action, event),
                action,
            )

    def add_on_exit(self, action: Any, on_exit: Any) -> None:
        """Register what is to be done when a process ends."""
        handler = event_handlers.OnProcessExit(
            target_action=action, on_exit=on_exit
        )
        self._visitor.positions.pass_on(action, handler)
        self._context.register_event_handler(handler)

    # requests

    def is_settled(self, event: Any) -> bool:
        """
        Return whether a later request will come to the same as now.

        :param event: A `ChangeState`, `ShutdownProcess` or `SignalProcess`
        """
        own = self._context._event_handlers
        users = [one for one in own if not hasattr(one, OF_WORKER)]
        if is_a(event, 'ChangeState'):
            matcher, actions = event.lifecycle_node_matcher, self._lifecycles()
        else:
            matcher = event.process_matcher
            actions = list(self._running().values())
        if is_a(event, 'ShutdownProcess'):
            # they would take another stop of the process for this one
            is_heard = bool(users)
        else:
            is_heard = any(matches_event(one, event) for one in users)
        # what matches anything may match what is still to come
        return (
            not is_heard
            and any(_matches(matcher, action) for action in actions)
            and not _matches(matcher, object())
        )

    def settle(self, event: Any, position: Any) -> None:
        """Handle an event that was emitted at a position."""
        self._origin = position
        self._handle(event)
        self._origin = None

    def handle(self, request: Json) -> None:
        """Handle what happened."""
        self._visitor.is_running = True
        event = request['event']
        do = {
            'start': self._started,
            'exit': self._exited,
            'output': self._wrote,
            'state': self._changed,
            'shutdown': self._ended,
        }[event['type']]
        self.handle_all()
        do(event)

    def report_handlers(self) -> None:
        """Report the event handlers, and whose output they take, if new."""
        started = self._visitor.started
        # the last one registered comes first
        handlers = list(reversed(self._context._event_handlers))
        seen = handlers, list(started), len(self._over)
        if seen == self._seen:
            return
        if self._seen is None or handlers != self._seen[0]:
            self._listeners = [one for one in handlers if may_hear(one)]
            self._heard.clear()
        elif any(map(may_match_later, self._listeners)):
            self._heard.clear()
        self._seen = seen
        found: list[Json] | bool
        if self._visitor.is_running:
            # the launcher no longer shows them
            found = not all(hasattr(one, OF_WORKER) for one in handlers)
        else:
            found = self._describe(handlers, started)
        output: list[int] = []
        if found:
            output = [
                number
                for number, action in started.items()
                if number not in self._over
                and (number in self._kept or self._is_heard(number, action))
            ]
        told = {'handlers': found, 'output': output}
        if told != (self._reported or {'handlers': [], 'output': []}):
            self._visitor.say('handlers', **told)
        self._reported = told

    def _describe(
        self, handlers: list[Any], started: dict[int, Any]
    ) -> list[Json]:
        describer = Describer(
            self._visitor.positions.of,
            self._context.launch_configurations,
            started,
        )
        for handler in handlers:
            # what it starts is to be there when its time comes
            self.name_packages(describer, entities_of(handler), handler)
        return [one for one in map(describer.handler, handlers) if one]

    def _is_heard(self, number: int, action: Any) -> bool:
        """Return whether a handler wants the output of a process."""
        if not self._listeners:
            return False
        if number not in self._heard:
            events = [self._output(action, 1), self._output(action, 2)]
            self._heard[number] = any(
                matches_event(one, event)
                for one in self._listeners
                for event in events
            )
        return self._heard[number]

    def name_packages(
        self, describer: Describer, entities: Any, of: Any
    ) -> None:
        """Report the packages that entities visited later need."""
        for name, place in describer.packages(entities, of):
            position = self._visitor.positions.of(place)
            self._visitor.packages.name(name, position)

    # what happened

    def _started(self, event: Json) -> None:
        action = self._visitor.started.get(event['process'])
        if action is None:
            return
        self._over.discard(event['process'])
        details = action.process_details
        details['pid'] = event['pid']
        _set_transport(action, event['pid'], None)
        self.queue.put_nowait(processes.ProcessStarted(**details))
        self.handle_all()

    def _exited(self, event: Json) -> None:
        number, returncode = event['process'], event['returncode']
        action = self._running().get(number)
        if action is None:
            return
        _set_transport(action, action.process_details.get('pid'), returncode)
        if event['asked'] and not self._is_ending:
            # what a launch file says of an end does not hold for one that
            # somebody has asked for, who may start the process again
            if number not in self._stopped:
                return
            self._stopped.discard(number)
        exited = processes.ProcessExited(
            returncode=returncode, **_details(action)
        )
        self.queue.put_nowait(exited)
        on_exit: Any = getattr(action, '_ExecuteLocal__on_exit', None)
        if is_shutdown(on_exit) and not self._is_ending:
            # one or several, for which the end of this process ends the launch
            actions = getattr(on_exit, '__iter__', lambda: [on_exit])()
            self._shutdowns += [one.event for one in actions]

        def complete() -> None:
            if not event['respawns']:
                self._over.add(number)
                getattr(action, _COMPLETED).set_result()

        self.handle_all(complete)

    def _wrote(self, event: Json) -> None:
        action = self._running().get(event['process'])
        if action is None:
            return
        stream = 2 if event['stream'] == 'stderr' else 1
        text = event['text'].encode(errors='surrogateescape')
        self.queue.put_nowait(self._output(action, stream, text))
        self.handle_all()

    def _changed(self, event: Json) -> None:
        node = event['node']
        actions = [a for a in self._lifecycles() if a.node_name == node]
        if not actions:
            return
        action = actions[0]
        messages = importlib.import_module('lifecycle_msgs.msg')
        lifecycle = importlib.import_module('launch_ros.events.lifecycle')
        message = messages.TransitionEvent()
        valid = lifecycle.ChangeState.valid_states
        numbers = {
            name.rpartition('_STATE_')[2].lower(): number
            for number, name in valid.items()
        }
        # rcl_lifecycle leaves the transition empty
        for state, label in (
            (message.start_state, event.get('from')),
            (message.goal_state, event['to']),
        ):
            state.label = label or ''
            state.id = numbers.get(state.label, 0)
        name = valid.get(message.goal_state.id)
        action._LifecycleNode__current_state = name
        changed = lifecycle.StateTransition(action=action, msg=message)
        self.queue.put_nowait(changed)
        self.handle_all()

    def _ended(self, event: Json) -> None:
        if self._is_ending:
            return
        self._is_ending = True
        asked, self._shutdowns = self._shutdowns, []
        if event.get('by_sigint') or not asked:
            # as LaunchService does when it is not a launch file that ends it
            self._context._set_is_shutdown(True)
            by_sigint = bool(event.get('by_sigint'))
            shutdown = events.Shutdown(
                reason=_SIGINT if by_sigint else event['reason'],
                due_to_sigint=by_sigint,
            )
            asked.insert(0, shutdown)
        for one in asked:
            self.queue.put_nowait(one)
        self.handle_all()

    # the loop of LaunchService

    def handle_all(
        self, after_first: Callable[[], object] | None = None
    ) -> None:
        """
        Handle the events that there are, and those that these lead to.

        :param after_first: Is called once the first one is handled
        :raises Exception: the first that a handler raises; the others are
          handled all the same, and the launch ends, as in ROS 2
        """
        error: Exception | None = None
        while not self.queue.empty():
            event, self._origin = self.queue.pop()
            try:
                self._handle(event)
            except Exception as e:  # noqa: BLE001 - anything of the user's
                error = error or e
            if after_first is not None:
                after_first()
                after_first = None
        self._origin = None
        if error is not None:
            if self._visitor.is_running:
                self.end_for(error)
            raise error

    def _handle(self, event: Any) -> None:
        if isinstance(event, events.Shutdown) and not self._is_ending:
            # its handlers are called when the launcher says so
            self._shutdowns.append(event)
            self.report_shutdown(event)
            return
        context = self._context
        for handler in tuple(context._event_handlers):
            if not handler.matches(event):
                continue
            context._push_locals()
            try:
                entities = handler.handle(event, context)
                if not isinstance(entities, Iterable):
                    entities = (entities,)
                for entity in entities:
                    if entity is None:
                        continue
                    if not isinstance(entity, LaunchDescriptionEntity):
                        raise RuntimeError(
                            'expected a LaunchDescriptionEntity from '
                            f"event_handler, got '{entity}'"
                        )
                    self._visitor.positions.pass_on(handler, entity)
                    self._visitor.visit(entity)
            finally:
                context._pop_locals()

    def end_for(self, error: Exception) -> None:
        """End the launch for an exception, as LaunchService does."""
        self.report_handlers()
        if self._is_ending:
            return
        self._context._set_is_shutdown(True)
        shutdown = events.Shutdown(
            reason=f'Caught exception in launch (see debug for traceback): '
            f'{error}'
        )
        self._shutdowns.append(shutdown)
        reason = f'a launch file raised {type(error).__name__}'
        self._visitor.say('shutdown', reason=reason)

    def report_shutdown(self, event: Any) -> None:
        """Request the end of the launch."""
        reason = event.reason
        if not isinstance(reason, str):
            reason = self._visitor.text_of(reason)
        self._visitor.say('shutdown', reason=reason)

    # what ROS 2 itself does about events

    def _on(
        self, kind: Any, do: Callable[[Any], object], action: Any = None
    ) -> None:
        def handle(event: Any, _context: object) -> None:
            do(event)

        handler = BaseEventHandler(
            matcher=lambda event: (
                isinstance(event, kind)
                and (action is None or event.action is action)
            )
        )
        setattr(handler, OF_WORKER, True)
        handler.handle = handle
        self._context.register_event_handler(handler)

    def _keep_output(self, action: Any, event: Any) -> None:
        name = 'stderr' if event.from_stderr else 'stdout'
        buffer = getattr(action, f'_ExecuteLocal__{name}_buffer')
        buffer.write(event.text.decode(errors='replace'))

    def _signal_process(self, event: Any) -> None:
        number = event.signal
        if isinstance(number, str):
            number = signal.Signals[number]
        self._report_signal(event, int(number))

    def _report_signal(self, event: Any, number: int) -> None:
        for process, action in self._running().items():
            if event.process_matcher(action):
                if number == 0:
                    self._stopped.add(process)
                self._visitor.say(
                    'signal',
                    process=process,
                    signal=number,
                    position=self._origin,
                )

    def _change_state(self, event: Any) -> None:
        transition = TRANSITIONS.get(event.transition_id)
        for action in self._lifecycles():
            if not event.lifecycle_node_matcher(action):
                continue
            if transition is None:
                name = event.valid_transitions[event.transition_id]
                text = (
                    f"Failed to make transition '{name}' for LifecycleNode "
                    f"'{action.node_name}'"
                )
                self._visitor.say('message', level='ERROR', text=text)
                continue
            self._visitor.say(
                'change_state',
                node=action.node_name,
                transition=transition,
                position=self._origin,
            )

    def _running(self) -> dict[int, Any]:
        """Return the actions of processes that have not ended for good."""
        started = self._visitor.started.items()
        return {n: a for n, a in started if n not in self._over}

    def _lifecycles(self) -> list[Any]:
        """Return the actions of lifecycle nodes, the last one first."""
        actions = self._running().values()
        found = [one for one in actions if is_a(one, 'LifecycleNode')]
        return found[::-1]

    def _output(self, action: Any, stream: int, text: bytes = b'') -> Any:
        kinds = {1: processes.ProcessStdout, 2: processes.ProcessStderr}
        return kinds[stream](text=text, **_details(action))


def _set_transport(
    action: Any, pid: int | None, returncode: int | None
) -> None:
    """Set what `launch` keeps of a process that was started."""
    action._subprocess_transport = SimpleNamespace(
        get_pid=lambda: pid, get_returncode=lambda: returncode
    )


def _details(action: Any) -> Json:
    """
    Return what events tell of a process.

    One that is executed once more loses its process id (`launch`,
    `ExecuteLocal.execute`), while the process of the first time may run.
    """
    return {'pid': None, **action.process_details}


def _matches(matcher: Callable[[Any], object], action: object) -> bool:
    try:
        return bool(matcher(action))
    except Exception:  # noqa: BLE001 - it may be anyone's
        return False
