# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`pip install .` in a clone."""

from pathlib import Path
import shutil
import subprocess
import sys

import pytest
from support.sources import PACKAGE

#: What pip reads, besides the package.
FILES = ('LICENSE', 'README.md', 'setup.cfg', 'setup.py')


@pytest.mark.full
def test_pip_install_leaves_nothing_in_the_clone(tmp_path: Path) -> None:
    clone = tmp_path / 'clone'
    ignored = shutil.ignore_patterns('__pycache__')
    shutil.copytree(PACKAGE, clone / PACKAGE.name, ignore=ignored)
    for name in FILES:
        shutil.copy(PACKAGE.parent / name, clone)
    # a module of an older version, built by its setup.py
    built = clone / 'build/lib' / PACKAGE.name
    built.mkdir(parents=True)
    (built / 'deleted.py').touch()
    before = sorted(clone.rglob('*'))
    installed = tmp_path / 'installed'
    subprocess.run(
        [
            *(sys.executable, '-m', 'pip', 'install', '--quiet', '--no-index'),
            *('--no-deps', '--no-build-isolation'),
            *('--target', str(installed), str(clone)),
        ],
        check=True,
    )
    assert sorted(clone.rglob('*')) == before
    assert (installed / PACKAGE.name / 'verb/launch.py').is_file()
    assert not (installed / PACKAGE.name / 'deleted.py').exists()
    (entry_points,) = installed.glob('*.dist-info/entry_points.txt')
    assert 'LaunchVerb' in entry_points.read_text()
