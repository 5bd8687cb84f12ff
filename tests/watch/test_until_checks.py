# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What `--watch --until` says after each change, from replayed events."""

from colcon_yamllaunch.engine.events import (
    ChangeChecked,
    ChangeReported,
    Exited,
    FilesChanged,
    Output,
    Restarted,
    Started,
    StartFailed,
)
from colcon_yamllaunch.engine.line_pattern import LinePattern
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.member_settings import MemberSettings
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.watch.until_checks import UntilChecks
import pytest


class Replay:
    def __init__(self, process, *until, timeout=None):
        self.now = 100.0
        self.process = process
        self.told = []
        self.rounds = UntilChecks(
            map(LinePattern, until), timeout, lambda: self.now
        )
        self.rounds.emit = self.told.append
        self.rounds.begin()

    def after(self, seconds):
        self.now += seconds
        return self.hears()

    def hears(self, *events):
        for event in events:
            self.rounds.handle(event)
        assert self.rounds.reason_to_stop() is None
        told, self.told[:] = list(self.told), []
        return [line for event in told for line in event.lines()]

    def starts(self, label):
        return self.hears(Started(self.process(label), 7))

    def says(self, label, text):
        data = f'{text}\n'.encode()
        return self.hears(Output(self.process(label), 'stdout', data))

    def ends(self, label, code, asked=False):
        failed = bool(code) and not asked
        event = Exited(
            self.process(label), 7, Outcome(code), 1.0, asked, failed
        )
        return self.hears(event)

    def changes(self, *labels, failed=False):
        self.hears(FilesChanged(('/ws/a.py',)))
        for label in labels:
            self.ends(label, 0, asked=True)
            self.hears(Started(self.process(label), 8))
            self.hears(Restarted(self.process(label), 0.1))
        return self.hears(ChangeReported('a.py changed', failed))


@pytest.fixture
def replay(process):
    def begin(*until, **settings):
        made = Replay(process, *until, **settings)
        made.starts('a')
        made.starts('b')
        return made

    return begin


def test_check_succeeds_when_all_was_seen(replay):
    r = replay('one', 'two')
    assert r.says('a', 'one') == []
    r.now += 0.5
    assert r.says('b', 'two') == ['green: all was seen (0.50 s)']
    assert r.says('b', 'two') == []


def test_only_restarted_processes_are_checked_again(replay):
    r = replay('one', 'two')
    r.says('a', 'one')
    r.says('b', 'two')
    assert r.changes('b') == []
    assert r.says('b', 'two') == ['green: all was seen (0.00 s)']
    assert r.changes() == ['green: all was seen (0.00 s)']


def test_output_of_the_old_process_does_not_count(replay):
    r = replay('bye')
    r.hears(FilesChanged(('/ws/a.py',)))
    assert r.says('a', 'bye') == []
    assert r.changes('a') == []
    assert r.says('a', 'bye') == ['green: all was seen (0.00 s)']


def test_check_fails_at_its_timeout(replay):
    r = replay('one', 'two', timeout=5.0)
    r.says('a', 'one')
    assert r.rounds.due() == 105.0
    assert r.after(5.0) == ["red: 'two' was not seen (5.00 s)"]
    assert r.rounds.due() is None
    assert r.changes('b') == []
    assert r.says('b', 'two') == ['green: all was seen (0.00 s)']


def test_check_fails_when_all_processes_have_ended(replay):
    r = replay('one')
    assert r.ends('a', 0) == []
    assert r.ends('b', 0) == ["red: 'one' was not seen (0.00 s)"]


def test_failure_of_one_that_is_optional_is_none(replay, process):
    r = replay('one')
    settings = MemberSettings(Position('robot.yaml', 3, 5), optional=True)
    pump = process('pump', settings=settings)
    failed = Exited(pump, 7, Outcome(1), 1.0, False, True)
    assert r.hears(failed, StartFailed(pump, 'no such file')) == []
    assert r.says('a', 'one') == ['green: all was seen (0.00 s)']


def test_failed_build_starts_no_check(replay):
    r = replay('one')
    assert r.changes(failed=True) == []
    assert r.says('a', 'one') == []
    assert r.changes() == ['green: all was seen (0.00 s)']


def test_verdict_is_that_of_the_last_check(replay):
    r = replay('one')
    r.says('a', 'one')
    assert r.rounds.failures() == ()
    r.changes('a')
    assert r.rounds.failures() == (
        "'one' was not seen after the last change (--until)",
    )


def test_without_expressions_nothing_is_reported(process):
    r = Replay(process)
    assert r.starts('a') == []
    assert r.ends('a', 1) == []


def test_failed_check_is_an_error():
    assert ChangeChecked(False, ('one',), (), 0.25).severity == 'ERROR'
