# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Keys are read from a terminal."""

from collections.abc import Iterator
import os
import select
import signal
import tty

from colcon_yamllaunch.terminal.keyboard import Keyboard
import pytest


class _Ready:
    """A poll that finds everything readable."""

    def register(self, descriptor: int, mask: int) -> None:
        pass

    def poll(self, _: int) -> bool:
        return True


@pytest.fixture
def terminal() -> Iterator[tuple[int, int]]:
    """Return both ends of a terminal in raw mode."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    yield ours, theirs
    os.close(ours)
    os.close(theirs)


def test_read_does_not_block_if_keys_are_dropped_after_poll(
    terminal: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    def give_up(*_: object) -> None:
        raise AssertionError('it waits for keys')

    ours, theirs = terminal
    monkeypatch.setattr(select, 'poll', _Ready)
    before = signal.signal(signal.SIGALRM, give_up)
    signal.alarm(30)
    try:
        assert Keyboard(theirs).keys() == b''
        os.write(ours, b'ab')
        assert Keyboard(theirs).keys() == b'ab'
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
