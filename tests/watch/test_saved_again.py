# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Files that were something else for a moment, and who failed by that."""

from colcon_yamllaunch.watch.changes import Batch
from colcon_yamllaunch.watch.changes import Change
from colcon_yamllaunch.watch.failed_parts import FailedParts
from colcon_yamllaunch.watch.saved_again import READING
from colcon_yamllaunch.watch.saved_again import SavedAgain

A = Change('again', '/a', '/a')
B = Change('again', '/b', '/b')


def test_files_are_looked_at_when_something_fails_soon_after() -> None:
    again = SavedAgain()
    again.add([A], 10.0)
    again.add([B], 12.0)
    assert not again.is_due
    # it was started when the first was as it is
    again.has_failed(11.0, 12.5)
    assert again.is_due
    assert again.take() == Batch((B,), 12_500_000_000)
    assert not again.is_due
    again.has_failed(0.0, 10.0 + READING)
    assert again.take().changes == (A, B)
    again.has_failed(0.0, 13.0 + READING)
    assert not again.is_due


def test_what_was_started_again_has_not_failed() -> None:
    failed = FailedParts()
    failed.came_up('a', 1.0, failed=False)
    failed.came_up('b', 1.0, failed=True)
    assert failed.crashed('a', 2.0) == 1.0
    assert failed.crashed_since(2.0) == {'a'}
    assert failed.crashed_since(2.1) == set()
    assert failed.unstarted == {'b'}
    for label in ('a', 'b'):
        failed.came_up(label, 3.0, failed=False)
    assert failed.crashed_since(0.0) | failed.unstarted == set()
