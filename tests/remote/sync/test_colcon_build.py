# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The colcon of a machine, and its arguments."""

import os
from pathlib import Path
import sys

from colcon_yamllaunch.remote.sync.build import colcon_python
from colcon_yamllaunch.remote.sync.code_sync import build_words, remote_path
import pytest

SETTINGS = {
    'build_base': '"build"',
    'install_base': '"install"',
    'cmake_args': '["-DA=1", "--help", "plain"]',
    'cmake_force_configure': 'true',
    'cmake_clean_cache': 'false',
    'ament_cmake_args': 'null',
    'catkin_cmake_args': '[]',
    'merge_install': 'false',
    'symlink_install': 'true',
}


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


def test_defaults_and_mixins_here_are_passed_on() -> None:
    given = ['--mixin', 'debug', '--cmake-args', '-DA=1', '--executor', 'seq']
    assert build_words(given, SETTINGS, merge_install=False) == [
        *('--executor', 'seq'),
        *('--cmake-args', ' -DA=1', ' --help', 'plain'),
        '--cmake-force-configure',
    ]


def test_layout_is_passed_on() -> None:
    other = {'build_base': '"b"', 'install_base': '"i"'}
    given = ['--build-base', 'x', '--merge-install']
    assert build_words(given, other, merge_install=True) == [
        *('--merge-install', '--build-base', 'b', '--install-base', 'i')
    ]
    assert build_words([], {}, merge_install=True) == ['--merge-install']


def test_folder_outside_of_the_workspace_is_absolute() -> None:
    assert remote_path(Path('/ws/build'), Path('/ws')) == 'build'
    assert remote_path(Path('/tmp/build'), Path('/ws')) == '/tmp/build'
