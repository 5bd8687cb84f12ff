# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Frames are what was sent, or refused."""

import random

from colcon_yamllaunch.remote.connection import frames
from colcon_yamllaunch.remote.connection.frames import Frame
from colcon_yamllaunch.remote.connection.frames import FrameError
from colcon_yamllaunch.remote.connection.frames import FrameReader
from hypothesis import given
from hypothesis import strategies as st
import pytest

KINDS = (frames.CONTROL, frames.STREAM)


@given(
    st.lists(
        st.tuples(
            st.sampled_from(KINDS),
            st.binary(max_size=3000),
        ),
        max_size=5,
    ),
    st.integers(1, 500),
)
def test_frames_arrive_in_any_pieces(
    sent: list[tuple[int, bytes]], size: int
) -> None:
    data = b''.join(frames.encode(kind, body) for kind, body in sent)
    reader = FrameReader()
    found = [
        frame
        for start in range(0, len(data), size)
        for frame in reader.feed(data[start : start + size])
    ]
    assert found == [Frame(kind, body) for kind, body in sent]
    assert reader.rest == b''


@given(st.binary(max_size=200), st.integers(0, 10_000))
def test_damage_is_refused_or_waits(noise: bytes, where: int) -> None:
    data = frames.encode(frames.CONTROL, b'{"a": 1}' * 100)
    at = where % len(data)
    damaged = data[:at] + noise + data[at:]
    try:
        found = list(FrameReader().feed(damaged))
        for frame in found:
            frame.content()
    except FrameError:
        return
    assert len(found) <= 1


@pytest.mark.hostile
@pytest.mark.parametrize(
    'body',
    [
        *(b'[]', b'null', b'{', b'\xff', b'[' * 100_000, b'9' * 10_000),
        b'{"a": 1' + b'0' * 60 + b'}',
        b'{"a": {"b": -' + b'9' * 400 + b'}}',
        *(b'{"a": 1e999}', b'{"a": NaN}', b'{"a": -Infinity}'),
    ],
)
def test_a_message_that_is_no_object_is_refused(body: bytes) -> None:
    with pytest.raises(FrameError):
        Frame(frames.CONTROL, body).content()


def test_random_bytes_are_refused_soon() -> None:
    data = random.Random(1).randbytes(1000)
    with pytest.raises(FrameError):
        list(FrameReader().feed(data))
