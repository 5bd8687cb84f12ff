# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Copying the sample workspace."""

from pathlib import Path

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.workspace.create import sample
import pytest


@pytest.fixture
def original(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a sample that somebody works with, installed read-only."""
    folder = tmp_path / 'original'
    for name, text in {
        'README.md': 'read\n',
        'flow/scripts/run.sh': '#!/bin/sh\n',
        'flow/scripts/__pycache__/run.pyc': '',
        'flow/.pytest_cache/README.md': '',
        'flow/flow.egg-info/PKG-INFO': '',
        'src/build/setup.py': '',
        'build/flow/run': '#!/bin/sh\n',
        'install/setup.bash': '',
        'log/latest': '',
    }.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        file.chmod(0o444)
    monkeypatch.setattr(sample, 'SAMPLE', folder)
    return folder


def test_copy_has_neither_products_nor_caches(
    original: Path, tmp_path: Path
) -> None:
    copy = tmp_path / 'a/copy'
    sample.copy_sample(copy)
    found = {p.relative_to(copy).as_posix() for p in copy.rglob('*.*')}
    assert found == {'README.md', 'flow/scripts/run.sh', 'src/build/setup.py'}


def test_copy_can_be_edited_and_its_scripts_run(
    original: Path, tmp_path: Path
) -> None:
    sample.copy_sample(tmp_path / 'copy')
    modes = {
        name: (tmp_path / 'copy' / name).stat().st_mode
        for name in ('README.md', 'flow/scripts/run.sh')
    }
    assert all(mode & 0o200 for mode in modes.values())
    assert modes['flow/scripts/run.sh'] & 0o100
    assert not modes['README.md'] & 0o111


def test_failed_copy_leaves_nothing(original: Path, tmp_path: Path) -> None:
    copy = tmp_path / 'copy'

    def fail(*_: object) -> None:
        raise OSError(28, 'No space left on device')

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr('shutil.copyfile', fail)
        with pytest.raises(UserError, match=r'cannot write .*: No space left'):
            sample.copy_sample(copy)
    assert not copy.exists()
