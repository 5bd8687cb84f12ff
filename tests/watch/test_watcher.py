# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The process that watches files, and the link to it."""

from collections.abc import Callable, Iterator
import json
import os
from pathlib import Path
import shutil
import signal
import time
from typing import Any
from unittest.mock import Mock

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.loop import ended_children, Loop
from colcon_yamllaunch.watch import watcher
from colcon_yamllaunch.watch.watched_files import Batch, Change
from colcon_yamllaunch.watch.watcher import WatcherClient
import pytest
from support.waiting import is_running

#: Seconds; a loaded machine needs some.
DEADLINE = 60


class Watched:
    """A folder that is watched, and what was told of it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.batches: list[Batch] = []
        self.warnings: list[str] = []
        self.settled: list[Change] = []
        self._loop = Loop()
        self.link = WatcherClient(
            self._loop,
            self.batches.append,
            self.warnings.append,
            folder.parent / 'watcher.log',
        )

    def start(self) -> None:
        """Watch, and return when changes are seen."""
        self.link.start()
        self.watch()
        # the one that is there is told, as it was written since
        self.wait(lambda: bool(self.batches))
        self.batches.clear()

    def watch(self, *files: Path) -> None:
        since = time.time_ns()
        self.write('first', str(since))
        self.link.watch([str(self.folder)], map(str, files), since)

    def write(self, name: str, text: str) -> None:
        # at once, so that it is one change
        new = self.folder.parent / 'new'
        new.write_text(text)
        new.rename(self.folder / name)

    def wait(self, is_so: Callable[[], bool]) -> None:
        deadline = time.monotonic() + DEADLINE
        while not is_so():
            assert time.monotonic() < deadline, self.batches
            self._loop.call_later(0.1, self._loop.wake)
            self._loop.run_once()
            for pid, status in ended_children({*self._loop.children}):
                self._loop.children.pop(pid)[0](status)

    @property
    def pid(self) -> int:
        return next(iter(self._loop.children), 0)

    def told(self) -> list[str]:
        """Return what was told next, as one batch."""
        self.wait(lambda: bool(self.batches))
        batch = self.batches.pop(0)
        return [f'{c.kind} {Path(c.path).name}' for c in batch.changes]

    def names(self) -> set[str]:
        """Return the names of all that was told."""
        return {Path(c.path).name for b in self.batches for c in b.changes}

    def settle(self) -> None:
        """Wait until all that happened so far was told, and set it aside."""
        name = f'settled {time.monotonic_ns()}'
        self.write(name, name)
        self.wait(lambda: name in self.names())
        told = [c for batch in self.batches for c in batch.changes]
        self.settled = [c for c in told if Path(c.path).name != name]
        self.batches.clear()

    def close(self) -> None:
        self.link.close()
        self._loop.close()


@pytest.fixture
def watched(tmp_path: Path) -> Iterator[Watched]:
    folder = tmp_path.resolve() / 'arm'
    folder.mkdir()
    found = Watched(folder)
    yield found
    found.close()


def test_changes_are_reported(watched: Watched) -> None:
    watched.start()
    watched.write('a.cpp', 'one')
    assert watched.told() == ['new a.cpp']
    watched.write('a.cpp', 'two')
    assert watched.told() == ['changed a.cpp']
    (watched.folder / 'a.cpp').unlink()
    assert watched.told() == ['deleted a.cpp']
    # one in a folder that is new
    (watched.folder / 'deep').mkdir()
    watched.write('deep/b.cpp', 'one')
    assert watched.told() == ['new b.cpp']
    watched.write('deep/b.cpp', 'two')
    assert watched.told() == ['changed b.cpp']
    # now that one was told which comes after it, nothing else was
    assert watched.batches == []
    assert watched.warnings == []


def vim(file: Path, text: str) -> None:
    probe = file.with_name('4913')
    probe.touch()
    probe.unlink()
    backup = file.rename(file.with_name(f'{file.name}~'))
    file.write_text(text)
    backup.unlink()


def emacs(file: Path, text: str) -> None:
    lock = file.with_name(f'.#{file.name}')
    lock.symlink_to('me@here.123:456')
    draft = file.with_name(f'#{file.name}#')
    draft.write_text(text)
    shutil.copy(file, file.with_name(f'{file.name}~'))
    file.write_text(text)
    draft.unlink()
    lock.unlink()


def gnome(file: Path, text: str) -> None:
    draft = file.with_name('.goutputstream-A1B2C3')
    draft.write_text(text)
    draft.rename(file)


def jetbrains(file: Path, text: str) -> None:
    new = file.with_name(f'{file.name}___jb_tmp___')
    new.write_text(text)
    old = file.rename(file.with_name(f'{file.name}___jb_old___'))
    new.rename(file)
    old.unlink()


def test_only_the_saved_file_is_reported(watched: Watched) -> None:
    elsewhere = watched.folder.parent / 'elsewhere'
    elsewhere.mkdir()
    (elsewhere / 'a.cpp').touch()
    (watched.folder / 'linked').symlink_to(elsewhere)
    watched.start()
    for save in (vim, emacs, gnome, jetbrains):
        save(elsewhere / 'a.cpp', save.__name__)
        watched.wait(lambda: bool(watched.batches))
        watched.settle()
        paths = {c.path for c in watched.settled}
        assert paths == {str(watched.folder / 'linked' / 'a.cpp')}


def test_folder_that_replaces_another_is_watched(watched: Watched) -> None:
    inner = watched.folder / 'inner'
    inner.mkdir()
    watched.start()

    def put(folder: Path) -> None:
        new, old = folder.with_name('.new'), folder.with_name('.old')
        shutil.copytree(folder, new)
        folder.rename(old)
        new.rename(folder)
        shutil.rmtree(old)

    def empty(folder: Path) -> None:
        # the new one may have the same number
        shutil.rmtree(folder)
        folder.mkdir()

    for replace in (put, empty):
        for number, folder in enumerate((inner, watched.folder)):
            replace(folder)
            watched.settle()
            (folder / 'a.cpp').write_text(f'{replace} {number}')
            watched.wait(lambda: 'a.cpp' in watched.names())


def test_git_checkout_is_one_batch(watched: Watched) -> None:
    git = watched.folder / '.git'
    git.mkdir()
    watched.start()
    lock = git / 'index.lock'
    lock.touch()
    for name in 'abcdefgh':
        watched.write(name, 'x')
        # far longer than events are waited for
        time.sleep(0.05)
    lock.unlink()
    assert watched.told() == [f'new {name}' for name in 'abcdefgh']
    # one that stays, as that of a commit whose message is being written
    lock.touch()
    watched.write('a', 'another')
    assert watched.told() == ['changed a']
    assert lock.exists()


def test_watched_files_can_be_replaced(watched: Watched) -> None:
    other = watched.folder.parent / 'other.yaml'
    other.write_text('x')
    watched.start()
    watched.watch(other)
    assert watched.told() == ['changed first']
    other.write_text('another')
    assert watched.told() == ['changed other.yaml']


def test_killed_watcher_is_restarted_and_misses_nothing(
    watched: Watched,
) -> None:
    watched.start()
    watched.write('b.cpp', 'one')
    assert watched.told() == ['new b.cpp']
    first = watched.pid
    os.kill(first, signal.SIGKILL)
    watched.write('a.cpp', 'one')
    watched.wait(lambda: watched.pid not in (0, first))
    # told as changed, as nobody knows how it was
    watched.wait(lambda: bool(watched.batches))
    assert 'a.cpp' in {Path(c.path).name for c in watched.batches[0].changes}
    assert not is_running(first)


def test_watcher_that_cannot_run_is_given_up(
    watched: Watched, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(watcher, 'PROGRAM', 'no_such_module')
    monkeypatch.setattr(limits, 'SHORTEST_RESTART_PAUSE', 0.001)
    monkeypatch.setattr(limits, 'HELPER_RESTARTS', 1)
    watched.link.start()
    watched.wait(lambda: bool(watched.warnings))
    (warning,) = watched.warnings
    start, _, reason = warning.partition(': nothing is watched any more (')
    assert start == 'the process that watches files exited with code 1'
    error = "ModuleNotFoundError: No module named 'no_such_module'; see /"
    assert reason.startswith(error)
    assert watched.pid == 0


@pytest.fixture
def own_signals() -> Iterator[None]:
    before = signal.getsignal(signal.SIGIO)
    wakeup = signal.set_wakeup_fd(-1)
    yield
    signal.set_wakeup_fd(wakeup)
    signal.signal(signal.SIGIO, before)


def run(folder: Path) -> list[Any]:
    """Run a watcher here for a folder, until it has told of it twice."""
    (folder / 'first').touch()
    source, writer = os.pipe()
    request = {'folders': [str(folder)], 'files': [], 'since': 0}
    os.write(writer, json.dumps(request).encode() + b'\n')
    told: list[Any] = []

    def tell(*message: Any) -> None:
        told.append(message)
        if len(told) == 1:
            (folder / 'late').touch()
        else:
            os.close(writer)

    watcher.Watcher(source, tell).run()
    os.close(source)
    return told


@pytest.mark.usefixtures('own_signals')
@pytest.mark.parametrize(
    ('error', 'note'),
    [
        (
            'OS file watch limit reached. (os error 28)',
            'sudo sysctl fs.inotify.max_user_watches=',
        ),
        (
            'Error creating recommended watcher: Too many open files',
            'sudo sysctl fs.inotify.max_user_instances=',
        ),
        ('Function not implemented', 'the kernel does not tell of changes (F'),
    ],
)
def test_watcher_polls_without_inotify(
    error: str,
    note: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fail(*arguments: object) -> None:
        assert not arguments[-1], 'it passes over what goes wrong'
        raise OSError(error)

    monkeypatch.setattr('watchfiles._rust_notify.RustNotify', fail)
    monkeypatch.setattr(watcher, 'POLLING_INTERVAL', 0.01)
    (first, _, notes), (late, _, none) = run(tmp_path)
    assert [Path(c.path).name for c in first] == ['first']
    assert [Path(c.path).name for c in late] == ['late']
    (text,) = notes
    assert note in text
    assert none == []


@pytest.mark.usefixtures('own_signals')
def test_polling_variable_makes_the_watcher_poll(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(watcher.POLLING_VARIABLE, 'true')
    monkeypatch.delattr('watchfiles._rust_notify.RustNotify')
    monkeypatch.setattr(watcher, 'POLLING_INTERVAL', 0.01)
    assert [notes for _, _, notes in run(tmp_path)] == [[], []]


@pytest.mark.usefixtures('own_signals')
def test_scan_finds_changes_that_the_kernel_missed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # as after a suspend or a flood
    silent = Mock(return_value=Mock(watch=lambda *_: 'timeout'))
    monkeypatch.setattr('watchfiles._rust_notify.RustNotify', silent)
    monkeypatch.setattr(watcher, 'SCAN_INTERVAL', 0.01)
    monkeypatch.setattr(watcher, 'SCAN_FACTOR', 0)
    assert [Path(c.path).name for c in run(tmp_path)[1][0]] == ['late']


@pytest.mark.parametrize(
    ('kind', 'is_remote'),
    [
        *(('ext4', False), ('overlay', False), ('tmpfs', False)),
        *(('nfs4', True), ('fuse.sshfs', True), ('virtiofs', True)),
    ],
)
def test_network_file_systems_are_recognized(
    kind: str, is_remote: bool
) -> None:
    mounts = {'': 'ext4', '/home/me/ws': kind, '/home/me/ws/x': 'ext4'}
    assert watcher._is_remote('/home/me/ws/src/arm', mounts) == is_remote
    assert not watcher._is_remote('/home/me/wso', mounts)
    assert not watcher._is_remote('/home/me/ws/x/y', mounts)
