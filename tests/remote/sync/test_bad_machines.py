# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Machines whose disk is full or read-only, or that others changed."""

from collections.abc import Iterator
import json
import os
import shutil
from typing import Any, NoReturn

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.remote.sync.code_sync import Synced
import pytest
from support.developer import Developer, MachineHere
from support.hostile import Mounts, REMOUNT

pytestmark = [pytest.mark.full, pytest.mark.hostile]


@pytest.fixture(autouse=True)
def package(developer: Developer) -> None:
    developer.package('a')


@pytest.fixture
def mounts(developer: Developer) -> Iterator[Mounts]:
    root = developer.machine.root
    root.mkdir()
    mounts = Mounts(f"mount -t tmpfs -o size=400k,mode=755 none '{root}'")
    developer.machine.inside = mounts.inside
    yield mounts
    mounts.close()


def test_a_full_disk_there(developer: Developer, mounts: Mounts) -> None:
    big = developer.root / 'src/a/config/big'
    big.write_bytes(os.urandom(1_000_000))
    with pytest.raises(UserError, match='arm: the disk is full there'):
        developer.sync('a')
    root = developer.machine.root
    mounts.run(*REMOUNT, 'remount,size=8m', str(root))
    # what came before is not taken for somebody else's
    assert developer.sync('a').built == {'a'}


def test_a_read_only_workspace(developer: Developer, mounts: Mounts) -> None:
    root = developer.machine.root
    mounts.run(*REMOUNT, 'remount,size=8m', str(root))
    developer.sync('a')
    mounts.run(*REMOUNT, 'remount,ro', str(root))
    assert developer.sync('a') == Synced()
    developer.write('src/a/config/hello.txt', 'new')
    with pytest.raises(UserError, match=r'arm: .*Read-only file system'):
        developer.sync('a')


def test_a_damaged_record(developer: Developer) -> None:
    developer.sync('a')
    record = developer.machine.root / '.colcon_launch.synced.json'
    values = {'version': 4, 'root': str(record.parent), 'folders': {'a': 5}}
    for text in ('', '[]', '{"version": 1}', json.dumps(values)):
        record.write_text(text)
        # all of it is there as it is to be
        assert developer.sync('a').transferred == 0
        assert developer.sync('a') == Synced()


def test_an_interrupted_transfer_goes_on(developer: Developer) -> None:
    programs = developer.machine.home / 'programs'
    developer.machine.forget('rsync')
    rsync = programs / 'rsync'
    rsync.write_text('#!/bin/sh\nexit 12\n')
    rsync.chmod(0o755)
    with pytest.raises(UserError, match='arm: rsync failed with exit code 12'):
        developer.sync('a')
    # as if it had come to this
    developer.machine.write('src/a/config/hello.txt', 'hello\n')
    rsync.unlink()
    rsync.symlink_to(shutil.which('rsync') or '')
    assert developer.sync('a').built == {'a'}
    (developer.root / 'src/a/config/hello.txt').unlink()
    developer.sync('a')
    there = developer.machine.root / 'src/a/config/hello.txt'
    assert not there.exists()


def test_a_file_in_place_of_the_workspace(developer: Developer) -> None:
    developer.machine.root.write_text('')
    with pytest.raises(UserError, match='arm: cannot make the workspace'):
        developer.sync('a')


def test_a_file_in_place_of_a_folder(developer: Developer) -> None:
    developer.machine.write('src', 'a file')
    with pytest.raises(UserError, match='arm: '):
        developer.sync('a')


@pytest.mark.parametrize(
    'answer',
    [
        {},
        {'root': 5, 'changed': ['src/a'], 'holder': []},
        {'send': 'damaged', 'deleted': 0},
        {'send': {'/': ['etc/passwd']}, 'deleted': 0},
        {'send': {'src/a': ['../../../etc/passwd']}, 'deleted': 0},
    ],
)
def test_a_hostile_machine(
    developer: Developer, answer: dict[str, object]
) -> None:
    class Hostile(MachineHere):
        def ask(self, request: str, *_: object) -> dict[str, object]:
            first = {'root': '/', 'changed': ['src/a'], 'holder': []}
            return answer if request != 'build.begin' else first | answer

        def run_program(self, *_: object) -> NoReturn:
            pytest.fail('nothing may be sent')

    developer.connection = Hostile(developer.machine.home)
    with pytest.raises(UserError, match='arm: it answers what makes no sense'):
        developer.sync('a')


def test_a_file_that_is_edited_while_it_comes(developer: Developer) -> None:
    edited = developer.root / 'src/a/config/hello.txt'
    edit = 'edited'

    class Edited(MachineHere):
        def run_program(self, *words: Any) -> tuple[int, list[str]]:
            edited.write_text(edit)
            return super().run_program(*words)

    developer.machine = developer.connection = Edited(developer.machine.home)
    assert developer.sync('a').built == {'a'}
    there = developer.machine.root / 'src/a/config/hello.txt'
    assert there.read_text() == 'edited'
    assert developer.sync('a') == Synced()
    edit = 'and edited again'
    developer.write('src/a/config/hello.txt', 'new')
    developer.sync('a')
    assert there.read_text() == 'and edited again'
    edited.unlink()
    developer.sync('a')
    assert not there.exists()
