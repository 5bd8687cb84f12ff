# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A fingerprint changes with what it was taken of."""

import os
from pathlib import Path
import time

from colcon_yamllaunch.common import fingerprint as module
from colcon_yamllaunch.common.fingerprint import (
    are_settled,
    Fingerprint,
    fingerprint,
    has_same_content,
    with_content,
)
import pytest
from support.file_clock import let_files_settle

SECOND = 1_000_000_000


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / 'file'
    path.write_text('first')
    let_files_settle(tmp_path)
    return path


def taken(path: Path) -> Fingerprint:
    found = fingerprint(str(path))
    assert found is not None
    return found


def write_at(path: Path, text: str, mtime: int) -> None:
    path.write_text(text)
    os.utime(path, ns=(mtime, mtime))


def test_nothing_has_none(tmp_path: Path) -> None:
    assert fingerprint(str(tmp_path / 'nothing')) is None
    assert are_settled([None])


def test_a_dangling_link_is_a_file_on_its_own(tmp_path: Path) -> None:
    link = tmp_path / 'link'
    link.symlink_to(tmp_path / 'nothing')
    before = taken(link)
    link.unlink()
    link.symlink_to(tmp_path / 'else')
    assert taken(link) != before


def test_another_content_of_the_same_size_and_time(file: Path) -> None:
    before = taken(file)
    assert taken(file) == before
    write_at(file, 'other', before.mtime)
    assert taken(file) != before


@pytest.mark.parametrize(
    ('age', 'is_settled'),
    [
        (0, False),
        (5_000_000, False),
        (SECOND, True),
        # as after the clock was set back
        (-SECOND, True),
    ],
)
def test_changes_within_a_tick_do_not_show(age: int, is_settled: bool) -> None:
    now = time.time_ns()
    recent, old = now - age | 1, now - 10 * SECOND
    assert Fingerprint(1, recent, False, '', old).is_settled is is_settled
    assert Fingerprint(1, old, False, '', recent).is_settled is is_settled


def test_a_file_system_that_counts_in_seconds() -> None:
    now = time.time_ns() // SECOND * SECOND
    assert not Fingerprint(1, now, False, '', now).is_settled
    before = now - 4 * SECOND
    assert Fingerprint(1, before, False, '', before).is_settled


def test_the_digest_of_an_unchanged_file_is_used_again(file: Path) -> None:
    first = with_content(file, taken(file), None)
    assert first.digest
    known = first._replace(digest='known')
    assert with_content(file, taken(file), known).digest == 'known'
    file.touch()
    assert with_content(file, taken(file), known).digest == first.digest


def test_a_fresh_time_proves_nothing(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, 'TICK', 10**18)
    before = with_content(file, taken(file), None)
    assert before.mtime == 0
    assert has_same_content(file, before, taken(file))
    file.write_text('other')
    assert not has_same_content(file, before, taken(file))


def test_the_same_content_written_anew(file: Path) -> None:
    before = with_content(file, taken(file), None)
    file.write_text('first')
    assert has_same_content(file, before, taken(file))
    write_at(file, 'other', before.mtime)
    assert not has_same_content(file, before, taken(file))


@pytest.fixture
def large(file: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a file that is too large to be read."""
    monkeypatch.setattr(module, 'READ_SIZE', 1)
    return file


def test_a_large_file_is_told_by_its_times(large: Path) -> None:
    before = with_content(large, taken(large), None)
    assert not before.digest
    assert has_same_content(large, before, taken(large))
    write_at(large, 'first', before.mtime + 1)
    assert not has_same_content(large, before, taken(large))


@pytest.mark.hostile
def test_a_large_file_of_the_same_size_and_time_differs(large: Path) -> None:
    before = with_content(large, taken(large), None)
    write_at(large, 'other', before.mtime)
    assert not has_same_content(large, before, taken(large))


def test_a_large_file_is_read_where_its_content_is_asked_for(
    large: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, '_CHUNK', 2)
    before = with_content(large, taken(large), None, limit=99)
    assert before.digest == module.digest(b'first')
    write_at(large, 'first', before.mtime + 1)
    assert has_same_content(large, before, taken(large), limit=99)
