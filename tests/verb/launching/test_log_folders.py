# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from collections.abc import Callable
from pathlib import Path

from colcon_yamllaunch.verb.cli.environment_variables import KEPT_LOG_FOLDERS
from colcon_yamllaunch.verb.launching.log_folders import delete_old_log_folders
from colcon_yamllaunch.verb.launching.log_folders import locked
import pytest

Make = Callable[..., Path]


@pytest.fixture
def make(tmp_path: Path) -> Make:
    """Return a function that makes the folder of a launch."""

    def make_one(name: str, *, ran: bool = True) -> Path:
        folder = tmp_path / name
        (folder / 'node-1').mkdir(parents=True)
        if ran:
            (folder / 'launch.log').touch()
        return folder

    return make_one


def name_of(number: int) -> str:
    return f'launch_2026-01-01_00-{number // 60:02}-{number % 60:02}'


def pruned(folder: Path, kept: str | None) -> list[str]:
    """Prune, and return what is left."""
    variables = {} if kept is None else {'COLCON_LAUNCH_LOG_FOLDERS': kept}
    delete_old_log_folders(folder, variables, pytest.fail)
    return sorted(p.name for p in folder.parent.iterdir())


def test_the_oldest_launches_lose_their_folder(make: Make) -> None:
    names = [name_of(n) for n in range(5)]
    for name in names:
        make(name)
    assert pruned(make('launch_2026-01-02_00-00-00'), '2') == [
        *names[-2:],
        'launch_2026-01-02_00-00-00',
    ]


def test_by_default_many_are_kept(make: Make) -> None:
    for number in range(KEPT_LOG_FOLDERS + 3):
        make(name_of(number))
    left = pruned(make('launch_2026-01-02_00-00-00'), None)
    assert len(left) == KEPT_LOG_FOLDERS + 1
    assert name_of(2) not in left
    assert name_of(3) in left


@pytest.mark.parametrize('kept', ['99', 'all', ''])
def test_few_are_kept_all(make: Make, kept: str) -> None:
    for number in range(98):
        make(name_of(number))
    assert len(pruned(make('launch_2026-01-02_00-00-00'), kept)) == 99


def test_nothing_else_is_deleted(make: Make, tmp_path: Path) -> None:
    others = [
        'build_2026-01-01_00-00-00',
        'test_2025-01-01_00-00-00',
        'launch_notes',
        'launch_2026-01-01_00-00-00_old',
        '2026-01-01-00-00-00-123456-host-42',
    ]
    for name in others:
        make(name)
    target = make('elsewhere/launch')
    (tmp_path / 'launch_2026-01-01_00-00-01').symlink_to(target)
    (tmp_path / 'launch_2026-01-01_00-00-02').write_text('a file')
    before = sorted(p.name for p in tmp_path.iterdir())
    folder = make('launch_2026-01-02_00-00-00')
    assert pruned(folder, '0') == sorted([*before, folder.name])
    assert (target / 'launch.log').exists()


def test_the_latest_stays(make: Make, tmp_path: Path) -> None:
    for number in range(4):
        make(name_of(number))
    (tmp_path / 'latest_launch').symlink_to(name_of(0))
    (tmp_path / 'latest').symlink_to(name_of(1))
    assert name_of(0) in pruned(make('launch_2026-01-02_00-00-00'), '0')
    assert (tmp_path / name_of(1)).exists()
    assert not (tmp_path / name_of(2)).exists()


def test_a_launch_that_runs_keeps_its_folder(make: Make) -> None:
    old, older = make(name_of(1)), make(name_of(0))
    folder = make('launch_2026-01-02_00-00-00')
    with locked(old):
        assert pruned(folder, '0') == [old.name, folder.name]
    assert pruned(folder, '0') == [folder.name]
    assert not older.exists()


def test_launches_of_one_second_are_ordered_by_number(make: Make) -> None:
    names = [name_of(0), *(f'{name_of(0)}_{n}' for n in range(2, 12))]
    for name in names:
        make(name)
    left = pruned(make('launch_2026-01-02_00-00-00'), '2')
    assert left[:-1] == [f'{name_of(0)}_10', f'{name_of(0)}_11']


def test_looks_do_not_push_launches_out(make: Make) -> None:
    make(name_of(0))
    for number in range(1, 9):
        make(name_of(number), ran=False)
    assert pruned(make('launch_2026-01-02_00-00-00'), '1') == [
        name_of(0),
        name_of(8),
        'launch_2026-01-02_00-00-00',
    ]


@pytest.mark.parametrize('kept', ['-1', 'many', '1.5', '²'])
def test_without_a_number_nothing_is_deleted(make: Make, kept: str) -> None:
    make(name_of(0))
    folder = make('launch_2026-01-02_00-00-00')
    told: list[str] = []
    delete_old_log_folders(
        folder, {'COLCON_LAUNCH_LOG_FOLDERS': kept}, told.append
    )
    assert len(list(folder.parent.iterdir())) == 2
    (text,) = told
    assert f"not '{kept}'" in text


def test_a_folder_that_cannot_be_made_is_not_locked(tmp_path: Path) -> None:
    (tmp_path / 'file').touch()
    with locked(tmp_path / 'file' / 'log'), locked(None):
        assert (tmp_path / 'file').is_file()
