# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Files brought to a workspace, as seen there: which are wanted or in the way.

Runs on the machine. What earlier launches brought is replaced and deleted;
what others made, or changed since, is neither.
"""

from collections.abc import Callable
from collections.abc import Mapping
from contextlib import suppress
import os
from pathlib import Path
import shutil
import stat
import sys
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.remote.sync.sync_record import empty_tree
from colcon_yamllaunch.remote.sync.sync_record import is_untouched
from colcon_yamllaunch.remote.sync.sync_record import let_settle
from colcon_yamllaunch.remote.sync.sync_record import recorded
from colcon_yamllaunch.remote.sync.sync_record import SyncRecord
from colcon_yamllaunch.remote.sync.tree_entries import digest_of
from colcon_yamllaunch.remote.sync.tree_entries import Entries
from colcon_yamllaunch.remote.sync.tree_entries import Entry
from colcon_yamllaunch.remote.sync.tree_entries import file_entry
from colcon_yamllaunch.remote.sync.tree_entries import is_executable
from colcon_yamllaunch.remote.sync.tree_entries import packed
from colcon_yamllaunch.remote.sync.tree_entries import safe_path
from colcon_yamllaunch.remote.sync.tree_entries import shown
from colcon_yamllaunch.remote.sync.tree_entries import tree_digest
from colcon_yamllaunch.remote.sync.tree_entries import unpacked
from colcon_yamllaunch.workspace.packages.trust import Trust

Say = Callable[[str], None]


def changed_trees(root: str, digests: Mapping[str, str]) -> list[str]:
    """
    Return the places whose trees are not there as they are to be.

    :param digests: Those of the trees, by place
    """
    record = SyncRecord(root)
    return [
        place
        for place, digest in digests.items()
        if not _is_as_recorded(root, place, digest, record)
    ]


def prepare(arguments: Mapping[str, Any], say: Say) -> dict[str, Any]:
    """
    Have all ready for the files that are to come.

    The arguments are `root`, the workspace; `origin`, what it comes from;
    `trees`, packed: the entries by place; and `places`, those of all packages
    there are at the origin, or None: what it brought elsewhere is deleted.
    Return the files that are `wanted`, packed, by place; how many were
    `deleted`; what is in the way: the `conflicts`, with which nothing was
    done; and the programs `rsync` and `python` there.
    """
    root = str(arguments['root'])
    origin = str(arguments['origin'])
    record = SyncRecord(root)
    trees: dict[str, Entries] = unpacked(arguments['trees'])
    places = arguments['places']
    for place in () if places is None else record.trees:
        is_ours = record.trees[place]['origin'] == origin
        if is_ours and place not in places:
            trees.setdefault(place, {})
    works = [
        _Tree(root, place, entries, record.trees.get(place))
        for place, entries in trees.items()
    ]
    for work in works:
        work.compare()
    conflicts = [path for work in works for path in work.conflicts]
    if conflicts:
        return {'conflicts': packed(sorted(conflicts)), 'wanted': packed({})}
    for work in works:
        for note in work.notes:
            say(note)
        record.trees[work.place] = {
            **(record.trees.get(work.place) or empty_tree(origin)),
            'origin': origin,
            'digest': '',
            'coming': work.coming,
            'found': sorted(work.found),
        }
    # before anything is done, as who is interrupted goes on where he was
    record.write()
    deleted = 0
    try:
        for work in works:
            deleted += work.delete()
        for work in works:
            work.make()
    except OSError as e:
        raise _failed(e) from e
    for work in works:
        if not work.wanted:
            _conclude(record, work.place, root, trees[work.place])
    record.write()
    wanted = {w.place: sorted(w.wanted) for w in works if w.wanted}
    return {
        'conflicts': packed([]),
        'wanted': packed(wanted),
        'deleted': deleted,
        'rsync': shutil.which('rsync') or '',
        'python': sys.executable,
    }


def finish(arguments: Mapping[str, Any], say: Say) -> dict[str, Any]:  # noqa: ARG001
    """
    Record what has come.

    The arguments are `root` and `trees` as for :func:`prepare`, of those
    trees of which files were wanted. Return the paths that `differ`, packed,
    as the files were changed at the origin meanwhile.
    """
    root = str(arguments['root'])
    trees: dict[str, Entries] = unpacked(arguments['trees'])
    record = SyncRecord(root)
    differ = []
    let_settle()
    for place, entries in trees.items():
        coming = record.trees[place]['coming']
        for inner in coming:
            entry, path = entries[inner], _path(root, place, inner)
            found = ''
            with suppress(OSError, UserError):
                status = os.lstat(path)
                if stat.S_ISREG(status.st_mode):
                    found = digest_of(path, status)
                    _set_mode(path, entry)
            if found != entry[2]:
                differ.append(path)
                # which is brought again, and is nobody else's
                coming[inner] = file_entry(bool(entry[1]), found)
    if not differ:
        for place, entries in trees.items():
            _conclude(record, place, root, entries)
    record.write()
    return {'differ': packed(differ)}


def record_build(root: str, begin: float) -> None:
    """
    Record what a build has written into its sources, which is its own.

    :param begin: When it began (seconds since 1970)
    """
    record = SyncRecord(root)
    is_changed = False
    for place, tree in record.trees.items():
        for inner, entry in tree['files'].items():
            path = _path(root, place, inner)
            known = tree['built'].get(inner, entry)
            if entry[0] != 'f' or _is_there(known, path):
                continue
            with suppress(OSError, UserError):
                status = os.lstat(path)
                if stat.S_ISREG(status.st_mode) and status.st_mtime >= begin:
                    found = file_entry(
                        is_executable(status), digest_of(path, status)
                    )
                    tree['built'][inner] = recorded(found, path)
                    is_changed = True
    if is_changed:
        record.write()


class _Tree:
    """
    One tree: what is to be done for it.

    :param root: The workspace
    :param place: Where it is in the workspace
    :param entries: What is to be in it
    :param before: What is recorded of it
    """

    def __init__(
        self,
        root: str,
        place: str,
        entries: Entries,
        before: Mapping[str, Any] | None,
    ) -> None:
        self.place = safe_path(place)
        self._root = root
        self._entries = entries
        self._before: Entries = {} if before is None else before['files']
        self._coming: Entries = {} if before is None else before['coming']
        self._built: Entries = {} if before is None else before['built']
        #: The files that are to come.
        self.wanted: Entries = {}
        #: Those that are there already, and that nobody has brought.
        self.found: set[str] = set() if before is None else {*before['found']}
        self.conflicts: list[str] = []
        self.notes: list[str] = []
        self._gone: list[str] = []
        self._links: dict[str, str] = {}
        self._folders: list[str] = []
        self._modes: dict[str, Entry] = {}

    @property
    def coming(self) -> Entries:
        """What comes now, or came when that was not concluded."""
        before = self._coming.items()
        return {i: e for i, e in before if i in self._entries} | self.wanted

    def compare(self) -> None:
        """Find out what is to be done, and what is in the way."""
        for inner in sorted({*self._before, *self._coming}):
            if inner not in self._entries:
                self._compare_gone(inner)
        gone = set(self._gone)
        for inner, entry in sorted(self._entries.items()):
            safe_path(inner)
            try:
                status = os.lstat(self._path(inner))
            except NotADirectoryError:
                # that of the folder is in the way, and told
                status = None
            except FileNotFoundError:
                status = None
            if status is None:
                self._want(inner, entry)
            elif entry[0] == 'd':
                self._compare_folder(inner, status)
            elif stat.S_ISDIR(status.st_mode):
                if self._has_others(inner, gone):
                    self._conflict(inner)
                else:
                    self._want(inner, entry)
            elif entry[0] == 'l':
                self._compare_link(inner, entry, status)
            else:
                self._compare_file(inner, entry, status)

    def delete(self) -> int:
        """Delete what is gone, and return how many files these were."""
        # what is inside of a folder before that
        for inner in sorted(self._gone, reverse=True):
            path = self._path(inner)
            with suppress(FileNotFoundError, NotADirectoryError):
                status = os.lstat(path)
                if not stat.S_ISDIR(status.st_mode):
                    os.unlink(path)
                else:
                    with suppress(OSError):
                        # what others have made in it is left
                        os.rmdir(path)
        return sum(self._before.get(i, ['f'])[0] != 'd' for i in self._gone)

    def make(self) -> None:
        """Make folders and links, and the place for files."""
        for inner in self._folders:
            path = self._path(inner)
            with suppress(FileNotFoundError):
                if not os.path.isdir(path):
                    os.unlink(path)
            os.makedirs(path, exist_ok=True)
        for inner, target in self._links.items():
            path = self._path(inner)
            self._clear(path)
            os.symlink(target, path)
        for inner in self.wanted:
            path = self._path(inner)
            if os.path.islink(path) or os.path.isdir(path):
                self._clear(path)
        for inner, entry in self._modes.items():
            _set_mode(self._path(inner), entry)

    def _clear(self, path: str) -> None:
        with suppress(FileNotFoundError):
            if os.path.isdir(path) and not os.path.islink(path):
                _remove_folders(path)
            else:
                os.unlink(path)

    def _compare_gone(self, inner: str) -> None:
        path = self._path(inner)
        try:
            status = os.lstat(path)
        except (FileNotFoundError, NotADirectoryError):
            return
        if inner in self.found:
            if not stat.S_ISDIR(status.st_mode):
                self.notes.append(
                    f'{self._shown(inner)} is left there, as it was not '
                    'brought by a launch; here it is gone'
                )
            self.found.discard(inner)
        elif stat.S_ISDIR(status.st_mode) or self._is_ours(inner, status):
            self._gone.append(inner)
        else:
            self.notes.append(
                f'{self._shown(inner)} is left there, as it was changed '
                'there; here it is gone'
            )

    def _compare_folder(self, inner: str, status: os.stat_result) -> None:
        if stat.S_ISDIR(status.st_mode):
            if inner not in self._before:
                self.found.add(inner)
        elif self._is_ours(inner, status):
            self._folders.append(inner)
        elif os.path.isdir(self._path(inner)):
            # a link to one
            self.found.add(inner)
        else:
            self._conflict(inner)

    def _compare_link(
        self, inner: str, entry: Entry, status: os.stat_result
    ) -> None:
        path = self._path(inner)
        if stat.S_ISLNK(status.st_mode) and os.readlink(path) == entry[1]:
            if inner not in self._before and inner not in self._coming:
                self.found.add(inner)
        elif self._is_ours(inner, status):
            self._want(inner, entry)
        else:
            self._conflict(inner)

    def _compare_file(
        self, inner: str, entry: Entry, status: os.stat_result
    ) -> None:
        path = self._path(inner)
        before = self._before.get(inner)
        if stat.S_ISREG(status.st_mode):
            if before is not None and before[0] == 'f':
                is_same = before[2] == entry[2] and is_untouched(
                    before, path, status
                )
            else:
                is_same = False
            if is_same or digest_of(path, status) == entry[2]:
                if before is None and inner not in self._coming:
                    self.found.add(inner)
                if is_executable(status) != bool(entry[1]):
                    self._modes[inner] = entry
                return
            built = self._built.get(inner)
            if (
                before is not None
                and built is not None
                and before[2] == entry[2]
                and is_untouched(built, path, status)
            ):
                # which the next build would write anew
                return
        if self._is_ours(inner, status):
            self._want(inner, entry)
        else:
            self._conflict(inner)

    def _is_ours(self, inner: str, status: os.stat_result) -> bool:
        """Tell whether a file or link is as it was brought."""
        return any(
            self._is_as(entry, self._path(inner), status)
            for entries in (self._before, self._coming, self._built)
            if (entry := entries.get(inner)) is not None
        )

    def _is_as(self, entry: Entry, path: str, status: os.stat_result) -> bool:
        if entry[0] == 'l':
            is_link = stat.S_ISLNK(status.st_mode)
            return is_link and os.readlink(path) == entry[1]
        is_file = stat.S_ISREG(status.st_mode)
        return (
            entry[0] == 'f' and is_file and is_untouched(entry, path, status)
        )

    def _want(self, inner: str, entry: Entry) -> None:
        self.found.discard(inner)
        if entry[0] == 'd':
            self._folders.append(inner)
        elif entry[0] == 'l':
            self._links[inner] = str(entry[1])
        else:
            self.wanted[inner] = entry

    def _has_others(self, inner: str, gone: set[str]) -> bool:
        """Tell whether there is something of others in a folder."""
        for path, _, files in os.walk(self._path(inner)):
            below = os.path.relpath(path, self._path(inner))
            parent = os.path.normpath(os.path.join(inner, below))
            if parent not in gone | {inner} or any(
                os.path.join(parent, name) not in gone for name in files
            ):
                return True
        return False

    def _conflict(self, inner: str) -> None:
        self.conflicts.append(f'{self.place}/{inner}'.strip('/'))

    def _path(self, inner: str) -> str:
        return _path(self._root, self.place, inner)

    def _shown(self, inner: str) -> str:
        return shown(f'{self.place}/{inner}'.strip('/'))


def _conclude(
    record: SyncRecord, place: str, root: str, entries: Entries
) -> None:
    """Record a tree that is there as it is to be."""
    if not entries:
        del record.trees[place]
        with suppress(OSError):
            os.removedirs(_path(root, place, ''))
        return
    record.trees[place] |= {
        'digest': tree_digest(entries),
        'files': {
            inner: recorded(entry, _path(root, place, inner))
            for inner, entry in entries.items()
        },
        'coming': {},
        'built': {
            inner: entry
            for inner, entry in record.trees[place]['built'].items()
            if _is_there(entry, _path(root, place, inner))
        },
    }


def _is_as_recorded(
    root: str, place: str, digest: str, record: SyncRecord
) -> bool:
    tree = record.trees.get(place)
    if tree is None or tree['digest'] != digest:
        return False
    built = tree['built']
    return all(
        _is_there(built.get(inner, entry), _path(root, place, inner))
        for inner, entry in tree['files'].items()
    )


def _is_there(entry: Entry, path: str) -> bool:
    try:
        if entry[0] == 'd':
            return os.path.isdir(path)
        status = os.lstat(path)
        if entry[0] == 'l':
            return os.readlink(path) == str(entry[1])
        return (
            stat.S_ISREG(status.st_mode)
            and is_executable(status) == bool(entry[1])
            and is_untouched(entry, path, status)
        )
    except (OSError, UserError):
        return False


def _set_mode(path: str, entry: Entry) -> None:
    mode = stat.S_IMODE(os.lstat(path).st_mode)
    # who may read it may run it
    wanted = mode | (mode & 0o444) >> 2 if entry[1] else mode & ~0o111
    if wanted != mode:
        os.chmod(path, wanted)


def _remove_folders(path: str) -> None:
    """Remove a folder in which there are folders only."""
    for inner, _, _ in os.walk(path, topdown=False):
        os.rmdir(inner)


def _path(root: str, place: str, inner: str) -> str:
    parts = (part for part in (root, place, inner) if part)
    return '/'.join(parts)


def _failed(error: OSError) -> UserError:
    path = shown(str(error.filename or ''))
    return UserError(
        f'cannot write {path}: {error.strerror}. Make the workspace there '
        'writable, or make room in it'
    )


def prepared_root(workspace: str, say: Say) -> str:
    """
    Return the root of the workspace there, which is made if necessary.

    :raises UserError: when it cannot be made
    """
    root = Path(os.path.realpath(Path(workspace).expanduser()))
    if root.is_dir():
        Trust(os.environ).check(root)
        return str(root)
    try:
        root.mkdir()
    except FileNotFoundError:
        raise UserError(
            f'there is no folder {root.parent} to make the workspace '
            f'{root.name} in: make it, or name another `workspace:`'
        ) from None
    except OSError as e:
        raise UserError(
            f'cannot make the workspace {root}: {e.strerror}. Make it, or '
            'name another `workspace:`'
        ) from e
    say(f'made the workspace {root}')
    return str(root)
