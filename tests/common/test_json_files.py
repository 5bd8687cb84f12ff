# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A file appears complete or not at all."""

from pathlib import Path
import stat

from colcon_yamllaunch.common.files import read_json, write_json
import pytest


def test_what_is_written_is_read(tmp_path: Path) -> None:
    path = tmp_path / 'folder/file'
    write_json(path, {'a': 1})
    write_json(path, {'a': [2]}, 0o600)
    assert read_json(path) == {'a': [2]}
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize('content', [None, b'', b'{', b'\xff', b'[' * 10**5])
def test_a_damaged_file_counts_as_none(
    tmp_path: Path, content: bytes | None
) -> None:
    path = tmp_path / 'file'
    if content is not None:
        path.write_bytes(content)
    assert read_json(path) is None


def test_what_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    path = tmp_path / 'file'
    path.mkdir()
    write_json(path, {'a': 1})
    assert list(tmp_path.iterdir()) == [path]
