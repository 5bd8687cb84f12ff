# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is sent arrives once and in order, whatever connections do."""

from pathlib import Path
import tempfile

from colcon_yamllaunch.remote.wire import frames
from colcon_yamllaunch.remote.wire import numbered
from colcon_yamllaunch.remote.wire.frames import Frame
from colcon_yamllaunch.remote.wire.frames import FrameError
from colcon_yamllaunch.remote.wire.frames import FrameReader
from colcon_yamllaunch.remote.wire.numbered import Inbox
from colcon_yamllaunch.remote.wire.numbered import Outbox
from hypothesis import given
from hypothesis import strategies as st
import pytest

STEPS = st.lists(
    st.sampled_from(['add', 'add', 'add', 'send', 'acknowledge', 'lose']),
    max_size=60,
)


@given(STEPS, st.booleans())
def test_nothing_is_lost_or_twice(steps: list[str], spools: bool) -> None:
    with (
        tempfile.TemporaryDirectory() as name,
        pytest.MonkeyPatch.context() as m,
    ):
        # so that much goes to the file
        m.setattr(numbered, 'WINDOW', 40)
        outbox = Outbox(Path(name) if spools else None)
        inbox, reader = Inbox(), FrameReader()
        sent: list[bytes] = []
        got: list[bytes] = []

        def receive(size: int) -> None:
            for frame in reader.feed(outbox.take(size)):
                if inbox.is_new(frame):
                    got.append(frame.body)

        for step in steps:
            if step == 'add':
                sent.append(f'body {len(sent)}'.encode())
                assert outbox.add(frames.OUTPUT, sent[-1])
            elif step == 'send':
                receive(50)
            elif step == 'acknowledge':
                outbox.acknowledged(inbox.last)
            else:
                # what was under way is gone
                outbox.take(50)
                reader = FrameReader()
                outbox.resume(inbox.last)
        outbox.resume(inbox.last)
        while not outbox.is_empty:
            receive(1000)
            outbox.acknowledged(inbox.last)
        outbox.close()
        assert got == sent
        assert not any(Path(name).iterdir())


def test_output_without_room_is_counted_and_messages_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(numbered, 'WINDOW', 100)
    outbox = Outbox(tmp_path, limit=200)
    added = [outbox.add(frames.OUTPUT, bytes(50)) for _ in range(10)]
    assert added == [True] * 5 + [False] * 5
    assert outbox.dropped == 250
    assert outbox.add(frames.MESSAGE, b'{"important": 1}')
    reader = FrameReader()
    found: list[Frame] = []
    while not outbox.is_empty:
        found += reader.feed(outbox.take(1000))
        outbox.acknowledged(found[-1].number)
    assert [f.number for f in found] == list(range(1, 7))
    assert found[-1].content() == {'important': 1}


def test_a_full_disk_loses_no_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(numbered, 'WINDOW', 10)
    outbox = Outbox(tmp_path / 'missing')
    outbox.add(frames.OUTPUT, bytes(20))
    assert not outbox.add(frames.OUTPUT, bytes(20))
    assert outbox.add(frames.MESSAGE, b'{}')
    found = list(FrameReader().feed(outbox.take(1000)))
    assert [f.kind for f in found] == [frames.OUTPUT, frames.MESSAGE]


def test_a_missing_frame_is_noticed() -> None:
    inbox = Inbox()
    assert inbox.is_new(Frame(frames.MESSAGE, 1, b''))
    assert not inbox.is_new(Frame(frames.MESSAGE, 1, b''))
    with pytest.raises(FrameError, match='missing'):
        inbox.is_new(Frame(frames.MESSAGE, 3, b''))


@pytest.mark.hostile
@pytest.mark.parametrize('number', [2, 10**60, -1])
def test_frame_that_was_not_sent_is_not_acknowledged(number: int) -> None:
    outbox = Outbox()
    for _ in range(2):
        outbox.add(frames.MESSAGE, b'{}')
    outbox.take(1)
    outbox.acknowledged(1)
    for acknowledge in (outbox.acknowledged, outbox.resume):
        with pytest.raises(FrameError):
            acknowledge(number)
    assert not outbox.is_empty
