# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from collections.abc import Callable
import os
from pathlib import Path
from types import SimpleNamespace

from colcon_yamllaunch.observers import log_store
from colcon_yamllaunch.observers.log_files import LogFile, LogQuota
from colcon_yamllaunch.observers.log_store import INDEX_NAME, LogStore
from colcon_yamllaunch.verb.environment_variables import KEPT_LOG_FOLDERS
from colcon_yamllaunch.verb.log_folders import locked, log_store_of
import pytest
from support.hostile import needs_other_user, OTHER_USER

Make = Callable[..., Path]
#: The launch that begins.
NEWEST = 'launch_2026-01-02_00-00-00'


@pytest.fixture
def make(tmp_path: Path) -> Make:
    """Return a function that makes the folder of a launch."""

    def make_one(name: str, *, ran: bool = True) -> Path:
        folder = tmp_path / name
        (folder / 'node-1').mkdir(parents=True)
        names = ('launch.log', 'events.jsonl') if ran else ('logger_all.log',)
        for file in names:
            (folder / file).touch()
        return folder

    return make_one


def name_of(number: int) -> str:
    return f'launch_2026-01-01_00-{number // 60:02}-{number % 60:02}'


def store_of(
    folder: Path, kept: str | None = None, total: str | None = None
) -> LogStore:
    variables = {
        'COLCON_LAUNCH_LOG_FOLDERS': kept,
        'COLCON_LAUNCH_LOG_TOTAL': total,
    }
    given = {n: v for n, v in variables.items() if v is not None}
    store = log_store_of(folder, given, pytest.fail)
    assert store is not None
    return store


def pruned(folder: Path, kept: str | None) -> list[str]:
    """Prune, and return what is left."""
    store = store_of(folder, kept)
    while store.tidy():
        continue
    return sorted(p.name for p in folder.parent.iterdir() if p.is_dir())


def test_the_oldest_launches_lose_their_folder(make: Make) -> None:
    names = [name_of(n) for n in range(5)]
    for name in names:
        make(name)
    assert pruned(make(NEWEST), '2') == [
        *names[-2:],
        NEWEST,
    ]


def test_by_default_many_are_kept(make: Make) -> None:
    for number in range(KEPT_LOG_FOLDERS + 3):
        make(name_of(number))
    left = pruned(make(NEWEST), None)
    assert len(left) == KEPT_LOG_FOLDERS + 1
    assert name_of(2) not in left
    assert name_of(3) in left


@pytest.mark.parametrize('kept', ['99', 'all', ''])
def test_few_are_kept_all(make: Make, kept: str) -> None:
    for number in range(98):
        make(name_of(number))
    assert len(pruned(make(NEWEST), kept)) == 99


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
    # of nobody knows whom
    (tmp_path / 'launch_2026-01-01_00-00-03').mkdir()
    (tmp_path / 'launch_2026-01-01_00-00-03' / 'notes').touch()
    before = sorted(p.name for p in tmp_path.iterdir() if p.is_dir())
    folder = make(NEWEST)
    assert pruned(folder, '0') == sorted([*before, folder.name])
    assert (target / 'launch.log').exists()
    assert (tmp_path / 'launch_2026-01-01_00-00-02').exists()


@needs_other_user
@pytest.mark.hostile
def test_the_folder_of_another_user_stays(make: Make) -> None:
    other = make(name_of(0))
    os.chown(other, OTHER_USER, OTHER_USER)
    folder = make(NEWEST)
    assert pruned(folder, '0') == [other.name, folder.name]


@pytest.mark.hostile
def test_links_in_a_folder_are_not_followed(
    make: Make, tmp_path: Path
) -> None:
    treasure = tmp_path / 'treasure'
    treasure.mkdir()
    (treasure / 'coin').touch()
    old = make(name_of(0))
    (old / 'node-1' / 'link').symlink_to(treasure)
    assert old.name not in pruned(make(NEWEST), '0')
    assert (treasure / 'coin').exists()


@pytest.mark.hostile
def test_after_the_clock_was_set_back_the_latest_stay(make: Make) -> None:
    names = []
    for number in range(4):
        names.append(f'launch_2030-01-01_00-00-0{number}')
        pruned(make(names[-1]), '2')
    for number in range(4):
        names.append(name_of(number))
        left = pruned(make(names[-1]), '2')
        assert left == sorted(names[-3:])


@pytest.mark.hostile
def test_what_is_remembered_of_folders_may_be_damaged(make: Make) -> None:
    for number, text in enumerate(('', '[]', '{"a": 1}', '\0')):
        folder = make(name_of(number))
        (folder.parent / INDEX_NAME).write_text(text)
        assert len(pruned(folder, '1')) == min(2, number + 1)


def full_of(folder: Path, size: int) -> Path:
    (folder / 'node-1' / 'stdout.log').write_bytes(b'x' * size)
    return folder


@pytest.mark.hostile
def test_all_folders_together_keep_to_a_limit(make: Make) -> None:
    for number in range(10):
        full_of(make(name_of(number)), 1_000_000)
    folder = make(NEWEST)
    running = folder.with_name(name_of(0))
    with locked(running):
        store = store_of(folder, total='5MB')
        assert store.allowed(0, 10_000) >= 10_000
        left = sorted(p.name for p in folder.parent.iterdir() if p.is_dir())
        assert left == [
            running.name,
            *(name_of(n) for n in range(7, 10)),
            folder.name,
        ]
        # what it may take when nothing else may be deleted
        assert 3_900_000 < store.allowed(10_000, 9_000_000) <= 4_000_000
    left = sorted(p.name for p in folder.parent.iterdir() if p.is_dir())
    assert left == [running.name, folder.name]


@pytest.mark.hostile
def test_what_nodes_write_beside_counts(make: Make) -> None:
    full_of(make(name_of(0)), 1_000_000)
    folder = full_of(make(NEWEST), 4_500_000)
    store = store_of(folder, total='8MB')
    assert store.allowed(0, 3_000_000) == 3_500_000
    assert not (folder.parent / name_of(0)).exists()


@pytest.mark.hostile
def test_a_launch_that_writes_much_keeps_to_the_limit_of_all(
    make: Make,
) -> None:
    for number in range(10):
        full_of(make(name_of(number)), 1_000_000)
    folder = make(NEWEST)
    store = store_of(folder, total='12MB')
    told: list[str] = []
    quota = LogQuota(None, 1, told.append, store.allowed)
    file = LogFile(folder / 'launch.log', quota)
    for _ in range(200):
        file.write(b'x' * 99_999 + b'\n')
        files = [p for p in folder.parent.rglob('*') if p.is_file()]
        assert sum(p.stat().st_size for p in files) < 12_100_000
    file.close()
    assert not (folder.parent / name_of(9)).exists()
    assert quota.used > 10_000_000
    (text,) = told
    assert 'COLCON_LAUNCH_LOG_TOTAL' in text


@pytest.mark.hostile
def test_a_full_disk_costs_old_logs_no_more_than_the_new_ones_take(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number in range(5):
        full_of(make(name_of(number)), 1_000_000)
    folder = make(NEWEST)
    store = store_of(folder)
    free = 50_000_000

    def statvfs(_: object) -> SimpleNamespace:
        return SimpleNamespace(f_frsize=1, f_blocks=100_000_000, f_bavail=free)

    monkeypatch.setattr('os.statvfs', statvfs)
    assert store.allowed(0, 2_000_000) >= 2_000_000
    # somebody else fills the disk
    free = 0
    assert store.allowed(2_000_000, 2_500_000) == 2_000_000
    left = [p for p in folder.parent.iterdir() if p.is_dir()]
    assert len(left) == 5


def test_many_folders_are_measured_once(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number in range(20):
        full_of(make(name_of(number)), 1000)
    pruned(make(NEWEST), None)
    folder = make('launch_2026-01-02_00-00-01')
    measured: list[Path] = []

    def size_of(path: Path) -> int:
        measured.append(path)
        return 0

    monkeypatch.setattr(log_store, '_size_of', size_of)
    pruned(folder, None)
    # the launch before this one has ended since
    assert [p.name for p in measured] == [NEWEST]


def test_the_latest_stays(make: Make, tmp_path: Path) -> None:
    for number in range(4):
        make(name_of(number))
    (tmp_path / 'latest_launch').symlink_to(name_of(0))
    (tmp_path / 'latest').symlink_to(name_of(1))
    assert name_of(0) in pruned(make(NEWEST), '0')
    assert (tmp_path / name_of(1)).exists()
    assert not (tmp_path / name_of(2)).exists()


def test_a_launch_that_runs_keeps_its_folder(make: Make) -> None:
    old, older = make(name_of(1)), make(name_of(0))
    folder = make(NEWEST)
    with locked(old):
        assert pruned(folder, '0') == [old.name, folder.name]
    assert pruned(folder, '0') == [folder.name]
    assert not older.exists()


def test_launches_of_one_second_are_ordered_by_number(make: Make) -> None:
    names = [name_of(0), *(f'{name_of(0)}_{n}' for n in range(2, 12))]
    for name in names:
        make(name)
    left = pruned(make(NEWEST), '2')
    assert left[:-1] == [f'{name_of(0)}_10', f'{name_of(0)}_11']


def test_looks_do_not_push_launches_out(make: Make) -> None:
    make(name_of(0))
    for number in range(1, 9):
        make(name_of(number), ran=False)
    assert pruned(make(NEWEST), '1') == [
        name_of(0),
        name_of(8),
        NEWEST,
    ]


@pytest.mark.parametrize(
    ('variable', 'text'),
    [
        *(('FOLDERS', text) for text in ('-1', 'many', '1.5', '²')),
        *(('TOTAL', text) for text in ('much', '1kB', '-1MB')),
    ],
)
def test_without_a_number_or_size_nothing_is_deleted(
    make: Make, variable: str, text: str
) -> None:
    make(name_of(0))
    warnings: list[str] = []
    variables = {f'COLCON_LAUNCH_LOG_{variable}': text}
    assert log_store_of(make(NEWEST), variables, warnings.append) is None
    (warning,) = warnings
    assert f"not '{text}'" in warning


def test_without_a_limit_of_all_nothing_is_deleted_for_it(make: Make) -> None:
    full_of(make(name_of(0)), 1000)
    folder = make(NEWEST)
    store = store_of(folder, total='none')
    assert store.allowed(0, 10**15) >= 10**15
    assert (folder.parent / name_of(0)).exists()


def test_a_folder_that_cannot_be_made_is_not_locked(tmp_path: Path) -> None:
    (tmp_path / 'file').touch()
    with locked(tmp_path / 'file' / 'log'), locked(None):
        assert (tmp_path / 'file').is_file()
