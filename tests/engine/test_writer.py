# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import errno
import io
import os
from pathlib import Path
import socket

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.writer import TextWriter, Writer
import pytest


@pytest.fixture
def pipe():
    reader, writer = os.pipe()
    ends = {'reader': reader, 'writer': writer}
    yield ends
    for descriptor in ends.values():
        os.close(descriptor)


@pytest.fixture
def to_pipe(pipe):
    made = Writer(pipe['writer'])
    yield made
    made.close()


def socket_pair():
    return [end.detach() for end in socket.socketpair()]


@pytest.mark.parametrize('kind', [os.pipe, socket_pair])
def test_who_reads_slowly_is_not_waited_for_and_loses_nothing(kind):
    reader, descriptor = kind()
    writer = Writer(descriptor)
    data = os.urandom(3_000_000)
    writer.write('a', data)
    writer.flush()
    assert writer.waits()
    received = bytearray()
    while len(received) < len(data):
        received += os.read(reader, 100_000)
        writer.flush()
    assert received == data
    assert not writer.waits()
    writer.close()
    os.close(reader)
    os.close(descriptor)


def test_only_who_floods_has_to_wait(to_pipe, pipe):
    to_pipe.write('flood', b'x' * (limits.STREAM_BACKLOG_BYTES + 200_000))
    to_pipe.flush()
    assert not to_pipe.accepts('flood')
    assert to_pipe.accepts('quiet')
    while to_pipe.waits():
        os.read(pipe['reader'], 100_000)
        to_pipe.flush()
    assert to_pipe.accepts('flood')


def test_all_together_do_not_use_more_than_the_limit(to_pipe):
    data = b'x' * 100_000
    written = 0
    while any(to_pipe.accepts(key) for key in range(10)):
        for key in range(10):
            if to_pipe.accepts(key):
                to_pipe.write(key, data)
                written += len(data)
    assert written <= limits.SCREEN_BACKLOG_BYTES + 10 * len(data)


@pytest.mark.hostile
def test_many_streams_together_do_not_use_more_than_the_maximum(to_pipe):
    data = b'x' * limits.STREAM_BACKLOG_BYTES
    written = 0
    for key in range(2 * limits.SCREEN_MAXIMUM_BYTES // len(data)):
        if to_pipe.accepts(key):
            to_pipe.write(key, data)
            written += len(data)
    assert written == limits.SCREEN_MAXIMUM_BYTES


def test_a_pipe_without_a_reader_breaks_quietly(to_pipe, pipe):
    os.close(pipe.pop('reader'))
    to_pipe.write('a', b'x')
    to_pipe.flush()
    assert to_pipe.broken
    assert not to_pipe.waits()
    to_pipe.write('a', b'x')
    assert not to_pipe.waits()


def test_a_pipe_that_had_no_reader_from_the_start_breaks_too(pipe):
    os.close(pipe.pop('reader'))
    writer = Writer(pipe['writer'])
    writer.write('a', b'x')
    writer.flush()
    assert writer.broken
    assert writer.error is None
    writer.close()


def test_a_file_takes_everything_at_once(tmp_path):
    path = tmp_path / 'file'
    with path.open('ab') as file:
        writer = Writer(file.fileno())
        writer.write('a', b'x' * 10_000_000)
        writer.flush()
        assert not writer.waits()
        writer.close()
    assert path.stat().st_size == 10_000_000


@pytest.mark.skipif(not Path('/dev/full').exists(), reason='needs /dev/full')
def test_a_full_disk_does_not_end_anything():
    descriptor = os.open('/dev/full', os.O_WRONLY)
    writer = Writer(descriptor)
    writer.write('a', b'x')
    with pytest.raises(OSError, match=os.strerror(errno.ENOSPC)):
        os.write(descriptor, b'x')
    writer.flush()
    assert not writer.broken
    assert not writer.waits()
    # but it is not forgotten
    assert writer.error is not None
    assert writer.error.errno == errno.ENOSPC
    writer.close()
    os.close(descriptor)


@pytest.mark.hostile
def test_a_file_that_cannot_be_written_breaks_with_an_error(tmp_path):
    path = tmp_path / 'file'
    path.touch()
    descriptor = os.open(path, os.O_RDONLY)
    writer = Writer(descriptor)
    writer.write('a', b'x')
    writer.flush()
    assert writer.broken
    assert writer.error is not None
    writer.close()
    os.close(descriptor)


def test_a_stream_without_a_descriptor_is_written_to_directly():
    stream = io.StringIO()
    writer = TextWriter(stream)
    writer.write('a', b'a\xff\n')
    assert stream.getvalue() == 'a\ufffd\n'
    assert writer.accepts('a')
