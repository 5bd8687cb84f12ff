# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Objects of `launch` and event handlers, as text and as JSON."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
import contextlib
from functools import partial
import math
import os
from typing import Any

from .channel import Json


def is_a(thing: Any, *kinds: str) -> bool:
    """Return whether an object has a class of ROS 2 with such a name."""
    return any(cls.__name__ in kinds for cls in type(thing).__mro__)


def as_written(substitutions: Any) -> str:
    """Return substitutions as a launch file in YAML would write them."""
    if isinstance(substitutions, str):
        return substitutions
    if not isinstance(substitutions, Iterable):
        substitutions = [substitutions]
    return ''.join(_one(substitution) for substitution in substitutions)


# substitutions of one argument: the name in YAML, and the attribute with it
_WRITTEN = {
    'LaunchConfiguration': ('var', 'variable_name'),
    'EnvironmentVariable': ('env', 'name'),
    'FindPackageShare': ('find-pkg-share', 'package'),
    'FindPackage': ('find-pkg-share', 'package'),
    'NotSubstitution': ('not', 'value'),
}


def _one(substitution: Any) -> str:
    if isinstance(substitution, str):
        return substitution
    kind = type(substitution).__name__
    if kind == 'TextSubstitution':
        return str(substitution.text)
    if kind == 'PythonExpression':
        return f"$(eval '{as_written(substitution.expression)}')"
    if kind == 'PathJoinSubstitution':
        return '/'.join(map(as_written, substitution.substitutions))
    if kind in _WRITTEN:
        name, attribute = _WRITTEN[kind]
        return f'$({name} {as_written(getattr(substitution, attribute))})'
    if kind in ('ThisLaunchFile', 'ThisLaunchFileDir'):
        return '$(filename)' if kind == 'ThisLaunchFile' else '$(dirname)'
    left = getattr(substitution, 'left', None)
    if left is not None and hasattr(substitution, 'right'):
        name = kind.replace('Substitution', '').lower()
        return f'$({name} {as_written(left)} {as_written(substitution.right)})'
    try:
        return str(substitution.describe())
    except Exception:  # noqa: BLE001 - it may be anyone's
        return f'$({kind})'


def condition_text(condition: Any) -> str:
    """Return a condition as a launch file in YAML would write it."""
    kind = type(condition).__name__
    word = 'unless' if kind == 'UnlessCondition' else 'if'
    for cls in type(condition).__mro__:
        start = f'_{cls.__name__}__'
        expression = getattr(condition, f'{start}predicate_expression', None)
        if expression is not None:
            return f'{word}: {as_written(expression)}'
        left = getattr(condition, f'{start}launch_configuration_name', None)
        if left is not None:
            value = getattr(condition, f'{start}expected_value', None)
            sign = '!=' if 'Not' in kind else '=='
            return f'if: $(var {left}) {sign} {as_written(value or "")}'
    return f'if: {kind}'


def as_json(value: Any) -> Any:
    """Return the value of a parameter as JSON has it, `.inf` for infinity."""
    if isinstance(value, bool):
        return value
    if isinstance(value, float):
        if math.isnan(value):
            return '.nan'
        if math.isinf(value):
            return '.inf' if value > 0 else '-.inf'
        return value
    if isinstance(value, (str, int)) or value is None:
        return value
    if isinstance(value, (bytes, bytearray)):
        return list(value)
    if hasattr(value, 'tolist'):
        return as_json(value.tolist())
    if isinstance(value, dict):
        return {str(name): as_json(one) for name, one in value.items()}
    if isinstance(value, Iterable):
        items = list(value)
        if items and all(isinstance(one, bytes) for one in items):
            # an array of bytes in a message
            return list(b''.join(items))
        return [as_json(one) for one in items]
    return str(value)


#: The attribute that the event handlers of this program have.
OF_WORKER = '_launch_worker_handler'
#: What the numbers of lifecycle_msgs/msg/Transition ask for.
TRANSITIONS = {
    1: 'configure',
    2: 'cleanup',
    3: 'activate',
    4: 'deactivate',
    5: 'shutdown',
    6: 'shutdown',
    7: 'shutdown',
}
#: The names of the classes of events, and what the protocol calls them.
_EVENTS = {
    'ProcessStarted': 'start',
    'ProcessExited': 'exit',
    'ProcessIO': 'output',
    'ExecutionComplete': 'complete',
    'Shutdown': 'shutdown',
    'StateTransition': 'state',
}
_WHEN = {
    'start': 'starts',
    'exit': 'ends',
    'output': 'writes',
    'complete': 'is done',
    'state': 'is',
}
#: The reason of a shutdown for which none is given.
_NO_REASON = 'reason not given'
#: How the modules of `launch` start: what they do is no action of users.
_LAUNCH = ('launch.', 'launch_ros.')


class Describer:
    """
    Describes event handlers, and actions that may never be visited.

    :param position_of: Returns where an action or event handler was made
    :param configurations: The launch configurations
    :param processes: The actions of all processes there are, by their number
    """

    def __init__(
        self,
        position_of: Callable[[Any], Any],
        configurations: Mapping[str, Any],
        processes: Mapping[int, Any],
    ) -> None:
        self._position_of = position_of
        self._configurations = configurations
        self._processes = processes

    def handler(self, handler: Any) -> Json | None:
        """Return what the protocol says of a handler, None for nothing."""
        if hasattr(handler, OF_WORKER):
            return None
        functions, entities = _done_by(handler)
        actions = [*map(_call, filter(_is_users, functions))]
        actions += self.actions(entities)
        if not actions and (functions or entities):
            # such as the last one of a LifecycleTransition
            return None
        return {
            'event': _kind(handler),
            'processes': self._matched(handler),
            'condition': _condition(handler),
            'actions': actions,
            'position': self._position_of(handler),
        }

    def actions(self, entities: Any) -> list[str]:
        """Return a line for each thing that entities do."""
        if entities is None:
            return []
        if isinstance(entities, Iterable):
            return [line for one in entities for line in self.actions(one)]
        condition = getattr(entities, 'condition', None)
        end = f' ({condition_text(condition)})' if condition else ''
        return [f'{line}{end}' for line in self._lines(entities)]

    def packages(self, entities: Any, of: Any) -> Iterator[tuple[str, Any]]:
        """
        Iterate over the packages that entities name, and what names them.

        :param of: What has the entities, an action or event handler
        """
        pending = deque([(entities, of)])
        seen = set()
        while pending:
            thing, place = pending.popleft()
            if id(thing) in seen:
                continue
            seen.add(id(thing))
            if isinstance(thing, dict):
                pending += [(one, place) for one in thing.values()]
            elif isinstance(thing, (list, tuple, set)):
                pending += [(one, place) for one in thing]
            elif f'{type(thing).__module__}.'.startswith(_LAUNCH):
                if hasattr(thing, 'execute') or is_a(thing, 'ComposableNode'):
                    place = thing
                elif hasattr(thing, 'handle'):
                    pending.append((entities_of(thing), place))
                for name in ('node_package', 'package'):
                    text = self._text(getattr(thing, name, None))
                    if text and '$' not in text:
                        yield text, place
                parts = getattr(thing, '__dict__', {}).values()
                pending += [(one, place) for one in parts]

    def name(self, action: Any) -> str:
        """Return what to call an action that may never be visited."""
        for attribute in ('_Node__node_name', '_Node__node_executable'):
            text = self._text(getattr(action, attribute, None))
            if text:
                return text
        description = getattr(action, 'process_description', None)
        text = self._text(getattr(description, 'name', None))
        if text:
            return text
        command = getattr(description, 'cmd', None) or ()
        words = self._text(command[0]).split() if command else ()
        return os.path.basename(words[0]) if words else type(action).__name__

    def _lines(self, entity: Any) -> Iterator[str]:
        private = Private(entity)
        if is_a(entity, 'LoadComposableNodes'):
            parts = private.composable_node_descriptions or ()
            target = private.target_container
            box = self._text(target) or self.name(target)
            plural = '' if len(parts) == 1 else 's'
            yield f'load {len(parts)} component{plural} into {box}'
        elif is_a(entity, 'ExecuteLocal'):
            yield f'start {self.name(entity)}'
        elif is_a(entity, 'TimerAction'):
            lines = self.actions(entity.actions)
            yield f'after {self._text(entity.period)} s: {", ".join(lines)}'
        elif is_a(entity, 'GroupAction'):
            yield from self.actions(private.actions)
        elif is_a(entity, 'LaunchDescription'):
            yield from self.actions(entity.entities)
        elif is_a(entity, 'IncludeLaunchDescription'):
            source = entity.launch_description_source
            location = self._text(Private(source).location)
            yield f'include {os.path.basename(location) or "a description"}'
        elif is_a(entity, 'EmitEvent'):
            yield self._emitted(entity.event)
        elif is_a(entity, 'LogInfo'):
            yield f'say "{self._text(entity.msg)}"'
        elif is_a(entity, 'RegisterEventHandler'):
            inner = self.handler(entity.event_handler)
            if inner is not None:
                yield _nested(inner, self._names(inner['processes']))
        elif is_a(entity, 'UnregisterEventHandler'):
            yield 'unregister an event handler'
        elif is_a(entity, 'OpaqueFunction', 'OpaqueCoroutine'):
            function = private.function or private.coroutine
            if _is_users(function):
                yield _call(function)
        elif is_a(entity, 'LifecycleTransition'):
            numbers = map(self._text, private.transition_ids or ())
            steps = [_transition(number) for number in numbers]
            names = map(self._text, private.lifecycle_node_names or ())
            yield f'{", ".join(steps)} {", ".join(names)}'
        elif is_a(entity, 'SetLaunchConfiguration'):
            name, value = map(self._text, (entity.name, entity.value))
            yield f"set '{name}' to '{value}'"
        else:
            yield type(entity).__name__

    def _emitted(self, event: Any) -> str:
        kind = type(event).__name__
        if kind == 'Shutdown':
            reason = self._text(event.reason)
            end = '' if reason in ('', _NO_REASON) else f': {reason}'
            return f'shut down{end}'
        if kind == 'ShutdownProcess':
            return f'stop {self._targets(event.process_matcher)}'
        if kind == 'SignalProcess':
            targets = self._targets(event.process_matcher)
            return f'send {event.signal_name} to {targets}'
        if kind == 'ChangeState':
            targets = self._targets(event.lifecycle_node_matcher)
            return f'{_transition(event.transition_id)} {targets}'
        return f'emit {kind}'

    def _targets(self, matcher: Any) -> str:
        for value in _closure(matcher).values():
            if isinstance(value, str):
                return value
            if hasattr(value, 'execute'):
                return self.name(value)
        return ', '.join(self._names(self._found(matcher)))

    def _matched(self, handler: Any) -> list[object] | None:
        """Return numbers or names of what a handler waits for."""
        matcher = Private(handler).action_matcher
        if _kind(handler) == 'state':
            states = _closure(Private(handler).matcher)
            matcher = states.get('target_lifecycle_node')
            name = states.get('node_name')
            if matcher is None and name is not None:
                return [
                    number
                    for number, action in self._processes.items()
                    if getattr(action, 'node_name', None) == name
                ] or [name]
        if matcher is None:
            return None
        if callable(matcher):
            return self._found(matcher)
        for number, action in self._processes.items():
            if action is matcher:
                return [number]
        if hasattr(matcher, 'process_description'):
            return [self.name(matcher)]
        return [*self._lines(matcher)]

    def _found(self, matcher: Callable[[Any], object]) -> list[object]:
        found: list[object] = []
        for number, action in self._processes.items():
            try:
                if matcher(action):
                    found.append(number)
            except Exception:  # noqa: BLE001 - it may be anyone's
                pass
        return found or [f'what {_function(matcher)} matches']

    def _names(self, processes: Any) -> list[str]:
        return [
            self.name(self._processes[one]) if isinstance(one, int) else one
            for one in processes or ()
        ]

    def _text(self, substitutions: Any) -> str:
        """Return substitutions with the launch configurations that are set."""
        if substitutions is None:
            return ''
        if isinstance(substitutions, (str, int, float)):
            return str(substitutions)
        if isinstance(substitutions, Iterable):
            return ''.join(map(self._text, substitutions))
        name = getattr(substitutions, 'variable_name', None)
        if type(substitutions).__name__ == 'LaunchConfiguration':
            value = self._configurations.get(as_written(name))
            if isinstance(value, str):
                return value
        return as_written(substitutions)


class Private:
    """The private attributes of an object of `launch`; None for others."""

    def __init__(self, of: Any) -> None:
        self._of = of

    def __getattr__(self, name: str) -> Any:
        for kind in type(self._of).__mro__:
            try:
                return getattr(self._of, f'_{kind.__name__}__{name}')
            except AttributeError:
                pass
        return None


def entities_of(handler: Any) -> Any:
    """Return what a handler does, as far as that is no function."""
    return _done_by(handler)[1]


def may_hear(handler: Any) -> bool:
    """Return whether a handler may be about the output of processes."""
    return not hasattr(handler, OF_WORKER) and (
        _kind(handler) in ('output', 'other')
    )


def may_match_later(handler: Any) -> bool:
    """Return whether a handler may match an event at another time."""
    return _kind(handler) == 'other' or callable(
        Private(handler).action_matcher
    )


def matches_event(handler: Any, event: Any) -> bool:
    """Return whether a handler matches an event."""
    try:
        return bool(handler.matches(event))
    except Exception:  # noqa: BLE001 - it may be anyone's
        return False


def _kind(handler: Any) -> str:
    cls = Private(handler).target_event_cls
    if cls is not None:
        names = [one.__name__ for one in cls.__mro__]
    elif is_a(handler, 'OnStateTransition'):
        names = ['StateTransition']
    elif is_a(handler, 'OnShutdown'):
        names = ['Shutdown']
    else:
        names = []
    return next((_EVENTS[name] for name in names if name in _EVENTS), 'other')


def _done_by(handler: Any) -> tuple[list[Any], Any]:
    """Return the functions that a handler calls, and its entities."""
    private = Private(handler)
    entities = private.actions_on_event or getattr(handler, 'entities', None)
    if entities:
        return [], entities
    function = private.on_event or private.on_shutdown
    if function is None:
        return ([] if entities is not None else [handler.handle]), entities
    if _is_users(function):
        return [function], None
    # the functions of OnProcessIO, and the entities of OnShutdown
    values = list(_closure(function).values())
    functions = [value for value in values if callable(value)]
    others = [v for v in values if v is not None and not callable(v)]
    return [
        f for i, f in enumerate(functions) if f not in functions[:i]
    ], others


def _condition(handler: Any) -> str:
    kind = _kind(handler)
    matcher = Private(handler).matcher
    known = _closure(matcher)
    parts = []
    if kind == 'state':
        names = ('transition', 'start_state', 'goal_state')
        transition, start, goal = (
            as_written(known.get(n) or '') for n in names
        )
        if transition:
            parts.append(transition)
        if start:
            parts.append(f'{start} to {goal}' if goal else f'from {start}')
        elif goal:
            parts.append(goal)
    elif kind == 'other' and matcher is not None:
        name = known.get('name')
        parts.append(name if isinstance(name, str) else _function(matcher))
    if getattr(handler, 'handle_once', False):
        parts.append('once')
    return ', '.join(parts)


def _nested(inner: Json, names: list[str]) -> str:
    what = ', '.join(names) or 'anything'
    when = _WHEN.get(inner['event'])
    condition = f' {inner["condition"]}' if inner['condition'] else ''
    if inner['event'] == 'shutdown':
        start = f'at shutdown{condition}'
    elif when is None:
        start = f'on{condition}'
    else:
        start = f'when {what} {when}{condition}'
    return f'{start}: {", ".join(inner["actions"])}'


def _transition(number: object) -> str:
    text = str(number)
    known = TRANSITIONS.get(int(text)) if text.isdigit() else None
    return known or f'transition {text}'


def _closure(function: Any) -> dict[str, Any]:
    """Return the variables that a function has from where it was made."""
    names = getattr(getattr(function, '__code__', None), 'co_freevars', ())
    cells = getattr(function, '__closure__', None) or ()
    found = {}
    for name, cell in zip(names, cells, strict=False):
        with contextlib.suppress(ValueError):
            found[name] = cell.cell_contents
    return found


def _plain(function: Any) -> Any:
    """Return what a partial function or a method stands for."""
    while isinstance(function, partial):
        function = function.func
    return getattr(function, '__func__', function)


def _is_users(function: Any) -> bool:
    module = getattr(_plain(function), '__module__', None) or ''
    return not f'{module}.'.startswith(_LAUNCH)


def _call(function: Any) -> str:
    return f'call {_function(function)}'


def _function(function: Any) -> str:
    plain = _plain(function)
    code = getattr(plain, '__code__', None)
    name = getattr(plain, '__name__', type(plain).__name__)
    name = 'lambda' if name == '<lambda>' else name
    if code is None:
        return str(name)
    file = os.path.basename(code.co_filename)
    return f'{name} ({file}:{code.co_firstlineno})'
