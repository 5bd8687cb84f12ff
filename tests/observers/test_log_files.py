# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import errno
import os
import shutil
from unittest.mock import Mock

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.observers.log_files import LogFile, LogQuota
import pytest

LINE = b'x' * 999 + b'\n'
LIMIT = 2_000_000


@pytest.fixture
def complaints():
    return []


@pytest.fixture
def open_log(tmp_path, complaints):
    """Return a function that opens log files, which are closed at the end."""
    files = []

    def open_one(name='stdout.log', quota=None, *, limit=LIMIT):
        quota = quota or LogQuota(limit, 1, complaints.append)
        files.append(LogFile(tmp_path / name, quota))
        return files[-1]

    yield open_one
    for file in files:
        file.close()


def write_all(file, pieces):
    for data in pieces:
        file.write(data)


def parts(folder, name='stdout.log'):
    """Return the paths of a log file, the oldest first."""
    found = [p for p in folder.iterdir() if p.name.startswith(f'{name}.')]
    found.sort(key=lambda p: -int(p.suffix[1:]))
    return [*found, folder / name]


def content(folder, name='stdout.log'):
    return b''.join(p.read_bytes() for p in parts(folder, name))


def size_of(folder):
    return sum(p.stat().st_size for p in folder.iterdir())


def numbered(first, last, times=100):
    return [b'%09d\n' % n * times for n in range(first, last)]


def test_below_the_limit_nothing_is_lost(tmp_path, open_log, complaints):
    written = numbered(0, LIMIT // 1000)
    write_all(open_log(), written)
    assert content(tmp_path) == b''.join(written)
    assert complaints == []
    names = [p.name for p in parts(tmp_path)]
    assert len(names) > 8
    assert names[-3:] == ['stdout.log.2', 'stdout.log.1', 'stdout.log']


def test_above_the_limit_the_newest_stays(tmp_path, open_log, complaints):
    file = open_log()
    everything = numbered(0, 2000, times=500)
    for data in everything:
        file.write(data)
        assert size_of(tmp_path) <= LIMIT
    kept = content(tmp_path)
    assert b''.join(everything).endswith(kept)
    assert len(kept) > LIMIT * 3 / 4
    (complaint,) = complaints
    assert '2 MB' in complaint


def test_a_flood_does_not_take_the_place_of_others(
    tmp_path, open_log, complaints
):
    quota = LogQuota(10 * LIMIT, 200, complaints.append)
    for number in range(100):
        open_log(f'quiet{number}', quota).write(LINE * 40)
    write_all(open_log('flood', quota), [LINE * 100] * 300)
    assert size_of(tmp_path) <= 10 * LIMIT
    assert len(complaints) == 1
    for number in range(100):
        assert content(tmp_path, f'quiet{number}') == LINE * 40


def test_one_flood_among_many_files_has_few_parts(tmp_path, open_log):
    file = open_log('flood', LogQuota(10 * LIMIT, 40, lambda _: None))
    write_all(file, [LINE * 100] * 250)
    assert 9 * LIMIT < size_of(tmp_path) <= 10 * LIMIT
    assert len(parts(tmp_path, 'flood')) < 50


def test_without_a_limit_nothing_rotates(tmp_path, open_log):
    write_all(open_log(limit=None), [LINE] * 3000)
    assert parts(tmp_path) == [tmp_path / 'stdout.log']


def test_a_line_is_never_torn(tmp_path, open_log):
    long = b'y' * LIMIT + b'\n'
    write_all(open_log(), (LINE, long, LINE))
    found = [p.read_bytes() for p in parts(tmp_path)]
    assert found in ([long, LINE], [LINE])


def test_the_share_of_many_files_is_not_tiny():
    quota = LogQuota(LIMIT, 1000, pytest.fail)
    assert quota.share == limits.MINIMUM_LOG_FILE_BYTES


def test_old_parts_may_be_deleted_meanwhile(tmp_path, open_log):
    file = open_log()
    write_all(file, numbered(0, 1500))
    (tmp_path / 'stdout.log.2').unlink()
    write_all(file, numbered(1500, 9000))
    assert size_of(tmp_path) <= LIMIT
    assert content(tmp_path).endswith(numbered(8999, 9000)[0])


def test_pieces_of_lines_are_put_together_before_a_rotation(
    tmp_path, open_log
):
    lines = b''.join(b'%d ' % n * (n % 300) + b'\n' for n in range(3000))
    pieces = [lines[n : n + 4096] for n in range(0, len(lines), 4096)]
    write_all(open_log(), pieces)
    found = parts(tmp_path)
    assert len(found) > 5
    assert lines.endswith(content(tmp_path))
    for part in found[:-1]:
        assert part.read_bytes().endswith(b'\n')


@pytest.mark.hostile
def test_a_line_without_end_keeps_to_the_limit(tmp_path, open_log):
    file = open_log(limit=4 * LIMIT)
    for _ in range(400):
        file.write(b'x' * limits.READ_BYTES)
        assert size_of(tmp_path) <= 4 * LIMIT
    assert len(parts(tmp_path)) > 2


@pytest.mark.hostile
def test_a_deleted_file_is_made_anew_and_counts(
    tmp_path, open_log, complaints
):
    folder = tmp_path / 'log'
    folder.mkdir()
    quota = LogQuota(LIMIT, 1, complaints.append)
    file = open_log('log/stdout.log', quota)
    write_all(file, [LINE] * 1000)
    shutil.rmtree(folder)
    file.write(b'after\n')
    assert content(folder) == b'after\n'
    assert quota.used == len(b'after\n')
    for _ in range(3000):
        file.write(LINE)
        assert size_of(folder) <= LIMIT
    assert quota.used == size_of(folder)
    assert content(folder).endswith(LINE * 1500)


@pytest.mark.hostile
def test_a_file_that_alone_was_deleted_is_made_anew(
    tmp_path, open_log, complaints
):
    file = open_log()
    write_all(file, [LINE] * 200)
    (tmp_path / 'stdout.log').unlink()
    file.write(LINE)
    assert (tmp_path / 'stdout.log').read_bytes() == LINE
    assert complaints == []


@pytest.mark.hostile
def test_a_rotation_that_failed_is_tried_again(
    tmp_path, open_log, monkeypatch
):
    file = open_log()
    monkeypatch.setattr('os.rename', Mock(side_effect=PermissionError))
    write_all(file, [LINE] * 500)
    assert size_of(tmp_path) == 500 * len(LINE)
    monkeypatch.undo()
    write_all(file, [LINE] * 4000)
    assert size_of(tmp_path) <= LIMIT
    assert len(parts(tmp_path)) > 2


@pytest.mark.hostile
def test_a_file_that_cannot_be_made_after_a_rotation_is_made_later(
    tmp_path, open_log, monkeypatch
):
    file = open_log()
    full = OSError(errno.EMFILE, os.strerror(errno.EMFILE))
    monkeypatch.setattr('os.open', Mock(side_effect=full))
    write_all(file, numbered(0, 200))
    assert not (tmp_path / 'stdout.log').exists()
    monkeypatch.undo()
    write_all(file, numbered(200, 1000))
    assert content(tmp_path) == b''.join(numbered(0, 1000))
    for data in numbered(1000, 4000):
        file.write(data)
        assert size_of(tmp_path) <= LIMIT
