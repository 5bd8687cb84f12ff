# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import io
import signal

from colcon_yamllaunch.engine.events import (
    Exited,
    MessageShown,
    Output,
    Started,
    StillRunning,
)
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.writer import TextWriter
from colcon_yamllaunch.observers.screen import Screen
import pytest


@pytest.fixture
def shown(process):
    """Return a function that shows events and returns the text."""

    def show(*events, labels=('a', 'counter'), color=False, terminal=False):
        stream = io.StringIO()
        screen = Screen(
            TextWriter(stream),
            [process(label) for label in labels],
            color=color,
            terminal=terminal,
        )
        for event in events:
            screen.handle(event)
        return stream.getvalue()

    return show


def test_labels_are_aligned(shown, process):
    text = shown(
        Output(process('a'), 'stdout', b'one\ntwo\n'),
        Output(process('counter'), 'stderr', b'three'),
        Started(process('a'), 12),
    )
    assert text == (
        '[a]       one\n'
        '[a]       two\n'
        '[counter] three\n'
        '[launch]  a: started, pid 12\n'
    )


def test_long_label_does_not_widen_the_others(shown, process):
    long = 'x' * 100
    text = shown(
        Output(process('a'), 'stdout', b'one\n'),
        Output(process(long), 'stdout', b'two\n'),
        labels=('a', long),
    )
    first, second = text.splitlines()
    assert len(first) < 40
    assert second == f'[{long}] two'


def test_debug_messages_are_not_shown(shown):
    text = shown(
        MessageShown('INFO', 'one\ntwo'), MessageShown('DEBUG', 'three')
    )
    assert text == ('[INFO] [launch.user]: one\n[INFO] [launch.user]: two\n')


def test_an_exit_says_how_and_when(shown, process):
    def line(outcome, asked=False, failed=False, delay=None):
        event = Exited(process('a'), 9, outcome, 1.23, asked, failed, delay)
        return shown(event).split(maxsplit=1)[1].rstrip()

    assert line(Outcome(code=0)) == 'a: finished after 1.2 s'
    assert line(Outcome(code=3), failed=True) == (
        'a: exited with code 3 after 1.2 s'
    )
    assert line(Outcome(signal=signal.SIGSEGV), failed=True) == (
        'a: died by SIGSEGV (segmentation fault) after 1.2 s'
    )
    assert line(Outcome(signal=signal.SIGINT), asked=True).startswith(
        'a: stopped'
    )
    assert line(Outcome(code=0), delay=0.5).endswith('starts again in 0.5 s')
    assert line(Outcome(code=0), delay=0.0).endswith('starts again')


def test_a_long_list_of_running_processes_is_cut(shown):
    labels = tuple(f'p{n}' for n in range(100))
    text = shown(StillRunning(labels, 2, signal.SIGINT))
    assert len(text) < 120
    assert 'p0' in text
    assert '94 more' in text
    assert '2 timers' in text
    assert 'SIGINT' in text


def test_process_planned_later_has_label_and_colour(shown, process):
    one, two = b'one\n', b'two\n'
    events = [
        Output(process('a'), 'stdout', one),
        Output(process('a longer one'), 'stdout', two),
        Output(process('a'), 'stdout', two),
    ]
    text = shown(*events, labels=('a',))
    assert text == ('[a]      one\n[a longer one] two\n[a]            two\n')
    colours = [line[:5] for line in shown(*events, color=True).splitlines()]
    assert colours[0] == colours[2] != colours[1]
