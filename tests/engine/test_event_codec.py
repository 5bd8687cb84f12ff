# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import dataclasses
import json
import signal
import types
import typing

from colcon_yamllaunch.engine import event_codec, events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.plan import Component, Process
from colcon_yamllaunch.plan.position import Position
from hypothesis import given
from hypothesis import strategies as st
import pytest

_POSITION = Position('/ws/demo.yaml', 3, 5)
DRIVER = Process('arm│driver', ('driver',), '/', _POSITION, 'driver-3')
TALKER = Component('arm│talker', 'demo', 'demo::Talker', '/box', _POSITION)
MEMBERS = {member.label: member for member in (DRIVER, TALKER)}
READER = event_codec.EventReader(MEMBERS.get)

_TEXTS = st.text(st.characters(min_codepoint=0x20, max_codepoint=0x7E))
_OUTCOMES = st.one_of(
    st.builds(Outcome, st.integers(0, 255)),
    st.builds(Outcome, st.none(), st.integers(1, 64), st.booleans()),
    st.builds(Outcome, st.integers(1, 255), limit=_TEXTS),
)
_SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text()
_JSON = st.recursive(
    _SCALARS | st.sampled_from([*MEMBERS, *event_codec.FROM_MACHINES]),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=10,
)


def values(hint, name):
    """Return a strategy for a field of an event."""
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin in (types.UnionType, typing.Union):
        return st.one_of(*(values(a, name) for a in arguments))
    if origin is tuple:
        return st.lists(values(arguments[0], name), max_size=3).map(tuple)
    if origin is typing.Literal:
        return st.sampled_from(arguments)
    if name == 'level':
        return st.sampled_from(['INFO', 'ERROR'])
    if name in ('signal', 'next_signal') and hint is int:
        return st.integers(1, signal.NSIG - 1)
    return {
        Process: st.just(DRIVER),
        Component: st.just(TALKER),
        Outcome: _OUTCOMES,
        int: st.integers(0, 1 << 30),
        float: st.floats(0, 1e9).map(lambda value: round(value, 6)),
        str: _TEXTS,
        bool: st.booleans(),
        types.NoneType: st.none(),
    }[hint]


@st.composite
def told(draw):
    """Draw an event that a machine tells."""
    kind = draw(st.sampled_from([*event_codec.FROM_MACHINES.values()]))
    hints = typing.get_type_hints(kind)
    names = (field.name for field in dataclasses.fields(kind))
    fields = [name for name in names if name not in kind.unrecorded]
    return kind(**{f: draw(values(hints[f], f)) for f in fields})


@given(told())
def test_an_event_comes_back_as_it_was(event):
    data = json.loads(json.dumps(event.to_json()))
    assert READER.read(data) == event


@given(told(), st.data())
def test_what_a_machine_makes_up_is_refused_or_can_be_shown(event, data):
    made_up = event.to_json()
    key = data.draw(st.sampled_from(sorted(made_up)))
    made_up[key] = data.draw(_JSON)
    try:
        result = READER.read(made_up)
    except event_codec.EventError as error:
        assert '\n' not in str(error)
    else:
        json.dumps(result.to_json())
        assert all('\x1b' not in line for line in result.lines())


@given(_JSON)
def test_other_json_is_refused(data):
    with pytest.raises(event_codec.EventError):
        READER.read(data)


def test_an_event_of_the_launcher_itself_is_refused():
    for kind in ('ended', '', 'machine_gone', 'Event', '__class__'):
        with pytest.raises(event_codec.EventError):
            READER.read({'event': kind})


def test_what_steers_a_terminal_is_taken_out():
    event = READER.read(
        {'event': 'warning', 'text': 'a\x1b[2Jb\x1b]0;title\x07c'}
    )
    assert event == events.Warned('abc')


@pytest.mark.parametrize(
    'data',
    [
        {'event': 'started', 'label': 'other', 'pid': 1},
        {'event': 'started', 'label': 'arm│talker', 'pid': 1},
        {'event': 'started', 'label': 'arm│driver', 'pid': True},
        {'event': 'started', 'label': 'arm│driver', 'pid': 1 << 60},
        {'event': 'started', 'label': 'arm│driver'},
        {'event': 'message', 'level': 'LOUD', 'text': ''},
        {'event': 'held', 'label': 'arm│driver', 'pid': 1, 'signal': 'SIG'},
        {'event': 'held', 'label': 'arm│driver', 'pid': 1, 'signal': 20},
        {'event': 'silent', 'label': 'arm│driver', 'seconds': float('inf')},
        {'event': 'planned', 'labels': 'arm│driver'},
        {'event': 'planned'},
        {'event': 'exited', 'label': 'arm│driver', 'pid': 1},
    ],
)
def test_malformed_events_are_refused(data):
    with pytest.raises(event_codec.EventError):
        READER.read(data)
