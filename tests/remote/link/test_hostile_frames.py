# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Whatever a machine sends, the launch goes on, at worst without it."""

import json
import os
from typing import Any

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.state import to_json
from colcon_yamllaunch.remote.connection.machine_connection import Facts
from colcon_yamllaunch.remote.connection.machine_connection import StartedPart
from colcon_yamllaunch.remote.deployment.machine import Machine
from colcon_yamllaunch.remote.link.machine_link import MachineLink
from colcon_yamllaunch.remote.link.remote_part import RemotePart
from colcon_yamllaunch.remote.wire import frames
from colcon_yamllaunch.remote.wire.event_codec import FROM_MACHINES
from colcon_yamllaunch.remote.wire.part_settings import PartSettings
from hypothesis import given
from hypothesis import strategies as st
import pytest
from support.played_machine import plan
from support.played_machine import PlayedLaunch

LABEL = 'arm│driver'
FACTS = Facts('3.12', '', '', '', '', '/', None, False, 0.0)
CONTROL = ('ack', 'resumed', 'clock', 'echo', 'age', 'killed', 'reply')
MESSAGE = (
    *('event', 'states', 'idle', 'reply', 'error', 'usage', 'description'),
    *('modes', 'dropped', 'failed', 'ended', 'time'),
)
_HUGE = st.integers(-(10**400), 10**400)
_SMALL = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-2, 300),
    _HUGE,
    st.floats(),
    st.text(max_size=5),
    st.sampled_from([LABEL, *(kind.__name__ for kind in FROM_MACHINES)]),
)
_FIELDS = st.sampled_from(
    (
        *('event', 'process', 'pid', 'outcome', 'seconds', 'asked', 'failed'),
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


def _contents(keys: tuple[str, ...]) -> st.SearchStrategy[dict[str, Any]]:
    return st.dictionaries(st.sampled_from(keys), _VALUES, max_size=3)


_OUTPUT = st.one_of(
    st.binary(max_size=30),
    st.floats().map(
        lambda time: frames.output_body(LABEL, 'stdout', b'x\n', time)
    ),
)
SENT = st.one_of(
    st.tuples(st.just(frames.CONTROL), _contents(CONTROL)),
    st.tuples(st.just(frames.MESSAGE), _contents(MESSAGE)),
    st.tuples(st.sampled_from([frames.OUTPUT, frames.ECHO]), _OUTPUT),
)


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

    def tell(self, event: events.Event) -> None:
        json.dumps(event.record())
        list(event.lines())
        super().tell(event)


def _sent(sent: list[tuple[int, Any]]) -> tuple[RemotePart, _Launch]:
    """Return what became of a part whose machine has sent something."""
    # an allocation is not connected with again
    machine = Machine('arm', 'slurm', ())
    started: Any = StartedPart(
        machine, _Process(), 'i', 'b', b'', FACTS, PartSettings('arm')
    )  # type: ignore[arg-type]
    link = MachineLink(started, {})
    part = RemotePart(link, plan(LABEL))
    launch = _Launch()
    launch.loop = Loop()
    try:
        part.begin(launch, os.terminal_size((80, 24)))
        for _ in range(2):
            part.measure(bool)
            part.describe(LABEL, bool)
        link._feed(frames.message({'resumed': 0}))
        number = 0
        for kind, content in sent:
            if part.is_over:
                break
            number += kind != frames.CONTROL
            body = content
            if not isinstance(content, bytes):
                body = frames.json_body(content)
            at = 0 if kind == frames.CONTROL else number
            link._feed(frames.encode(kind, body, at))
            part.advance()
            to_json(launch.state)
            part.states.usage()
        return part, launch
    finally:
        part.close()
        launch.loop.close()


@pytest.mark.hostile
@given(st.lists(SENT, max_size=5))
def test_any_frames_of_a_machine_harm_no_launch(
    sent: list[tuple[int, Any]],
) -> None:
    part, launch = _sent(sent)
    gone = [e for e in launch.told if isinstance(e, events.MachineGone)]
    assert len(gone) <= 1
    assert all('\n' not in line for e in gone for line in e.lines())
    assert part.is_over == bool(gone) or part.state == 'done'


@pytest.mark.hostile
@pytest.mark.parametrize(
    'kind, content, reason',
    [
        (frames.CONTROL, {'ack': 10**60}, 'no object in JSON'),
        (frames.CONTROL, {'ack': 10**18}, 'more than it was sent'),
        (frames.CONTROL, {'ack': -1}, 'more than it was sent'),
        (frames.CONTROL, {'resumed': 10**60}, 'no object in JSON'),
        (frames.CONTROL, {'resumed': 10**18}, 'more than it was sent'),
        (frames.CONTROL, {'clock': 10**400}, 'no object in JSON'),
        (frames.CONTROL, {'clock': 1, 'echo': 10**400}, 'no object in JSON'),
        (frames.MESSAGE, {'time': 10**400, 'idle': True}, 'no object in JSO'),
        (frames.MESSAGE, {'time': float('inf'), 'idle': True}, 'no object'),
        (
            frames.MESSAGE,
            {
                'event': {
                    'event': 'Exited',
                    'process': LABEL,
                    'pid': 1,
                    'outcome': [None, 0, False],
                    'seconds': 1.0,
                    'asked': False,
                    'failed': True,
                }
            },
            "'outcome' of the event Exited is not what it should be",
        ),
    ],
)
def test_a_machine_that_sends_nonsense_is_dropped(
    kind: int, content: dict[str, Any], reason: str
) -> None:
    part, _ = _sent([(kind, content)])
    assert part.state == 'gone'
    assert reason in part.reason
