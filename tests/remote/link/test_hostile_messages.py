# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Whatever a machine sends, the launch goes on, at worst without it."""

import json
import os
from typing import Any
import zlib

from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.deployment.deployment import Machine
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.commands import Describe
from colcon_yamllaunch.engine.event_codec import FROM_MACHINES
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.state import to_json
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineFacts,
    read_message,
    StartedPart,
)
from colcon_yamllaunch.remote.machine_link import MachineLink
from colcon_yamllaunch.remote.part_protocol import PartSettings
from colcon_yamllaunch.remote.remote_part import RemotePart
from hypothesis import given
from hypothesis import strategies as st
import pytest
from support.played_machine import plan, PlayedLaunch

LABEL = 'arm│driver'
FACTS = MachineFacts('', '/', None, False, 0.0)
KEYS = (
    *('event', 'ok', 'id', 'error', 'usage', 'description', 'time', 'asked'),
    *('modes', 'missed', 'output', 'shown', 'packed', 'killed', 'clock'),
)
_HUGE = st.integers(-(10**400), 10**400)
_SMALL = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-2, 300),
    _HUGE,
    st.floats(),
    st.text(max_size=5),
    st.sampled_from([LABEL, *FROM_MACHINES]),
)
_FIELDS = st.sampled_from(
    (
        *('event', 'process', 'pid', 'outcome', 'seconds', 'asked', 'failed'),
        *('bytes', 'events', 'at', 'stream', 'time', 'data', 'exit_code'),
        *('respawn_delay', 'signal', 'label', 'phase', 'lines', 'echo', 'ros'),
        *('processes', 'components', 'environment', 'argv', 'text', LABEL),
    )
)
_VALUES = st.recursive(
    _SMALL,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(st.one_of(_FIELDS, st.text()), inner, max_size=8),
    ),
    max_leaves=8,
)


_OUTPUT = st.floats().map(
    lambda time: protocol.encode_raw(
        'output',
        {'process': LABEL, 'stream': 'stdout', 'time': time, 'at': 0},
        b'x\n',
    )
)
SENT = st.one_of(
    st.dictionaries(st.sampled_from(KEYS), _VALUES, max_size=3).map(
        lambda content: json.dumps(content).encode() + b'\n'
    ),
    st.binary(max_size=30),
    _OUTPUT,
)
ANSWER = {'ok': True, 'id': 'subscribed', 'asked': 0}


class _Process:
    """A connection whose other end says nothing by itself."""

    pid = 0
    status = 0
    messages = ''

    def __init__(self) -> None:
        self._its_input, self.stdin = os.pipe()
        self.stdout, self._its_output = os.pipe()
        self.stderr, self._its_errors = os.pipe()

    def leave_to_guard(self) -> None:
        return

    def close_pipes(self) -> None:
        for name in ('stdin', 'stdout', 'stderr', '_its_input'):
            os.close(getattr(self, name))
        os.close(self._its_output)
        os.close(self._its_errors)


class _Launch(PlayedLaunch):
    """A launch that shows and records all that it is told."""

    def emit(self, event: events.Event) -> None:
        json.dumps(event.record())
        list(event.lines())
        super().emit(event)


def _sent(
    sent: list[bytes], answer: Any = ANSWER
) -> tuple[RemotePart, _Launch]:
    """Return what became of a part whose machine has sent something."""
    # an allocation is not connected with again
    machine = Machine('arm', 'slurm', ())
    started: Any = StartedPart(
        machine,
        _Process(),
        'i',
        'b',
        protocol.MessageReader(read_message),
        FACTS,
        PartSettings('arm'),
        {},
    )
    link = MachineLink(started)
    part = RemotePart(link, plan(LABEL))
    launch = _Launch()
    launch.loop = Loop()
    try:
        part.join(launch)
        part.begin(os.terminal_size((80, 24)))
        for _ in range(2):
            part.measure(bool)
            part.ask(Describe(LABEL), bool)
        link._feed(protocol.encode({'relay': True}))
        link._feed(protocol.encode(answer))
        for data in sent:
            if part.is_over:
                break
            link._feed(data)
            launch.loop.wake()
            launch.loop.run_once()
            to_json(launch.state)
        return part, launch
    finally:
        part.close()
        launch.loop.close()


@pytest.mark.hostile
@given(st.lists(SENT, max_size=5))
def test_any_messages_of_a_machine_harm_no_launch(sent: list[bytes]) -> None:
    part, launch = _sent(sent)
    gone = [e for e in launch.told if isinstance(e, events.MachineGone)]
    assert len(gone) <= 1
    assert all('\n' not in line for e in gone for line in e.lines())
    assert part.is_over == bool(gone) or part.link_state == 'done'


EXITED = {
    'event': 'exited',
    'label': LABEL,
    'pid': 1,
    'exit_code': None,
    'signal': None,
    'core_dumped': False,
    'seconds': 1.0,
    'asked': False,
    'failed': True,
}


@pytest.mark.hostile
@pytest.mark.parametrize(
    'message, reason',
    [
        ({'clock': 10**400, 'ok': True}, 'no object in JSON'),
        ({'clock': 1.0, 'ok': True}, 'answers what nobody asked'),
        ({'event': {'time': 10**400}}, 'no object in JSON'),
        ({'event': {'time': float('inf')}}, 'no object in JSON'),
        ({'output': {'process': LABEL}}, 'output has a wrong form'),
        ({'output': {'bytes': 1 << 40}}, 'wrong number of bytes'),
        ({'packed': 1}, 'has no bytes'),
        ({'event': EXITED}, "'outcome' of the event exited is not what"),
        ({'something': 'else'}, 'a message is of no known kind'),
    ],
)
def test_a_machine_that_sends_nonsense_is_dropped(
    message: dict[str, Any], reason: str
) -> None:
    part, _ = _sent([json.dumps(message).encode() + b'\n'])
    assert part.link_state == 'gone'
    assert reason in part.reason


@pytest.mark.hostile
@pytest.mark.parametrize('asked', [-1, 10**18, 10**60, 'a', None])
def test_a_machine_that_executed_too_much_is_dropped(asked: Any) -> None:
    part, _ = _sent([], {**ANSWER, 'asked': asked})
    assert part.link_state == 'gone'


@pytest.mark.hostile
def test_few_bytes_do_not_become_many() -> None:
    data = zlib.compress(bytes(protocol.MAXIMUM_MESSAGE + 1), 9)
    part, _ = _sent([protocol.encode_raw('packed', {}, data)])
    assert part.link_state == 'gone'
    assert 'too long' in part.reason
