# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Frames are what was sent, or refused."""

import random
import zlib

from colcon_yamllaunch.remote.wire import frames
from colcon_yamllaunch.remote.wire.frames import Frame
from colcon_yamllaunch.remote.wire.frames import FrameError
from colcon_yamllaunch.remote.wire.frames import FrameReader
from hypothesis import given
from hypothesis import strategies as st
import pytest

KINDS = (
    frames.MESSAGE,
    frames.OUTPUT,
    frames.ECHO,
    frames.CONTROL,
    frames.STREAM,
)


@given(
    st.lists(
        st.tuples(
            st.sampled_from(KINDS),
            st.integers(0, (1 << 64) - 1),
            st.binary(max_size=3000),
            st.booleans(),
        ),
        max_size=5,
    ),
    st.integers(1, 500),
)
def test_frames_arrive_in_any_pieces(
    sent: list[tuple[int, int, bytes, bool]], size: int
) -> None:
    data = b''.join(
        frames.encode(kind, body, number, packed=packed)
        for kind, number, body, packed in sent
    )
    reader = FrameReader()
    found = [
        frame
        for start in range(0, len(data), size)
        for frame in reader.feed(data[start : start + size])
    ]
    assert found == [Frame(k, n, body) for k, n, body, _ in sent]
    assert reader.rest == b''


@given(st.binary(max_size=200), st.integers(0, 10_000))
def test_damage_is_refused_or_waits(noise: bytes, where: int) -> None:
    data = frames.encode(frames.MESSAGE, b'{"a": 1}' * 100, 7, packed=True)
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
def test_few_bytes_do_not_become_many() -> None:
    body = zlib.compress(bytes(frames.MAXIMUM_BODY + 1), 9)
    fields = frames._FIELDS.pack(b'cl', frames.MESSAGE, 1, len(body), 1)
    data = fields + zlib.crc32(fields).to_bytes(4, 'big') + body + b'\n'
    with pytest.raises(FrameError, match='too long'):
        list(FrameReader().feed(data))


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
        Frame(frames.MESSAGE, 1, body).content()


@given(st.text(max_size=20), st.binary(max_size=50), st.floats(0, 1e10))
def test_output_is_what_was_written(
    label: str, data: bytes, seconds: float
) -> None:
    label = label.encode('utf-8', 'ignore').decode()
    body = frames.output_body(label, 'stderr', data, seconds)
    assert frames.read_output(body) == (label, 'stderr', data, seconds)


@given(st.binary(max_size=40))
def test_output_of_any_form_is_read_or_refused(body: bytes) -> None:
    try:
        frames.read_output(body)
    except FrameError:
        return


def test_random_bytes_are_refused_soon() -> None:
    data = random.Random(1).randbytes(1000)
    with pytest.raises(FrameError):
        list(FrameReader().feed(data))
