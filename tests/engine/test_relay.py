# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import os

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.relay import Relay
import pytest
from support.test_loop import TestLoop


class Relayed:
    """A relay, the ends to write to, and what became of it."""

    def __init__(self, process):
        self.process = process
        self.loop = TestLoop()
        self.told = []
        self.recorded = {}
        self.refuses = False
        self.relay = Relay(
            self.loop, lambda _: not self.refuses, [self._record], self._tell
        )
        self.writers = []

    def add(self, label):
        """Return the ends that a process of this name writes to."""
        stdout, stderr = os.pipe(), os.pipe()
        self.writers += [stdout[1], stderr[1]]
        self.relay.add(
            len(self.writers), self.process(label), stdout[0], stderr[0]
        )
        return stdout[1], stderr[1]

    def turn(self):
        self.loop.turn(1)
        self.relay.resume()

    def close(self):
        for writer in self.writers:
            os.close(writer)
        self.relay.close()
        self.loop.close()

    def _record(self, process, stream, data):
        key = process.label, stream
        self.recorded[key] = self.recorded.get(key, b'') + data

    def _tell(self, event):
        self.told.append((event.process.label, event.data))


@pytest.fixture
def relayed(process):
    one = Relayed(process)
    yield one
    one.close()


def test_a_piece_is_recorded_before_its_line_ends(relayed):
    stdout, stderr = relayed.add('a')
    os.write(stdout, b'one\ntw')
    os.write(stderr, b'oops')
    relayed.turn()
    assert relayed.told == [('a', b'one\n')]
    assert relayed.recorded == {
        ('a', 'stdout'): b'one\ntw',
        ('a', 'stderr'): b'oops',
    }


@pytest.mark.hostile
def test_of_many_long_lines_the_longest_goes_in_pieces(relayed, monkeypatch):
    monkeypatch.setattr(limits, 'UNFINISHED_LINES_BYTES', 100_000)
    prompt, _ = relayed.add('prompt')
    os.write(prompt, b'name: ')
    writers = [relayed.add(f'p{n}')[0] for n in range(5)]
    for number in range(20):
        for n, writer in enumerate(writers):
            os.write(writer, b'x' * 1000 * (n + 1))
        relayed.turn()
        written = 15_000 * (number + 1) + len('name: ')
        passed = sum(len(data) for _, data in relayed.told)
        assert written - passed <= 100_000
    assert 'prompt' not in dict(relayed.told)
    assert 'p4' in dict(relayed.told)
    assert relayed.relay.unfinished('prompt') == b'name: '


@pytest.mark.hostile
def test_what_waits_for_the_screen_is_not_read(relayed):
    stdout, _ = relayed.add('a')
    relayed.refuses = True
    os.write(stdout, b'one\n')
    relayed.turn()
    relayed.turn()
    assert relayed.recorded == {}
    relayed.refuses = False
    relayed.turn()
    relayed.turn()
    assert relayed.told == [('a', b'one\n')]


def test_output_of_another_machine_is_cut_into_lines(relayed):
    there = relayed.process('arm│a')
    relayed.relay.feed(there, 'stdout', b'one\ntw')
    relayed.relay.feed(there, 'stderr', b'err')
    assert relayed.told == [('arm│a', b'one\n')]
    assert relayed.recorded['arm│a', 'stdout'] == b'one\ntw'
    assert relayed.relay.unfinished('arm│a') == b'twerr'
    relayed.relay.feed(there, 'stdout', b'o\nthree')
    relayed.relay.end_lines('arm│a')
    assert relayed.told[1:] == [
        ('arm│a', b'two\n'),
        ('arm│a', b'three'),
        ('arm│a', b'err'),
    ]
    # its children may write on, and the rest is not lost
    relayed.relay.feed(there, 'stdout', b'rest')
    relayed.relay.close()
    assert relayed.told[-1] == ('arm│a', b'rest')


def test_output_of_a_machine_is_shown_apart_from_its_lines(relayed):
    seen = []
    relayed.relay.sinks['arm│a'] = [lambda *piece: seen.append(piece)]
    relayed.relay.show('arm│a', 'stdout', b'name? ')
    relayed.relay.feed(relayed.process('arm│a'), 'stdout', b'name? x\n')
    assert seen == [('stdout', b'name? ')]
