# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Packages are built there as here, whatever made the arguments here."""

from pathlib import Path

from colcon_yamllaunch.remote.sync.code_sync import build_words
from colcon_yamllaunch.remote.sync.code_sync import path_there

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


def test_defaults_and_mixins_here_go_along() -> None:
    given = ['--mixin', 'debug', '--cmake-args', '-DA=1', '--executor', 'seq']
    assert build_words(given, SETTINGS, merge_install=False) == [
        *('--executor', 'seq'),
        *('--cmake-args', ' -DA=1', ' --help', 'plain'),
        '--cmake-force-configure',
    ]


def test_the_layout_goes_along() -> None:
    other = {'build_base': '"b"', 'install_base': '"i"'}
    given = ['--build-base', 'x', '--merge-install']
    assert build_words(given, other, merge_install=True) == [
        *('--merge-install', '--build-base', 'b', '--install-base', 'i')
    ]
    assert build_words([], {}, merge_install=True) == ['--merge-install']


def test_folders_outside_stay_where_they_are() -> None:
    assert path_there(Path('/ws/build'), Path('/ws')) == 'build'
    assert path_there(Path('/tmp/build'), Path('/ws')) == '/tmp/build'
