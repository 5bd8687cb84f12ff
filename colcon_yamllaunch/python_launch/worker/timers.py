# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What launch files do later.

What stands in a timer is visited ahead, in the scope where it stands, as far
as that comes to the same. The rest is postponed: the launcher gets a number
for it, and requests it when its time has come.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
import importlib
from itertools import count
import linecache
import os
from typing import Any, TYPE_CHECKING

from launch import Action, events
from launch.actions import TimerAction
from launch.utilities.type_utils import perform_typed_substitution

from .channel import Json
from .descriptions import Describer, is_a
from .entries import replace_method
from .events import Future
from .imports import when_imported
from .visit import Marker, set_environment

if TYPE_CHECKING:
    from .events import Events
    from .visit import Visitor


#: Actions of ROS 2 whose time matters.
_TIMELY = (
    'OpaqueFunction',
    'OpaqueCoroutine',
    'EmitEvent',
    'RegisterEventHandler',
    'UnregisterEventHandler',
)
#: Events of ROS 2 that ask the launcher for something when they are emitted.
_REQUESTS = ('ChangeState', 'ShutdownProcess', 'SignalProcess')
#: What ends a scope that a group began.
_POPS = {'PopLaunchConfigurations': 0, 'PopEnvironment': 1}
_PUSHES = {'PushLaunchConfigurations': 0, 'PushEnvironment': 1}
#: The modules whose actions are known.
_KNOWN = ('launch.', 'launch_ros.', f'{__package__}.')


class _Scope:
    """
    What actions see where they stand.

    :param context: The launch context, in that scope
    """

    def __init__(self, context: Any) -> None:
        self._context = context
        self._configurations = dict(context.launch_configurations)
        self._environment = dict(os.environ)
        self._locals = dict(context.get_locals_as_dict())

    @contextmanager
    def entered(self) -> Iterator[None]:
        """Enter the scope; changes made meanwhile are kept."""
        context = self._context
        with _pushed(context):
            configurations = context.launch_configurations
            configurations.clear()
            configurations.update(self._configurations)
            set_environment(self._environment)
            context.extend_locals(self._locals)
            yield
            configurations = _changes(
                self._configurations, context.launch_configurations
            )
            variables = _changes(self._environment, os.environ)
        context.launch_configurations.update(configurations)
        os.environ.update(variables)


@contextmanager
def _pushed(context: Any) -> Iterator[None]:
    """Undo at the end of the context what actions set."""
    context._push_locals()
    context._push_environment()
    context._push_launch_configurations()
    try:
        yield
    finally:
        context._pop_launch_configurations()
        context._pop_environment()
        context._pop_locals()


class Timers:
    """
    What is left to a time that is still to come.

    :param visitor: Visits what stands in timers
    :param events: Takes what is emitted there
    """

    def __init__(self, visitor: Visitor, events: Events) -> None:
        self._visitor = visitor
        self._events = events
        self._calls: dict[int, tuple[_Scope, Callable[[], object]]] = {}
        self._numbers = count(1)
        #: The requests that are to be emitted at their time, and where they
        #: are emitted, by the number of the call.
        self._emitted: dict[int, tuple[Any, Any]] = {}
        #: Whether what is visited stands in a timer.
        self._is_ahead = False
        events.queue.handle_at_once = self._handle_at_once
        visitor.requests['finish'] = self.finish
        visitor.requests['call'] = self.call
        visitor.postpone = self.postpone
        visitor.forget.append(self.forget)

    def install(self) -> None:
        """Replace what timers of `launch` and `launch_ros` do."""
        replace_method(TimerAction, 'execute', self.execute)
        when_imported(
            'launch_ros.actions.ros_timer',
            # Humble has another name for it
            lambda module: replace_method(
                getattr(module, 'ROSTimer', None) or module.RosTimer,
                'execute',
                self.execute,
            ),
        )
        when_imported(
            'launch_ros.actions.lifecycle_transition',
            lambda module: replace_method(
                module.LifecycleTransition, 'execute', self.transit
            ),
        )

    def execute(
        self, _old: Callable[..., Any], timer: Any, context: Any
    ) -> None:
        """Report a timer, instead of `TimerAction.execute`."""
        timer._completed_future = done = Future()
        timer._canceled_future = cancelled = Future()
        cancelled.add_done_callback(done.set_result)
        if _is_cancelled(timer):
            done.set_result()
            return
        period = perform_typed_substitution(context, timer.period, float)
        is_dropped = getattr(timer, '_TimerAction__cancel_on_shutdown', True)
        if not isinstance(is_dropped, bool):
            is_dropped = perform_typed_substitution(context, is_dropped, bool)
        self._visitor.say(
            'begin',
            kind='timer',
            title=f'{period:g} s',
            position=self._visitor.position(timer),
            period=period,
            cancel_on_shutdown=is_dropped,
            # without simulated time, that of ROS is the system's
            on_ros_time=is_a(timer, 'ROSTimer', 'RosTimer')
            and self._visitor.scopes.uses_sim_time,
        )
        actions = list(timer.actions)
        complete = events.ExecutionComplete(action=timer)
        # the file that creates a timer may cancel one
        position = self._visitor.position(timer)
        lines = linecache.getlines(str(position[0])) if position else []
        if any('.cancel' in line for line in lines):
            self._leave(timer, lambda: self._fire(timer, actions), actions)
        else:
            outer, self._is_ahead = self._is_ahead, True
            try:
                with _pushed(context):
                    self._visit(actions)
            finally:
                self._is_ahead = outer
        if context.would_handle_event(complete):
            self._leave(timer, done.set_result)
        self._visitor.say('end')

    def call(self, request: Json) -> None:
        """Go on with what was left to its time."""
        self._visitor.is_running = True
        self._events.handle_all()
        scope, do = self._calls.pop(request['number'])
        try:
            with scope.entered():
                do()
        except Exception as e:
            self._events.end_for(e)
            raise
        self._events.handle_all()

    def finish(self, _request: Json) -> None:
        """Handle what was emitted; say what calls come to, where known."""
        self._events.handle_all()
        for number, (event, position) in self._emitted.items():
            if self._events.is_settled(event):
                del self._calls[number]
                self._visitor.say('begin', kind='settled', number=number)
                self._events.settle(event, position)
                self._visitor.say('end')
        self._emitted.clear()

    def transit(
        self, old: Callable[..., Any], action: Any, context: Any
    ) -> Any:
        """
        Emit all requests of a `LifecycleTransition` that stands in a timer.

        The launcher waits for each transition before the next one.
        """
        if not self._is_ahead:
            return old(action, context)
        lifecycle = importlib.import_module('launch_ros.events.lifecycle')
        names = action._LifecycleTransition__lifecycle_node_names
        numbers = action._LifecycleTransition__transition_ids
        for name in map(self._visitor.text_of, names):
            matcher = lifecycle.matches_node_name(name)
            for number in map(self._visitor.text_of, numbers):
                context.emit_event_sync(
                    lifecycle.ChangeState(
                        lifecycle_node_matcher=matcher,
                        transition_id=int(number),
                    )
                )
        return None

    def forget(self) -> None:
        """Begin anew."""
        self._calls.clear()
        self._emitted.clear()
        self._numbers = count(1)
        self._is_ahead = False

    def postpone(self, siblings: Sequence[Any]) -> bool:
        """
        Leave actions to their time, if that of the first one matters.

        :param siblings: The actions that are still to be visited, of a group,
          file or timer
        :returns: whether they were left, and the others visited
        """
        if not self._is_ahead or not self._needs_its_time(siblings[0]):
            return False
        later, now = split(siblings)
        self._leave(siblings[0], lambda: self._visit(later), later)
        for one in now:
            self._visitor.visit(one)
        return True

    def _visit(self, actions: Sequence[Any]) -> None:
        for index, action in enumerate(actions):
            if self.postpone(actions[index:]):
                break
            self._visitor.visit(action)

    def _fire(self, timer: Any, actions: Sequence[Any]) -> None:
        if not _is_cancelled(timer):
            self._visit(actions)

    def _leave(
        self, action: Any, do: Callable[[], object], actions: Any = None
    ) -> int:
        """Leave something to its time, and return the number of the call."""
        number = next(self._numbers)
        self._calls[number] = (_Scope(self._visitor.context), do)
        describer = Describer(
            self._visitor.positions.of,
            self._visitor.context.launch_configurations,
            {},
        )
        self._events.name_packages(describer, actions, action)
        lines = describer.actions(actions) or ['see to the timer']
        self._visitor.say(
            'call',
            number=number,
            title=', '.join(lines),
            position=self._visitor.position(action),
        )
        return number

    def _needs_its_time(self, entity: Any) -> bool:
        module = f'{type(entity).__module__}.'
        event = type(getattr(entity, 'event', None)).__name__
        ends_launch = module.startswith(_KNOWN) and event == 'Shutdown'
        if not isinstance(entity, Action) or ends_launch:
            return False
        is_timely = is_a(entity, *_TIMELY) and not (
            is_a(entity, 'EmitEvent') and _is_request(entity.event)
        )
        module = f'{type(entity).execute.__module__}.'
        if is_timely or not module.startswith(_KNOWN):
            return True
        if is_a(entity, 'ExecuteLocal', 'TimerAction'):
            return False
        complete = events.ExecutionComplete(action=entity)
        return bool(self._visitor.context.would_handle_event(complete))

    def _handle_at_once(self, event: Any) -> bool:
        if self._is_ahead and isinstance(event, events.Shutdown):
            self._events.report_shutdown(event)
            return True
        if not (self._is_ahead and _is_request(event)):
            return False
        action = self._visitor.entity
        number = self._leave(
            action, lambda: self._events.queue.put_nowait(event), action
        )
        self._emitted[number] = event, self._visitor.position(action)
        return True


def _is_request(event: Any) -> bool:
    module = f'{type(event).__module__}.'
    return type(event).__name__ in _REQUESTS and module.startswith(_KNOWN)


def _is_cancelled(timer: Any) -> bool:
    return bool(getattr(timer, '_TimerAction__canceled', False))


def split(siblings: Sequence[Any]) -> tuple[list[Any], list[Any]]:
    """
    Return which actions of a list wait for their time, and which do not.

    The latter end what was begun before: the scope of a group, its block.
    """
    later: list[Any] = []
    now: list[Any] = []
    depths = [0, 0]
    for one in siblings:
        name = type(one).__name__
        if name in _PUSHES:
            depths[_PUSHES[name]] += 1
        elif name in _POPS:
            if not depths[_POPS[name]]:
                now.append(one)
                continue
            depths[_POPS[name]] -= 1
        if isinstance(one, Marker):
            now.append(one)
        else:
            later.append(one)
    return later, now


def _changes(before: Any, after: Any) -> dict[str, Any]:
    return {k: v for k, v in after.items() if before.get(k) != v}
