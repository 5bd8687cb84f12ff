# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The names of Python packages as their files write them."""

import os
from pathlib import Path

from colcon_yamllaunch.workspace.packages.build_files import python_name
import pytest


@pytest.mark.parametrize(
    ('setup', 'expected'),
    [
        ("setup(name='one')", 'one'),
        ("import setuptools\nsetuptools.setup(name='one')", 'one'),
        ("n = 'one'\nif 1:\n    setup(version='1', name=n)", 'one'),
        # it may be any of them
        ("n = 'one'\nn = 'two'\nsetup(name=n)", None),
        ("n = open('name').read()\nsetup(name=n)", None),
        ("setup(name='o' + 'ne')", None),
        ('setup(name=f"one{1}")', None),
        # nothing is said, so the metadata files count
        ('setup()', 'cfg'),
        ('setup(**values)', 'cfg'),
        ('setup(', 'cfg'),
        ('\0', 'cfg'),
        ('(' * 100_000, 'cfg'),
    ],
)
def test_name(tmp_path: Path, setup: str, expected: str | None) -> None:
    (tmp_path / 'setup.py').write_text(setup, encoding='utf-8')
    (tmp_path / 'setup.cfg').write_text(
        '[options]\nname = no\n[metadata]\nversion = 1\nname = cfg\n',
        encoding='utf-8',
    )
    assert python_name(tmp_path) == expected


def test_name_in_pyproject(tmp_path: Path) -> None:
    (tmp_path / 'setup.cfg').write_text('[develop]\n', encoding='utf-8')
    (tmp_path / 'pyproject.toml').write_text(
        '[build-system]\nname = "no"\n[project]\nname = "one"\n',
        encoding='utf-8',
    )
    assert python_name(tmp_path) == 'one'


@pytest.mark.hostile
def test_pipes_are_not_read(tmp_path: Path) -> None:
    for name in ('setup.py', 'setup.cfg', 'pyproject.toml'):
        os.mkfifo(tmp_path / name)
    assert python_name(tmp_path) is None
