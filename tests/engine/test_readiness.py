# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Waiting for descriptors."""

from collections.abc import Iterator
import fcntl
import os
import resource
import socket

from colcon_yamllaunch.engine.loop import readable
import pytest

#: The first one that does not fit into an fd_set (select(2)).
HIGH = 1024


@pytest.fixture
def many_descriptors() -> Iterator[None]:
    """Allow more descriptors than `select` takes."""
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    if before[1] <= HIGH:
        pytest.skip('no process may have so many descriptors here')
    limits = max(before[0], HIGH + 64), before[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, limits)
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, before)


@pytest.mark.usefixtures('many_descriptors')
def test_a_high_descriptor() -> None:
    reader, writer = os.pipe()
    high = fcntl.fcntl(reader, fcntl.F_DUPFD, HIGH)
    try:
        assert readable([high], 0.0) == []
        os.write(writer, b'x')
        assert readable([high]) == [high]
    finally:
        for descriptor in (reader, writer, high):
            os.close(descriptor)


def test_what_is_ready_is_returned_and_so_is_an_end() -> None:
    first, second = socket.socketpair()
    third, fourth = socket.socketpair()
    with first, second, third:
        fourth.close()
        assert readable([first, second, third]) == [third]
        second.send(b'x')
        assert set(readable([first, second, third])) == {first, third}
