# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Finding the workspace."""

import os
from pathlib import Path

from colcon_yamllaunch.verb.target import find_workspace
from colcon_yamllaunch.workspace.packages import workspace_root
from colcon_yamllaunch.workspace.packages.workspace_root import (
    find_root,
    has_package_below,
    is_package,
)
import pytest


def make(root, *paths):
    for text in paths:
        path = root / text
        if text.endswith('/'):
            path.mkdir(parents=True, exist_ok=True)
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch()


@pytest.mark.parametrize(
    ('paths', 'start', 'expected'),
    [
        (['ws/src/p/package.xml'], 'ws', 'ws'),
        (['ws/src/p/package.xml'], 'ws/src', 'ws'),
        (
            ['ws/src/p/package.xml', 'ws/src/p/scripts/'],
            'ws/src/p/scripts',
            'ws',
        ),
        (['ws/install/', 'ws/p/CMakeLists.txt'], 'ws/p', 'ws'),
        (['ws/build/', 'ws/a/b/'], 'ws/a/b', 'ws'),
        # nothing but packages: only from the top
        (['ws/p/package.xml'], 'ws', 'ws'),
        (['ws/p/package.xml'], 'ws/p', None),
        # a package's own src and build are no workspace
        (['p/CMakeLists.txt', 'p/src/', 'p/build/'], 'p/src', None),
        # src without packages
        (['ws/src/docs/'], 'ws', None),
        # colcon was there, even if the folder is a package
        (
            ['p/package.xml', 'p/install/.colcon_install_layout', 'p/src/'],
            'p/src',
            'p',
        ),
        # the nearest one wins
        (
            ['o/build/.built_by', 'o/i/build/.built_by', 'o/i/src/'],
            'o/i/src',
            'o/i',
        ),
        (['o/build/.built_by', 'o/i/install/', 'o/i/x/'], 'o/i/x', 'o/i'),
        # but names below the src of a built workspace say nothing
        (
            ['ws/build/.built_by', 'ws/src/repo/src/p/package.xml'],
            'ws/src/repo/src',
            'ws',
        ),
        # ignored packages do not count
        (['ws/src/p/package.xml', 'ws/src/p/COLCON_IGNORE'], 'ws', None),
    ],
)
def test_root(tmp_path, paths, start, expected):
    make(tmp_path, *paths)
    root = find_root(tmp_path / start, home=tmp_path / 'elsewhere')
    assert root == (expected and tmp_path / expected)


def test_home_is_no_workspace_because_of_its_names(tmp_path):
    make(tmp_path, 'home/src/p/package.xml', 'home/build/', 'home/x/')
    assert find_root(tmp_path / 'home/x', home=tmp_path / 'home') is None
    assert find_root(tmp_path / 'home', home=tmp_path / 'home') is None


def test_home_is_a_workspace_when_colcon_built_there(tmp_path):
    make(tmp_path, 'home/build/.built_by', 'home/x/')
    home = tmp_path / 'home'
    assert find_root(home / 'x', home=home) == home


def test_folder_of_everyone_is_no_workspace(tmp_path):
    make(tmp_path, 'tmp/build/', 'tmp/mine/')
    (tmp_path / 'tmp').chmod(0o1777)
    assert find_root(tmp_path / 'tmp/mine', home=tmp_path / 'home') is None


@pytest.mark.parametrize('folder', ['/proc', '/proc/self'])
def test_links_in_proc_lead_to_no_workspace(tmp_path, folder):
    assert find_root(Path(folder), home=tmp_path) is None


def test_link_that_cannot_be_followed_is_passed_over(tmp_path):
    make(tmp_path, 'ws/src/p/package.xml', 'ws/src/p/scripts/')
    # as an ordinary user may not look behind one into a folder of others
    for name in ('a', 'src/a', 'src/p/setup.cfg', 'install', 'build'):
        (tmp_path / 'ws' / name).symlink_to('x' * 300)
    home = tmp_path / 'home'
    assert find_root(tmp_path / 'ws', home) == tmp_path / 'ws'
    assert find_root(tmp_path / 'ws/src/p/scripts', home) == tmp_path / 'ws'


def test_link_leads_to_the_real_workspace(tmp_path):
    make(tmp_path, 'ws/src/p/package.xml')
    (tmp_path / 'link').symlink_to(tmp_path / 'ws/src')
    root = find_root(tmp_path / 'link', home=tmp_path / 'home')
    assert root == tmp_path / 'ws'


@pytest.fixture
def scanned(monkeypatch):
    """Return the folders that are scanned."""
    folders = []
    scan = os.scandir

    def count(folder):
        folders.append(os.path.relpath(folder, Path.cwd()))
        return scan(folder)

    monkeypatch.setattr(os, 'scandir', count)
    return folders


def test_search_scans_each_folder_once_nearest_first(
    tmp_path, monkeypatch, scanned
):
    make(
        tmp_path,
        *('a/x/', 'b/COLCON_IGNORE', 'b/y/', '.git/z/', 'c/1/2/3/4/5/'),
        *('d/setup.cfg', 'd/file'),
    )
    (tmp_path / 'e').symlink_to('/proc/1/root/nowhere')
    monkeypatch.chdir(tmp_path)
    assert not has_package_below(tmp_path, 5)
    assert scanned == [
        *('.', 'a', 'b', 'c', 'd'),
        *('a/x', 'c/1', 'c/1/2', 'c/1/2/3', 'c/1/2/3/4'),
    ]
    make(tmp_path, 'c/1/package.xml', 'f/')
    scanned.clear()
    assert has_package_below(tmp_path, 5)
    assert scanned[-1] == 'c/1'


def test_search_ends_where_there_are_many_folders(
    tmp_path, monkeypatch, scanned
):
    make(tmp_path, *(f'{number}/' for number in range(12)), '9/package.xml')
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(workspace_root, 'PACKAGE_SEARCH_FOLDERS', 10)
    assert not has_package_below(tmp_path)
    assert len(scanned) == 11


@pytest.mark.parametrize(
    ('text', 'words', 'is_found'),
    [
        ('launch: [executable: {cmd: ls}]', ['a.yaml'], False),
        ('launch: [node: {pkg: p, exec: x}]', ['a.yaml'], True),
        ('launch: [include: {file: b.yaml}]', ['a.yaml'], True),
        ('<launch><executable cmd="$(find-pkg-share p)"/>', ['a.yaml'], True),
        ('launch: [executable: {cmd: ls}]', [], True),
    ],
)
def test_search_needs_a_launch_file_that_names_a_package(
    tmp_path, monkeypatch, text, words, is_found
):
    make(tmp_path, 'p/package.xml')
    (tmp_path / 'a.yaml').write_text(text)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv('HOME', '/nowhere')
    monkeypatch.delenv('ROS_WORKSPACE', raising=False)
    wanted = tmp_path if is_found else None
    assert find_workspace(None, words) == wanted
    assert find_workspace(None, words, builds=True) == tmp_path


@pytest.mark.parametrize(
    ('name', 'text', 'expected'),
    [
        ('package.xml', '', True),
        ('CMakeLists.txt', '', True),
        ('setup.py', '', True),
        ('pyproject.toml', '', True),
        ('setup.cfg', '[metadata]\nname = x\n', True),
        ('setup.cfg', '[flake8]\nname = x\n', False),
        ('README.md', '', False),
    ],
)
def test_package(tmp_path, name, text, expected):
    (tmp_path / name).write_text(text)
    assert is_package(tmp_path) is expected
