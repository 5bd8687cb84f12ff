# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What a rule of a deployment file sets for the processes that it matches.

:data:`SETTINGS` has one reader for each key. A reader returns the value of the
field that has the name of the key: of `MemberSettings` or `ResourceLimits`
(`plan.member_settings`), or of the plan's process.
"""

from collections.abc import Callable, Mapping
import json
import math
import re
from typing import Any, get_args

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.deployment import values
from colcon_yamllaunch.deployment.values import wrong_value
from colcon_yamllaunch.language.syntax import yaml_reader
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar, Value
from colcon_yamllaunch.plan.member_settings import (
    BEYOND_LIMIT,
    ON_TIMEOUT,
    Policy,
    ReadyCondition,
    ReadyKind,
    Restart,
    RESTART_WHEN,
    Scheduling,
    UNLIMITED_RESTARTS,
)
from colcon_yamllaunch.plan.plan import OUTPUT_MODES, TRANSITIONS
from colcon_yamllaunch.plan.position import Position

#: What `restart` does with a process that keeps failing, unless it says.
_FIRST_DELAY = 0.5
_LONGEST_DELAY = 30.0

_READY_HINT = (
    'ready: {topic: NAME}, {service: NAME}, {lifecycle: active}, '
    '{log: EXPRESSION}, {port: NUMBER}, {file: PATH}, {command: COMMAND} or '
    '{after: SECONDS}, or a list of these'
)
#: A number of bytes.
SIZE = re.compile(r'(\d+(?:\.\d+)?)\s*([KMGT]?)i?B?', re.IGNORECASE)
_UNITS = {'': 1, 'K': 1 << 10, 'M': 1 << 20, 'G': 1 << 30, 'T': 1 << 40}
_CPUS = re.compile(r'(\d+)(?:-(\d+))?')
#: As many processors as a set of them has in Linux (`CPU_SETSIZE`).
MAXIMUM_CPUS = 1024
#: The states that a lifecycle node may have to be in.
STATES = sorted({t.goal for t in TRANSITIONS.values()} - {'finalized'})


@dataclass(frozen=True, slots=True)
class Pattern:
    """
    A name or glob that names other processes.

    :param length: How many characters it has in the file
    """

    text: str
    position: Position
    length: int


def _patterns(value: Value, key: str) -> tuple[Pattern, ...]:
    items = [value]
    if isinstance(value, yaml_reader.Sequence):
        items = list(value.items)
    if not items:
        hint = f'{key}: [NAME, …]'
        raise wrong_value(f"'{key}' names nothing", value, hint)
    return tuple(
        Pattern(text, item.position, len(text))
        for item in items
        for text in [values.pattern(item, f"a name in '{key}'")]
    )


def _after(value: Value) -> tuple[Pattern, ...]:
    if isinstance(value, yaml_reader.Sequence) and not value.items:
        # it waits for nothing, whatever a rule below says
        return ()
    return _patterns(value, 'after')


def _ready(value: Value) -> tuple[ReadyCondition, ...]:
    if isinstance(value, yaml_reader.Sequence):
        if not value.items:
            raise wrong_value("'ready' is empty", value, _READY_HINT)
        return tuple(_ready_condition(item) for item in value.items)
    return (_ready_condition(value),)


def _ready_condition(value: Value) -> ReadyCondition:
    if isinstance(value, Scalar) and value.text == 'running':
        return ReadyCondition('running')
    pairs = values.pairs_of(value, "'ready'", _READY_HINT)
    values.check_keys(pairs, (*CONDITIONS, 'message'), "'ready'")
    kinds = [kind for kind in CONDITIONS if kind in pairs]
    if not kinds:
        raise wrong_value("'ready' has no condition", value, _READY_HINT)
    if len(kinds) > 1:
        key, _ = pairs[kinds[1]]
        hint = (
            f'for both, write a list: [{{{kinds[0]}: …}}, {{{kinds[1]}: …}}]'
        )
        both = f"'ready' has both '{kinds[0]}' and '{kinds[1]}'"
        raise wrong_value(both, key, hint)
    kind = kinds[0]
    message = False
    if 'message' in pairs:
        key, given = pairs['message']
        message = values.flag(given, 'message')
        if kind != 'topic':
            hint = 'remove it: only a topic has messages'
            raise wrong_value(f"'{kind}' has no 'message'", key, hint)
    return ReadyCondition(
        kind, message=message, **CONDITIONS[kind](pairs[kind][1])
    )


def _name(key: str, hint: str) -> Callable[[Value], dict[str, Any]]:
    return lambda value: {'name': values.text(value, f"'{key}'", hint)}


def _parameter(value: Value) -> dict[str, Any]:
    hint = 'parameter: {name: NAME, equals: VALUE}'
    pairs = values.pairs_of(value, "'parameter'", hint)
    values.check_keys(pairs, ('name', 'equals'), "'parameter'")
    for key in ('name', 'equals'):
        if key not in pairs:
            raise wrong_value(f"'parameter' has no '{key}'", value, hint)
    wanted = pairs['equals'][1]
    if not isinstance(wanted, Scalar):
        message = "'equals' is not a text, number or boolean"
        raise wrong_value(message, wanted, hint)
    return {
        'name': values.text(pairs['name'][1], "'name'", hint),
        'value': json.dumps(wanted.value),
    }


def _transform(value: Value) -> dict[str, Any]:
    hint = 'transform: [map, base_link]'
    if not isinstance(value, yaml_reader.Sequence) or len(value.items) != 2:
        raise wrong_value("'transform' is not two frames", value, hint)
    frames = [values.text(v, 'a frame', hint) for v in value.items]
    return {'name': frames[0], 'value': frames[1]}


def _log(value: Value) -> dict[str, Any]:
    text = values.text(value, "'log'", 'log: a regular expression')
    try:
        re.compile(text)
    except re.error as e:
        message = f"'{text}' is no regular expression: {e}"
        raise wrong_value(message, value, 'log: ready to serve') from e
    return {'name': text}


def _port(value: Value) -> dict[str, Any]:
    hint = 'port: 7447, or port: HOST:7447'
    text = values.text(value, "'port'", hint)
    host, _, port = text.rpartition(':')
    if not port.isdecimal() or not 0 < int(port) < 1 << 16:
        raise wrong_value(f"'port' has no value '{text}'", value, hint)
    return {'name': f'{host}:{port}' if host else port}


#: What a readiness condition of each kind says; see `ReadyCondition`.
CONDITIONS: Mapping[ReadyKind, Callable[[Value], dict[str, Any]]] = {
    'topic': _name('topic', 'topic: scan'),
    'service': _name('service', 'service: get_map'),
    'action': _name('action', 'action: navigate_to_pose'),
    'node': _name('node', 'node: /driver'),
    'lifecycle': lambda v: {'name': values.choice(v, 'lifecycle', STATES)},
    'parameter': _parameter,
    'transform': _transform,
    'log': _log,
    'port': _port,
    'file': _name('file', 'file: /run/robot/ready'),
    'command': _name('command', 'command: test -e /dev/lidar'),
    'after': lambda v: {'seconds': values.seconds(v, 'after')},
}


def _restart(value: Value) -> tuple[Restart, tuple[Pattern, ...]]:
    """Return the restarts of a process, and what is restarted with it."""
    if isinstance(value, Scalar):
        when = values.choice(value, 'restart', RESTART_WHEN)
        return _restart_of(when), ()
    pairs = values.pairs_of(value, "'restart'", 'restart: failure')
    values.check_keys(pairs, RESTART_KEYS, "'restart'")
    given = {key: content for key, (_, content) in pairs.items()}
    restart = _restart_of(
        values.choice(given['when'], 'when', RESTART_WHEN)
        if 'when' in given
        else 'failure'
    )
    fields: dict[str, Any] = {}
    if 'max' in given:
        fields['limit'] = values.whole_number(given['max'], 'max', 0, 1e6)
    if 'window' in given:
        fields['window'] = values.seconds(given['window'], 'window')
    if 'delay' in given:
        fields |= _delays(given['delay'])
    if 'then' in given:
        fields['beyond'] = values.choice(given['then'], 'then', BEYOND_LIMIT)
    if 'command' in given:
        hint = 'command: usbreset 1234:5678'
        fields['command'] = values.words(
            given['command'], 'command', 'a word', hint
        )
    together: tuple[Pattern, ...] = ()
    if 'with' in given:
        together = _patterns(given['with'], 'with')
    return _restart_of(restart.when, **fields), together


#: The keys of `restart` if it is a mapping.
RESTART_KEYS = ('when', 'max', 'window', 'delay', 'then', 'with', 'command')


def _restart_of(when: Any, **fields: Any) -> Restart:
    return Restart(
        when,
        **{
            'limit': UNLIMITED_RESTARTS,
            'first_delay': _FIRST_DELAY,
            'longest_delay': _LONGEST_DELAY,
            **fields,
        },
    )


def _delays(value: Value) -> dict[str, float]:
    hint = 'delay: SECONDS, or delay: [FIRST, LONGEST]'
    if not isinstance(value, yaml_reader.Sequence):
        delay = values.seconds(value, 'delay')
        return {'first_delay': delay, 'longest_delay': delay}
    if len(value.items) != 2:
        raise wrong_value("'delay' is not two times", value, hint)
    first, longest = (values.seconds(v, 'delay') for v in value.items)
    if longest < first:
        message = 'the longest delay is shorter than the first one'
        raise wrong_value(message, value.items[1], hint)
    return {'first_delay': first, 'longest_delay': longest}


def _size(value: Value, key: str) -> int:
    hint = f'{key}: 200M, 2G or a number of bytes'
    text = values.text(value, f"'{key}'", hint)
    match = SIZE.fullmatch(text.strip())
    size = 0
    if match is not None:
        size = int(float(match[1]) * _UNITS[match[2].upper()])
    if not 0 < size < 1 << 62:
        raise wrong_value(f"'{key}' has no value '{text}'", value, hint)
    return size


def _cpu(value: Value) -> float:
    def read(text: str) -> float:
        if text.endswith('%'):
            return float(text[:-1]) / 100
        return float(text)

    return values.number(
        value, 'cpu', 0.01, MAXIMUM_CPUS, what='150%, or a number', read=read
    )


def _cpus(value: Value) -> tuple[int, ...]:
    hint = 'cpus: 2-3, or cpus: [0, 2]'
    items = [value]
    if isinstance(value, yaml_reader.Sequence):
        items = list(value.items)
    found: set[int] = set()
    for item in items:
        for text in values.text(item, "'cpus'", hint).split(','):
            match = _CPUS.fullmatch(text.strip())
            first = int(match[1]) if match else -1
            last = int(match[2] or match[1]) if match else -1
            if not 0 <= first <= last < MAXIMUM_CPUS:
                message = f"'cpus' has no value '{text}'"
                raise wrong_value(message, item, hint)
            found.update(range(first, last + 1))
    if not found:
        raise wrong_value("'cpus' is empty", value, hint)
    return tuple(sorted(found))


def _scheduling(value: Value) -> Scheduling:
    hint = (
        'scheduling: {fifo: PRIORITY}, {rr: PRIORITY} or '
        '{deadline: [RUNTIME, DEADLINE, PERIOD]}'
    )
    pairs = values.pairs_of(value, "'scheduling'", hint)
    policies: tuple[Policy, ...] = get_args(Policy)
    values.check_keys(pairs, policies, "'scheduling'")
    if len(pairs) != 1:
        raise wrong_value("'scheduling' is not one policy", value, hint)
    policy = next(p for p in policies if p in pairs)
    given = pairs[policy][1]
    if policy != 'deadline':
        return Scheduling(
            policy, priority=values.whole_number(given, policy, 1, 99)
        )
    if not isinstance(given, yaml_reader.Sequence) or len(given.items) != 3:
        raise wrong_value("'deadline' is not three times", given, hint)
    times = [values.seconds(v, 'deadline', 1e-6) for v in given.items]
    # as sched_setattr(2) wants them
    if times != sorted(times):
        message = 'not runtime ≤ deadline ≤ period'
        raise wrong_value(message, given, hint)
    return Scheduling(
        policy, runtime=times[0], deadline=times[1], period=times[2]
    )


#: The scores of `oom: first` and `oom: last` (proc_pid_oom_score_adj(5)).
_OOM = {'first': 1000, 'last': -1000}


def _oom(value: Value) -> int:
    if isinstance(value, Scalar) and value.text in _OOM:
        return _OOM[value.text]
    return int(
        values.number(
            value,
            'oom',
            -1000,
            1000,
            what='last, first, or a whole number',
            read=int,
        )
    )


def _environment(value: Value) -> tuple[tuple[str, str], ...]:
    hint = 'env: {NAME: VALUE, …}'
    names, given = values.variables(value, hint)
    if names:
        message = f"the variable '{names[0]}' has no value"
        raise wrong_value(message, value, hint)
    return given


def _directory(value: Value) -> str:
    hint = 'an absolute path, or one that begins in the home folder: ~/data'
    text = values.text(value, "'directory'", hint)
    if not text.startswith('/') and text != '~' and not text.startswith('~/'):
        raise wrong_value(f"'directory' has no value '{text}'", value, hint)
    return text


def _seconds(key: str) -> Callable[[Value], float]:
    return lambda value: values.seconds(value, key)


def _flag(key: str) -> Callable[[Value], bool]:
    return lambda value: values.flag(value, key)


def _whole(key: str, lowest: int, highest: float) -> Callable[[Value], int]:
    return lambda value: values.whole_number(value, key, lowest, highest)


#: What a process is set, by its key.
SETTINGS: Mapping[str, Callable[[Value], Any]] = {
    'ready': _ready,
    'after': _after,
    'ready_timeout': _seconds('ready_timeout'),
    'on_timeout': lambda v: values.choice(v, 'on_timeout', ON_TIMEOUT),
    'restart': _restart,
    'critical': _flag('critical'),
    'optional': _flag('optional'),
    'memory': lambda v: _size(v, 'memory'),
    'memory_high': lambda v: _size(v, 'memory_high'),
    'cpu': _cpu,
    'cpus': _cpus,
    'io': _whole('io', 1, 10000),
    'tasks': _whole('tasks', 1, math.inf),
    'nice': _whole('nice', -20, 19),
    'scheduling': _scheduling,
    'oom': _oom,
    'env': _environment,
    'user': lambda v: values.text(v, "'user'", 'user: robot'),
    'directory': _directory,
    'output': lambda v: values.choice(v, 'output', OUTPUT_MODES),
}
#: Those that a component has, too; all others belong to its container.
COMPONENT_SETTINGS = ('ready', 'after', 'ready_timeout', 'on_timeout')
#: The readiness conditions that a component cannot have, as its output and
#: environment are those of its container.
PROCESS_CONDITIONS: tuple[ReadyKind, ...] = ('log', 'command')
#: Those that are fields of `ResourceLimits`.
LIMITS = (
    'memory',
    'memory_high',
    'cpu',
    'cpus',
    'io',
    'tasks',
    'nice',
    'scheduling',
    'oom',
)
