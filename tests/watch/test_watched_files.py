# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which writes are changes, and of what."""

import os
from pathlib import Path
import shutil
import tempfile
import time

from colcon_yamllaunch.watch.watched_files import WatchedFiles
from hypothesis import given, strategies
import pytest
from support.random_cases import RANDOM


class Tree:
    """A package, and what became of it since somebody looked last."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.package = root / 'src' / 'arm'
        self.package.mkdir(parents=True)
        self.files = WatchedFiles()

    def write(self, path: str, text: str = 'x') -> Path:
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        return file

    def watch(self, *files: Path, since: int | None = None) -> list[str]:
        since = time.time_ns() + 10**12 if since is None else since
        names = [str(file) for file in files]
        found = self.files.watch([str(self.package)], names, since)
        return [self._shown(c.kind, c.path) for c in found]

    def changes(self, *paths: str) -> list[str]:
        """Tell what an event about paths comes to."""
        names = [str(self.root / path) for path in paths]
        if any(map(self.files.needs_scan, names)):
            return self.again()
        found = self.files.changes(names)
        return [self._shown(c.kind, c.path) for c in found]

    def again(self) -> list[str]:
        """Tell what a look comes to."""
        found = self.files.scan()
        return [self._shown(c.kind, c.path) for c in found]

    def _shown(self, kind: str, path: str) -> str:
        return f'{kind} {os.path.relpath(path, self.root)}'


@pytest.fixture
def tree(tmp_path: Path) -> Tree:
    return Tree(tmp_path.resolve())


def test_saving_the_same_content_is_no_change(tree: Tree) -> None:
    a = tree.write('src/arm/a.cpp', 'one')
    tree.watch()
    for text in ('one', 'two', 'two', 'one'):
        changed = a.read_text() != text
        # in one tick of the clock, too
        a.write_text(text)
        assert bool(tree.changes('src/arm/a.cpp')) == changed
    os.utime(a)
    assert tree.again() == []


def test_change_is_found_after_the_clock_went_back(tree: Tree) -> None:
    a = tree.write('src/arm/a.cpp', 'one')
    tree.watch()
    a.write_text('two')
    past = time.time() - 10**6
    os.utime(a, (past, past))
    assert tree.again() == ['changed src/arm/a.cpp']


def test_rewritten_file_is_noted_once(
    tree: Tree,
) -> None:
    a, b = tree.write('src/arm/a.cpp', 'one'), tree.write('src/arm/b.cpp')
    past = time.time() - 60
    for file in (a, b):
        os.utime(file, (past, past))
    tree.watch()
    # ticks of the clock go by until the file system has another time
    before = a.stat().st_ctime_ns
    while a.stat().st_ctime_ns == before:
        # as some editors do it, and scripts
        kept = a.rename(a.with_name('a.cpp~'))
        a.write_text('one')
        kept.unlink()
    assert tree.changes('src/arm/a.cpp') == []
    assert tree.changes('src/arm/b.cpp') == []
    again = tree.files.pop_rewritten()
    assert [(c.kind, c.path) for c in again] == [('again', str(a))]
    assert tree.files.pop_rewritten() == []
    assert tree.again() == []
    assert tree.files.pop_rewritten() == []


@pytest.mark.parametrize(
    'name',
    [
        *('4913', '.a.cpp.swp', '.a.cpp.swx', 'a.cpp~', '#a.cpp#', '.#a.cpp'),
        *('a.cpp___jb_tmp___', '.goutputstream-ABC', 'a.cpp.kate-swp'),
        'a.pyc',
        *('.git/index', '__pycache__/a.py', '.vscode/x.json'),
    ],
)
def test_files_of_editors_and_caches_are_ignored(
    tree: Tree, name: str
) -> None:
    tree.watch()
    tree.write(f'src/arm/{name}')
    assert tree.changes(f'src/arm/{name}') == []
    assert tree.again() == []


@pytest.mark.parametrize('folder', ['build', 'install', 'log'])
def test_folders_of_colcon_are_ignored(tree: Tree, folder: str) -> None:
    # a workspace that is its only package
    tree.write(f'src/arm/{folder}/COLCON_IGNORE')
    tree.watch()
    tree.write(f'src/arm/{folder}/x/a.cpp')
    assert tree.changes(f'src/arm/{folder}/x/a.cpp') == []
    assert tree.again() == []
    watched = tree.files.watched_folders - {str(tree.root)}
    assert not any(folder in path for path in watched)


def test_file_that_is_being_saved_is_partly_written(tree: Tree) -> None:
    a = tree.write('src/arm/a.cpp', 'one')
    tree.watch()
    assert not tree.files.is_partly_written(str(a))
    a.write_text('')
    assert tree.files.is_partly_written(str(a))
    a.unlink()
    assert tree.files.is_partly_written(str(a))
    tree.again()
    assert not tree.files.is_partly_written(str(a))
    tree.write('src/arm/a.cpp', '')
    assert tree.files.is_partly_written(str(a))
    # it was so before
    tree.again()
    assert not tree.files.is_partly_written(str(a))


def test_new_and_removed_folders_are_noticed(tree: Tree) -> None:
    tree.watch()
    tree.write('src/arm/more/deep/a.cpp')
    assert tree.changes('src/arm/more') == ['new src/arm/more/deep/a.cpp']
    assert str(tree.package / 'more' / 'deep') in tree.files.watched_folders
    # a branch that does not have it, and back
    shutil.rmtree(tree.package)
    gone = tree.changes('src/arm')
    assert gone == ['deleted src/arm/more/deep/a.cpp']
    assert str(tree.package.parent) in tree.files.watched_folders
    tree.write('src/arm/a.cpp')
    assert tree.changes('src/arm') == ['new src/arm/a.cpp']


def test_changes_have_the_watched_names_of_files(tree: Tree) -> None:
    real = tree.write('elsewhere/deep/a.yaml')
    shared = tree.write('shared/b.yaml')
    (tree.package / 'config').symlink_to(real.parent)
    (tree.package / 'b.yaml').symlink_to(shared)
    install = tree.root / 'install.yaml'
    install.symlink_to(real)
    tree.watch(install)
    real.write_text('another')
    names = ['changed install.yaml', 'changed src/arm/config/a.yaml']
    assert tree.changes('elsewhere/deep/a.yaml') == names
    shared.write_text('another')
    (found,) = tree.files.changes([str(shared)])
    assert found.path == str(tree.package / 'b.yaml')
    assert found.real == str(shared)
    # what else lies there is nobody's
    tree.write('shared/c.yaml')
    assert tree.changes('shared/c.yaml') == []
    # another target of the link
    (tree.package / 'b.yaml').unlink()
    (tree.package / 'b.yaml').symlink_to(real)
    assert tree.again() == []
    shutil.copy(tree.write('x', 'third'), real)
    assert 'changed src/arm/b.yaml' in tree.changes('elsewhere/deep/a.yaml')


def test_folders_beside_a_single_file_are_ignored(tree: Tree) -> None:
    file = tree.write('elsewhere/a.yaml')
    tree.watch(file)
    for name, needs_scan in (
        ('elsewhere/more', False),
        ('src/other', False),
        ('src/arm/more', True),
        ('src/arm', True),
    ):
        folder = tree.root / name
        folder.mkdir(exist_ok=True)
        assert tree.files.needs_scan(str(folder)) == needs_scan


def test_circular_links_are_followed_once(tree: Tree) -> None:
    tree.write('src/arm/a.cpp')
    (tree.package / 'loop').symlink_to(tree.package)
    (tree.package / 'dangling').symlink_to('nowhere')
    tree.watch()
    assert tree.again() == []


def test_large_file_is_compared_by_its_times(
    tree: Tree, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr('colcon_yamllaunch.common.fingerprint.READ_SIZE', 2)
    tree.write('src/arm/a.bag', 'one')
    tree.watch()
    assert tree.again() == []
    # once the clock of the file system has moved on
    deadline = time.monotonic() + 60
    found: list[str] = []
    while not found and time.monotonic() < deadline:
        tree.write('src/arm/a.bag', 'two')
        found = tree.changes('src/arm/a.bag')
    assert found == ['changed src/arm/a.bag']


def test_file_written_since_the_launch_began_is_a_change(tree: Tree) -> None:
    old = tree.write('src/arm/old.cpp')
    past = time.time_ns() - 10**12
    assert tree.watch(since=past) == ['changed src/arm/old.cpp']
    # it is known now
    assert tree.watch(since=past) == []
    file = tree.write('file.yaml')
    assert tree.watch(file, since=past) == ['changed file.yaml']
    # what is not watched any more has not been deleted
    assert tree.watch(since=past) == []
    old.unlink()
    assert tree.watch(since=past) == ['deleted src/arm/old.cpp']


def test_lock_of_git_is_found(tree: Tree) -> None:
    git = tree.root / '.git'
    git.mkdir()
    tree.watch()
    assert tree.files.git_locks == (str(git / 'index.lock'),)
    # a work tree of another repository
    tree.write('src/.git', 'gitdir: ../other/worktrees/src\n')
    tree.watch()
    (lock,) = tree.files.git_locks
    expected = tree.root / 'other/worktrees/src/index.lock'
    assert os.path.normpath(lock) == str(expected)


NAMES = strategies.sampled_from(['a.cpp', 'b.py', 'in/a.cpp', 'in/er/c.h'])
EDITS = strategies.lists(
    strategies.tuples(
        strategies.sampled_from(['write', 'delete', 'move', 'mode', 'rmdir']),
        NAMES,
        NAMES,
        strategies.sampled_from(['', 'one', 'two']),
    ),
    max_size=4,
)


def edit(folder: Path, what: str, name: str, other: str, text: str) -> None:
    """Do something to files, as far as they are there."""
    file, target = folder / name, folder / other
    if what == 'write':
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    elif what == 'rmdir':
        shutil.rmtree(file.parent if file.parent != folder else folder / 'in')
    elif what == 'delete':
        file.unlink()
    elif what == 'move':
        file.rename(target)
    else:
        file.chmod(0o755)


def now(folder: Path) -> dict[str, tuple[str, int]]:
    return {
        str(path): (path.read_text(), path.stat().st_mode)
        for path in folder.rglob('*')
        if path.is_file()
    }


@RANDOM
@given(strategies.lists(EDITS, max_size=6))
def test_changes_are_those_that_happened(
    rounds: list[list[tuple[str, str, str, str]]],
) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        files = WatchedFiles()
        files.watch([str(folder)], [], 0)
        known = now(folder)
        for edits in rounds:
            paths: set[str] = set()
            for what, file, other, text in edits:
                try:
                    edit(folder, what, file, other, text)
                except OSError:
                    continue
                for path in (folder / file, folder / other):
                    # as the kernel tells it of all folders that are watched
                    inside = (path, *path.parents)
                    paths.update(map(str, inside[: inside.index(folder)]))
                if what == 'rmdir':
                    paths.add(str(folder / 'in'))
            if any(map(files.needs_scan, paths)):
                found = files.scan()
            else:
                found = files.changes(paths)
            is_now = now(folder)
            paths = known.keys() | is_now.keys()
            differing = {p for p in paths if known.get(p) != is_now.get(p)}
            assert {c.path for c in found} == differing
            assert len(found) == len(differing)
            for change in found:
                kinds = {
                    'new': change.path not in known,
                    'deleted': change.path not in is_now,
                }
                other_kinds = ('changed', 'mode')
                assert kinds.get(change.kind, change.kind in other_kinds)
            known = is_now
