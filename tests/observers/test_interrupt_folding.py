# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Tracebacks of nodes that are stopped."""

import signal

from colcon_yamllaunch.engine.events import Signalled, Started
from colcon_yamllaunch.observers.screen import InterruptFolding, LONGEST
import pytest

START = b'Traceback (most recent call last):\n'
BODY = b'  File "node.py", line 5, in <module>\n    main()\n    ~~~~^^\n'
LINK = (
    b'\nDuring handling of the above exception, another exception occurred:'
    b'\n\n'
)
INTERRUPTED = START + BODY + b'KeyboardInterrupt\n'


@pytest.fixture
def folding(process):
    """Return a folding that knows that `a` is asked to stop."""
    found = InterruptFolding()
    found.note(Signalled(process('a'), 9, signal.SIGINT, True))
    return found


def folded(folding, *chunks, label='a'):
    shown = b''.join(folding.fold(label, 'stderr', c) for c in chunks)
    return shown + b''.join(data for _, data in folding.rest(label))


def test_traceback_of_keyboard_interrupt_is_one_line(folding):
    shown = folded(folding, b'bye\n' + INTERRUPTED + b'gone\n')
    assert shown == (
        b'bye\nKeyboardInterrupt (after a traceback of 4 lines)\ngone\n'
    )


@pytest.mark.parametrize(
    ('chunks', 'count'),
    [
        (INTERRUPTED.splitlines(keepends=True), 1),
        ([INTERRUPTED + LINK + INTERRUPTED], 2),
        ([START + BODY + b'rclpy.executors.ExternalShutdownException\n'], 1),
    ],
)
def test_each_traceback_of_a_stop_is_one_line(folding, chunks, count):
    shown = folded(folding, *chunks)
    assert shown.count(b'\n') == count
    assert b'File' not in shown


def test_traceback_of_another_error_is_shown(folding):
    other = START + BODY + b'ValueError: 5\n'
    assert folded(folding, other) == other
    shown = folded(folding, INTERRUPTED + LINK + other)
    assert shown.endswith(LINK + other)


def test_endless_traceback_is_not_held_back(folding):
    endless = START + b'  x\n' * LONGEST
    assert folding.fold('a', 'stderr', endless) == endless


def test_nothing_is_folded_before_the_stop(folding, process):
    assert folded(folding, INTERRUPTED, label='b') == INTERRUPTED
    folding.note(Started(process('a'), 10))
    assert folded(folding, INTERRUPTED) == INTERRUPTED


@pytest.mark.parametrize(
    'data',
    [
        START,
        START + BODY,
        START + START + BODY + b'x\n',
        BODY + LINK + START + b'end',
        LINK + b'\n' + START + LINK + b'ValueError\n\n',
    ],
)
def test_incomplete_tracebacks_are_shown(folding, data):
    assert folded(folding, data) == data
