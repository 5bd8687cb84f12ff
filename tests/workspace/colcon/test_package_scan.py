# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Finding packages without colcon."""

import json
from pathlib import Path

from colcon_yamllaunch.workspace.colcon.colcon_cache import (
    CACHE_NAME,
    CACHE_VERSION,
)
from colcon_yamllaunch.workspace.colcon.package_scan import scan_packages
import pytest


@pytest.mark.parametrize(
    ('file', 'text', 'name'),
    [
        ('package.xml', '<package><name> one </name></package>', 'one'),
        ('CMakeLists.txt', '# project(old)\nproject(one CXX)\n', 'one'),
        ('CMakeLists.txt', 'PROJECT("one")\n', 'one'),
        ('CMakeLists.txt', 'project(${NAME})\n', 'folder'),
        ('CMakeLists.txt', '', 'folder'),
        ('setup.py', "package_name = 'one'\nsetup(name=package_name)", 'one'),
        ('setup.py', 'setup()', 'folder'),
        ('setup.cfg', '[metadata]\nname = one\n', 'one'),
        ('setup.cfg', '[tool]\n', None),
        ('package.xml', '\0', None),
    ],
)
def test_name(tmp_path: Path, file: str, text: str, name: str | None) -> None:
    folder = tmp_path / 'src' / 'folder'
    folder.mkdir(parents=True)
    (folder / file).write_text(text)
    packages = scan_packages(tmp_path, {})
    assert packages.names() == (() if name is None else (name,))
    if name is not None:
        package = packages.package(name)
        assert package is not None
        assert package.path == folder
        assert packages.prefix(name) == str(tmp_path / 'install' / name)


def test_manifest_goes_first(tmp_path: Path) -> None:
    (tmp_path / 'a').mkdir()
    (tmp_path / 'a' / 'package.xml').write_text('<name>one</name>')
    (tmp_path / 'a' / 'CMakeLists.txt').write_text('project(two)')
    assert scan_packages(tmp_path, {}).names() == ('one',)


@pytest.mark.parametrize(
    'cache',
    [
        '[]',
        '{"version": 0}',
        json.dumps({'version': CACHE_VERSION, 'folders': []}),
        json.dumps({'version': CACHE_VERSION, 'folders': {'./a': {}}}),
        json.dumps({'version': CACHE_VERSION, 'folders': {'./a': 1}}),
    ],
)
def test_damaged_cache_is_passed_over(tmp_path: Path, cache: str) -> None:
    (tmp_path / 'a').mkdir()
    (tmp_path / 'a' / 'CMakeLists.txt').write_text('project(one)')
    (tmp_path / 'build').mkdir()
    (tmp_path / 'build' / CACHE_NAME).write_text(cache)
    assert scan_packages(tmp_path, {}).names() == ('one',)


def test_cached_arguments_count(tmp_path: Path) -> None:
    for folder in ('here', 'there'):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / 'CMakeLists.txt').write_text(f'project({folder})')
    arguments = {
        'build_base': 'build',
        'install_base': 'other',
        'merge_install': True,
        'base_paths': ['there'],
        'settings': {},
    }
    cache = {'version': CACHE_VERSION, 'folders': {}, 'arguments': arguments}
    (tmp_path / 'build').mkdir()
    (tmp_path / 'build' / CACHE_NAME).write_text(json.dumps(cache))
    packages = scan_packages(tmp_path, {})
    assert packages.names() == ('there',)
    assert packages.prefix('there') == str(tmp_path / 'other')


def test_chained_underlays_count(tmp_path: Path) -> None:
    index = tmp_path / 'under' / 'share' / 'ament_index' / 'resource_index'
    (index / 'packages').mkdir(parents=True)
    (index / 'packages' / 'deep').touch()
    install = tmp_path / 'ws' / 'install'
    install.mkdir(parents=True)
    (install / 'setup.bash').write_text(
        f'COLCON_CURRENT_PREFIX="{tmp_path / "under"}"\n'
    )
    assert scan_packages(tmp_path / 'ws', {}).names() == ('deep',)
    assert scan_packages(None, {}).names() == ()
