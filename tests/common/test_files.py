# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Reading files that others wrote never waits, and ends."""

import os
from pathlib import Path

from colcon_yamllaunch.common.files import content_of, read_json, text_of
import pytest

pytestmark = pytest.mark.hostile


def test_ordinary_files_are_read(tmp_path: Path) -> None:
    file = tmp_path / 'file'
    file.write_bytes(b'one\r\ntwo\rthree')
    assert content_of(file, 14) == b'one\r\ntwo\rthree'
    assert text_of(file) == file.read_text() == 'one\ntwo\nthree'
    # it has no size
    assert b'Name:' in content_of('/proc/self/status')


def test_a_file_that_is_too_large(tmp_path: Path) -> None:
    file = tmp_path / 'file'
    with file.open('wb') as large:
        large.truncate(10**12)
    with pytest.raises(OSError, match='more than 5 bytes'):
        content_of(file, 5)
    assert text_of(file) == ''
    with pytest.raises(OSError, match='more than 5 bytes'):
        content_of('/proc/self/status', 5)


def test_other_files_are_not_opened(tmp_path: Path) -> None:
    pipe = tmp_path / 'pipe'
    os.mkfifo(pipe)
    with pytest.raises(OSError, match='a named pipe'):
        content_of(pipe)
    with pytest.raises(OSError, match='a device'):
        content_of('/dev/zero')
    with pytest.raises(IsADirectoryError):
        content_of(tmp_path)
    assert text_of(pipe) == ''
    assert read_json(pipe) is None


def test_a_pipe_of_ones_own_is_read() -> None:
    reader, writer = os.pipe()
    os.write(writer, b'text')
    os.close(writer)
    try:
        assert content_of(f'/dev/fd/{reader}') == b'text'
    finally:
        os.close(reader)
