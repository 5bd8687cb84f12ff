# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Following the log of a process, as `tail -F` does."""

from pathlib import Path

from colcon_yamllaunch.verb.reading_logs import LINES, LogReader
import pytest

Capture = pytest.CaptureFixture[bytes]


def shown(capture: Capture) -> bytes:
    return capture.readouterr().out


def test_a_log_is_shown_as_it_is(tmp_path: Path, capfdbinary: Capture) -> None:
    path = tmp_path / 'log'
    data = b'caf\xc3\xa9 \xff\x1b[31mred\r\nno end'
    path.write_bytes(data)
    LogReader(None, path).finish()
    assert shown(capfdbinary) == data


def test_lines_of_several_logs_have_names(
    tmp_path: Path, capfdbinary: Capture
) -> None:
    path = tmp_path / 'log'
    path.write_bytes(b'one\ntwo\nthr')
    reader = LogReader('a-1', path)
    reader.show()
    assert shown(capfdbinary) == b'[a-1] one\n[a-1] two\n'
    with path.open('ab') as file:
        file.write(b'ee\n')
    reader.finish()
    assert shown(capfdbinary) == b'[a-1] three\n'


def test_following_begins_with_the_last_lines(
    tmp_path: Path, capfdbinary: Capture
) -> None:
    path = tmp_path / 'log'
    path.write_text(''.join(f'{n}\n' for n in range(100)))
    reader = LogReader(None, path)
    reader.skip_to_tail()
    reader.finish()
    expected = [str(n).encode() for n in range(100 - LINES, 100)]
    assert shown(capfdbinary).splitlines() == expected


def test_a_log_that_appears_later(
    tmp_path: Path, capfdbinary: Capture
) -> None:
    path = tmp_path / 'log'
    reader = LogReader(None, path)
    reader.skip_to_tail()
    reader.show()
    path.write_text('now\n')
    reader.show()
    assert shown(capfdbinary) == b'now\n'
    reader.finish()


def test_a_log_that_is_rotated(tmp_path: Path, capfdbinary: Capture) -> None:
    path = tmp_path / 'log'
    path.write_text('1\n')
    reader = LogReader(None, path)
    reader.show()
    with path.open('a') as file:
        file.write('2\n')
    path.rename(tmp_path / 'log.1')
    reader.show()
    path.write_text('3\n')
    reader.show()
    assert shown(capfdbinary) == b'1\n2\n3\n'
    reader.finish()


def rotate(path: Path) -> None:
    """Rename all parts of a log, as its writer does."""
    for number in range(9, 0, -1):
        part = path.with_name(f'{path.name}.{number}')
        if part.exists():
            part.rename(path.with_name(f'{path.name}.{number + 1}'))
    path.rename(path.with_name(f'{path.name}.1'))


def test_nothing_is_lost_of_a_log_that_rotates_fast(
    tmp_path: Path, capfdbinary: Capture
) -> None:
    path = tmp_path / 'log'
    path.write_text('0\n')
    reader = LogReader(None, path)
    reader.show()
    for number in range(1, 5):
        rotate(path)
        path.write_text(f'{number}\n')
    reader.finish()
    assert shown(capfdbinary) == b'0\n1\n2\n3\n4\n'


def test_following_goes_on_with_the_oldest_part_that_is_left(
    tmp_path: Path, capfdbinary: Capture
) -> None:
    path = tmp_path / 'log'
    path.write_text('0\n')
    reader = LogReader(None, path)
    reader.show()
    for number in range(1, 5):
        rotate(path)
        path.write_text(f'{number}\n')
    for number in (4, 3):
        (tmp_path / f'log.{number}').unlink()
    reader.finish()
    assert shown(capfdbinary) == b'0\n2\n3\n4\n'


def test_the_whole_log_has_its_old_parts(
    tmp_path: Path, capfdbinary: Capture
) -> None:
    path = tmp_path / 'log'
    for number in range(12):
        (tmp_path / f'log.{12 - number}').write_text(f'{number}\n')
    path.write_text('12\n')
    LogReader(None, path).finish()
    expected = ''.join(f'{number}\n' for number in range(13))
    assert shown(capfdbinary) == expected.encode()


def test_following_a_log_that_was_moved_away(
    tmp_path: Path, capfdbinary: Capture
) -> None:
    path = tmp_path / 'log'
    path.write_text('1\n')
    reader = LogReader(None, path)
    reader.show()
    path.rename(tmp_path / 'elsewhere')
    path.write_text('2\n')
    reader.finish()
    assert shown(capfdbinary) == b'1\n2\n'


def test_a_log_that_is_cut(tmp_path: Path, capfdbinary: Capture) -> None:
    path = tmp_path / 'log'
    path.write_text('a long line\n')
    reader = LogReader(None, path)
    reader.show()
    path.write_text('short\n')
    reader.show()
    assert shown(capfdbinary) == b'a long line\nshort\n'
    reader.finish()
