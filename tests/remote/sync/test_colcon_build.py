# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""colcon is found on a machine."""

import os
from pathlib import Path
import sys

from colcon_yamllaunch.remote.sync.build import colcon_python
import pytest


@pytest.mark.parametrize('is_environment', [True, False])
def test_colcon_of_a_virtual_environment_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_environment: bool
) -> None:
    def program(folder: str, name: str) -> Path:
        path = tmp_path / folder / 'bin' / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f'#!{path.parent}/python3\n')
        path.chmod(0o755)
        return path

    if is_environment:
        program('venv', '../pyvenv.cfg')
    program('venv', 'colcon')
    python = program('venv', 'python3')
    on_path = program('other', 'colcon').with_name('python3')
    monkeypatch.setenv('PATH', f'{on_path.parent}{os.pathsep}/bin')
    monkeypatch.setattr(sys, 'executable', str(python))
    found = [str(python if is_environment else on_path)]
    assert colcon_python() == found
