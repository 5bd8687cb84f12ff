# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Workspaces of others."""

from collections.abc import Callable
import os
from pathlib import Path

from colcon_yamllaunch.verb.environment_variables import TRUSTED
from colcon_yamllaunch.workspace.packages.workspace_root import (
    find_root,
    TRUST,
    Trust,
    UntrustedError,
)
import pytest
from support.hostile import needs_other_user, OTHER_USER

pytestmark = [pytest.mark.hostile, needs_other_user]


def give_away(*paths: Path) -> None:
    for path in paths:
        os.chown(path, OTHER_USER, OTHER_USER, follow_symlinks=False)


def workspace(root: Path) -> Path:
    for name in ('build', 'install', 'log', 'src'):
        (root / name).mkdir(parents=True)
    (root / 'install/.colcon_install_layout').write_text('isolated\n')
    for name in ('setup.bash', 'local_setup.sh'):
        (root / 'install' / name).touch()
    (root / 'build/.colcon_launch.index.json').touch()
    (root / 'build/.colcon_launch_environments').mkdir()
    (root / 'src/package.xml').touch()
    return root


def find(start: Path, **environment: str) -> Path | None:
    return find_root(start, start.parents[1] / 'home', Trust(environment))


@pytest.fixture
def bait(tmp_path: Path) -> Path:
    """Make a folder of everyone in which somebody has put a workspace."""
    root = workspace(tmp_path / 'tmp')
    give_away(root / 'install', *(root / 'install').iterdir())
    root.chmod(0o1777)
    (root / 'mine').mkdir()
    return root


def test_workspace_in_a_folder_of_everyone_is_no_lure(bait: Path) -> None:
    with pytest.raises(UntrustedError) as e:
        find(bait / 'mine')
    assert f'{bait / "install"} belongs to ' in str(e.value)
    assert f'(user {OTHER_USER})' in str(e.value)
    assert f'export {TRUST}={bait} ' in str(e.value)


def test_own_workspace_in_a_folder_of_everyone_is_used(bait: Path) -> None:
    (bait / 'mine/src/package').mkdir(parents=True)
    (bait / 'mine/src/package/package.xml').touch()
    assert find(bait / 'mine') == bait / 'mine'


def test_folder_of_everyone_is_not_used_even_if_all_is_own(
    tmp_path: Path,
) -> None:
    root = workspace(tmp_path / 'tmp')
    root.chmod(0o1777)
    with pytest.raises(UntrustedError, match='everyone may put files there'):
        find(root / 'src')
    assert find(root / 'src', **{TRUST: str(root)}) == root


@pytest.mark.parametrize(
    'path',
    [
        '.',
        'build',
        'build/.colcon_launch.index.json',
        'build/.colcon_launch_environments',
        'install',
        'install/.colcon_install_layout',
        'install/setup.bash',
        'install/local_setup.sh',
        'log',
    ],
)
def test_no_part_of_a_workspace_may_be_of_others(
    tmp_path: Path, path: str
) -> None:
    root = workspace(tmp_path / 'x/ws')
    assert find(root) == root
    give_away(root / path)
    with pytest.raises(UntrustedError) as e:
        find(root / 'src')
    assert f'{root / path} belongs to' in str(e.value)


def link_of_others(install: Path, target: Path) -> None:
    install.rename(target)
    install.symlink_to(target)
    give_away(install)


def link_to_others(install: Path, target: Path) -> None:
    install.rename(target)
    install.symlink_to(target)
    give_away(target)


@pytest.mark.parametrize('make', [link_of_others, link_to_others])
def test_link_and_target_have_to_be_own(
    tmp_path: Path, make: Callable[[Path, Path], None]
) -> None:
    root = workspace(tmp_path / 'x/ws')
    make(root / 'install', tmp_path / 'elsewhere')
    with pytest.raises(UntrustedError, match='install belongs to'):
        find(root)


def test_other_folders_of_the_arguments_count(tmp_path: Path) -> None:
    root = workspace(tmp_path / 'ws')
    (tmp_path / 'other').mkdir()
    Trust({}).check(root, tmp_path / 'other', tmp_path / 'other')
    give_away(tmp_path / 'other')
    with pytest.raises(UntrustedError):
        Trust({}).check(root, install_base=tmp_path / 'other')
    with pytest.raises(UntrustedError):
        Trust({}).check(root, build_base=tmp_path / 'other')


def test_source_of_others_is_told_before_it_is_looked_through(
    tmp_path: Path,
) -> None:
    root = tmp_path / 'x/ws'
    (root / 'src').mkdir(parents=True)
    # a fresh clone, such as one that a container mounts
    give_away(root)
    with pytest.raises(UntrustedError, match='/ws belongs to'):
        find(root / 'src')
    (root / 'src').rename(root / 'package')
    (root / 'package/package.xml').touch()
    with pytest.raises(UntrustedError, match='/ws belongs to'):
        find(root)


def test_folder_of_others_that_is_no_workspace_is_no_error(
    tmp_path: Path,
) -> None:
    (tmp_path / 'x/y').mkdir(parents=True)
    give_away(tmp_path / 'x/y')
    assert find(tmp_path / 'x/y') is None


@pytest.mark.parametrize(
    ('listed', 'expected'),
    [
        ('*', True),
        ('{root}', True),
        ('/nowhere:{root}/', True),
        ('{root}/..', True),
        ('{link}', True),
        ('{root}/install', False),
        ('{root}2', False),
        ('', False),
        # what these mean depends on where one is
        ('.', False),
        ('ws', False),
    ],
)
def test_list_of_what_is_trusted(
    tmp_path: Path,
    listed: str,
    expected: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    root = workspace(tmp_path / 'x/ws')
    (tmp_path / 'link').symlink_to(root)
    monkeypatch.chdir(tmp_path / 'x')
    give_away(root / 'install')
    text = listed.format(root=root, link=tmp_path / 'link')
    try:
        assert find(root, **{TRUST: text}) == root
    except UntrustedError:
        assert not expected
    else:
        assert expected


@pytest.mark.parametrize(
    ('sudo', 'user', 'expected'),
    [
        # as in git: root by sudo is the one who called it
        (str(OTHER_USER), 0, True),
        ('', 0, False),
        ('x', 0, False),
        # another one by sudo is not
        (str(OTHER_USER), 12345, False),
    ],
)
def test_user_of_sudo(
    tmp_path: Path,
    sudo: str,
    user: int,
    expected: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    root = workspace(tmp_path / 'ws')
    give_away(root)
    monkeypatch.setattr(os, 'geteuid', lambda: user)
    trust = Trust({'SUDO_UID': sudo})
    if expected:
        trust.check(root)
    else:
        with pytest.raises(UntrustedError):
            trust.check(root)


def test_workspace_of_root_is_used_by_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, 'geteuid', lambda: OTHER_USER)
    root = workspace(tmp_path / 'x/ws')
    assert find(root) == root


def test_colcon_lists_the_variable() -> None:
    assert TRUSTED.name == TRUST
