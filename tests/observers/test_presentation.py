# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a terminal gets of a launch that goes on with its files."""

from contextlib import ExitStack
from types import SimpleNamespace

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.observers.presentation import present, Presentation
from colcon_yamllaunch.plan.plan import Plan
import pytest


class Terminal:
    """Takes note of what is shown and written."""

    def __init__(self, **settings):
        self.shown, self.written, self.ended = [], [], []
        screen = SimpleNamespace(
            handle=lambda event: self.shown.extend(event.lines()),
            end_output=self.ended.append,
        )
        display = SimpleNamespace(
            environment={'TERM': 'xterm'},
            terminal=True,
            descriptor=-1,
            writer=SimpleNamespace(
                steer=lambda data: self.written.append(data.decode()),
                flush=bool,
            ),
        )
        presentation = Presentation(watch=True, **settings)
        self.handle = present(
            presentation, screen, Plan(), display, ExitStack()
        )
        self.written.clear()


@pytest.fixture
def restart(process):
    talker = process('talker')
    stopped = Outcome(signal=2)
    return (
        events.Requested(talker, 'change'),
        events.Exited(talker, 7, stopped, 1.0, asked=True, failed=False),
        events.Started(talker, 8),
    )


def test_restart_after_a_change_is_hidden(restart):
    terminal = Terminal()
    for event in restart:
        terminal.handle(event)
    assert terminal.shown == []
    assert [p.label for p in terminal.ended] == ['talker']
    terminal.handle(restart[2])
    assert terminal.shown == ['talker: started, pid 8']


def test_other_ends_and_starts_are_shown_with_watch(restart, process):
    terminal = Terminal()
    terminal.handle(restart[1])
    terminal.handle(restart[2])
    terminal.handle(restart[0])
    crash = Outcome(signal=11)
    talker = process('talker')
    terminal.handle(events.Exited(talker, 8, crash, 1.0, True, True))
    terminal.handle(events.StartFailed(talker, 'there is no file'))
    assert len(terminal.shown) == 4


def test_verbose_shows_restarts_after_a_change(restart):
    terminal = Terminal(verbosity='verbose')
    terminal.handle(restart[1])
    assert terminal.shown == ['talker: stopped after 1.0 s']


def test_title_shows_the_result_of_the_last_change():
    terminal = Terminal(title='demo')
    # what `--why` says of a file that nothing uses is no change
    terminal.handle(events.ChangeReported('nothing to do', is_final=False))
    terminal.handle(events.FilesChanged(('a.cpp',)))
    terminal.handle(events.ChangeReported('building', is_final=False))
    terminal.handle(events.ChangeReported('done'))
    terminal.handle(events.ChangeReported('failed', failed=True))
    terminal.handle(events.ChangeChecked(True, (), (), 0.1))
    assert terminal.written == [f'\x1b]2;{sign} demo\x07' for sign in '…✓✗✓']


def test_title_shows_failures_after_a_change(process):
    terminal = Terminal(title='demo', bell=True)
    talker, crash = process('talker'), Outcome(code=1)
    for event in (
        events.FilesChanged(('talker.py',)),
        events.Started(talker, 8),
        events.ChangeReported('restarted talker'),
        events.Exited(talker, 8, crash, 1.0, False, True),
        # another change, which takes longer than it runs
        events.FilesChanged(('talker.py', 'other.py')),
        events.Started(talker, 9),
        events.Exited(talker, 9, crash, 1.0, False, True),
        events.ChangeReported('restarted talker, other'),
        events.FilesChanged(('talker.py',)),
        events.Started(talker, 10),
        events.ChangeReported('restarted talker'),
    ):
        terminal.handle(event)
    signs = ''.join(terminal.written).replace('\x1b]2;', '')
    assert signs.replace(' demo\x07', '') == '…✓✗\a…✗\a✗…✓'


def test_replanned_processes_are_hidden(restart, process):
    terminal = Terminal()
    _, ended, started = restart
    later = process('later')
    for event in (
        events.Replanned(('talker', 'later'), ('talker',), ()),
        events.Requested(started.process, 'stop'),
        ended,
        events.Dropped(started.process),
        started,
        events.ChangeReported('stopped talker, started talker, later'),
    ):
        terminal.handle(event)
    assert terminal.shown == ['stopped talker, started talker, later']
    # what was behind a timer
    terminal.handle(events.Started(later, 9))
    terminal.handle(events.Requested(started.process, 'stop'))
    terminal.handle(ended)
    assert terminal.shown[1:] == [
        'later: started, pid 9',
        'talker: stop requested',
        'talker: stopped after 1.0 s',
    ]


def test_bell_rings_only_with_the_option():
    silent, loud = Terminal(), Terminal(bell=True)
    for terminal in (silent, loud):
        terminal.handle(events.ChangeReported('done'))
        terminal.handle(events.ChangeReported('failed', failed=True))
        terminal.handle(events.ChangeChecked(False, ('one',), (), 0.1))
    assert silent.written == []
    assert loud.written == ['\a', '\a']
