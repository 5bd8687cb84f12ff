# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What the files that are watched were like, and what became of them.

A change is another content, so nothing follows from saving a file as it was,
nor from what an editor makes for a moment beside it. But who read a file while
that was being saved may have read something else, so these are noted, too.
"""

from collections.abc import Iterable
from collections.abc import Iterator
import os
from pathlib import Path
import stat
from typing import NamedTuple

from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.common.fingerprint import has_same_times
from colcon_yamllaunch.common.fingerprint import TICK
from colcon_yamllaunch.common.fingerprint import with_content
from colcon_yamllaunch.watch.changes import Change
from colcon_yamllaunch.watch.changes import Kind
from colcon_yamllaunch.workspace.packages.source_files import entries_of
from colcon_yamllaunch.workspace.packages.source_files import is_skipped_file
from colcon_yamllaunch.workspace.packages.source_files import is_skipped_folder

#: What git holds while it writes into the work tree.
_GIT_LOCK = 'index.lock'


class _File(NamedTuple):
    """A file, under the name that it is watched by."""

    real: str
    was: Fingerprint


class _Found(NamedTuple):
    """A file that a look found, under a name that it is watched by."""

    name: str
    real: str
    status: os.stat_result


class WatchedFiles:
    """The files in some folders, and some others."""

    def __init__(self) -> None:
        self._folders: tuple[str, ...] = ()
        self._files: tuple[str, ...] = ()
        self._known: dict[str, _File] = {}
        # the folders that are looked through, behind all links, with the
        # names that they are known by
        self._names: dict[str, set[str]] = {}
        # single files likewise
        self._single: dict[str, set[str]] = {}
        self._roots: set[str] = set()
        #: The folders in which events matter, behind all links.
        self.places: frozenset[str] = frozenset()
        #: What is there while git changes files that are watched.
        self.git_locks: tuple[str, ...] = ()
        self._again: list[Change] = []

    def watch(
        self, folders: Iterable[str], files: Iterable[str], since: int
    ) -> list[Change]:
        """
        Watch other folders and files from now on.

        :param folders: With all that is below them, but for what no build
          takes for a part of the source
        :param since: What was written after that is told as changed, if it was
          not watched before (nanoseconds since the epoch)
        """
        self._folders, self._files = tuple(folders), tuple(files)
        locks = {_git_lock(folder) for folder in self._folders}
        self.git_locks = tuple(sorted(locks - {''}))
        return self._compare(since)

    def look_again(self) -> list[Change]:
        """Look at all files; return what changed."""
        return self._compare(None)

    def changes(self, paths: Iterable[str]) -> list[Change]:
        """
        Return what changed of some files, which events were about.

        :param paths: Behind all links
        """
        found = []
        for name, real in self._watched(paths):
            change = self._changed(name, real, _status(name))
            if change is not None:
                found.append(change)
        return sorted(found, key=lambda change: change.path)

    def take_again(self) -> list[Change]:
        """Return what was found as it was, but written since, just once."""
        again, self._again = self._again, []
        return again

    def needs_look(self, path: str) -> bool:
        """Tell whether an event may be about more than one file."""
        if path in self._names or path in self._roots:
            return True
        # folders beside single files are nobody's, as in /tmp
        is_inside = os.path.dirname(path) in self._names
        return is_inside and os.path.isdir(path)

    def is_torn(self, path: str) -> bool:
        """Tell whether a file looks as if somebody was just writing it."""
        for name, _ in self._watched([path]):
            before = self._known.get(name)
            status = _status(name)
            if before is None:
                return status is not None and status.st_size == 0
            return before.was.size > 0 and (
                status is None or status.st_size == 0
            )
        return False

    def _watched(self, paths: Iterable[str]) -> Iterator[tuple[str, str]]:
        """Iterate over the names that files are watched by."""
        for path in paths:
            folder, _, base = path.rpartition(os.sep)
            if not is_skipped_file(base):
                for name in self._names.get(folder, ()):
                    yield f'{name}{os.sep}{base}', path
            for name in self._single.get(path, ()):
                yield name, path

    def _compare(self, since: int | None) -> list[Change]:
        """
        Look at all files; return what changed.

        :param since: As for :meth:`watch`; None when nothing else is watched
        """
        changes = []
        missing = set(self._known)
        # one after the other, as thousands take memory
        for name, real, status in self._look():
            is_new = name not in self._known
            missing.discard(name)
            change = self._changed(name, real, status)
            if is_new and since is not None:
                # not new, but not looked at before either
                written = max(status.st_mtime_ns, status.st_ctime_ns)
                change = None
                if written > since - TICK:
                    change = Change('changed', name, real)
            if change is not None:
                changes.append(change)
        for name in missing:
            gone = self._known.pop(name)
            if since is None or self._is_wanted(name):
                changes.append(Change('deleted', name, gone.real))
        return sorted(changes, key=lambda change: change.path)

    def _is_wanted(self, name: str) -> bool:
        return name in self._files or any(
            name.startswith(folder + os.sep) for folder in self._folders
        )

    def _changed(
        self, name: str, real: str, status: os.stat_result | None
    ) -> Change | None:
        """Return what became of a file, and take note of it."""
        before = self._known.get(name)
        if status is None or stat.S_ISDIR(status.st_mode):
            if before is None:
                return None
            del self._known[name]
            return Change('deleted', name, before.real)
        now = Fingerprint.of(status)
        then = None if before is None else before.was
        if (
            then is not None
            and before is not None
            and before.real == real
            and has_same_times(then, now)
            and then.executable == now.executable
        ):
            return None
        now = with_content(Path(name), now, then)
        self._known[name] = _File(real, now)
        kind = _kind(then, now)
        if kind is not None:
            return Change(kind, name, real)
        if then is not None and then.ctime != now.ctime:
            self._again.append(Change('again', name, real))
        return None

    def _look(self) -> Iterator[_Found]:
        self._names, self._single = {}, {}
        self._roots = set()
        for folder in self._folders:
            self._roots |= {folder, os.path.realpath(folder)}
            yield from self._below(folder)
        for name in self._files:
            real = os.path.realpath(name)
            self._single.setdefault(real, set()).add(name)
            status = _status(name)
            if status is not None and not stat.S_ISDIR(status.st_mode):
                yield _Found(name, real, status)
        self.places = frozenset(
            place
            for place in (
                *self._names,
                *(os.path.dirname(path) for path in self._single),
                *(os.path.dirname(path) for path in self._roots),
            )
            if os.path.isdir(place) and os.access(place, os.R_OK)
        )

    def _below(self, folder: str) -> Iterator[_Found]:
        """Iterate over the files of a package."""
        pending = [(folder, os.path.realpath(folder))]
        seen: set[tuple[int, int]] = set()
        while pending:
            name, real = pending.pop()
            self._names.setdefault(real, set()).add(name)
            for entry in entries_of(name):
                its_name, its_real = entry.path, f'{real}{os.sep}{entry.name}'
                try:
                    status = entry.stat()
                    if entry.is_symlink():
                        its_real = os.path.realpath(its_name)
                except OSError:
                    status = entry.stat(follow_symlinks=False)
                if stat.S_ISDIR(status.st_mode):
                    place = (status.st_dev, status.st_ino)
                    if place not in seen and not is_skipped_folder(entry):
                        seen.add(place)
                        pending.append((its_name, its_real))
                elif not is_skipped_file(entry.name):
                    if entry.is_symlink():
                        self._single.setdefault(its_real, set()).add(its_name)
                    if its_real == its_name:
                        # one text instead of two
                        its_real = its_name
                    yield _Found(its_name, its_real, status)


def _kind(then: Fingerprint | None, now: Fingerprint) -> Kind | None:
    if then is None:
        return 'new'
    if (then.size, then.digest) != (now.size, now.digest) or (
        # too large to be read, or a link to nothing
        not now.digest and then.ctime != now.ctime
    ):
        return 'changed'
    return 'mode' if then.executable != now.executable else None


def _status(path: str) -> os.stat_result | None:
    try:
        return os.stat(path)
    except OSError:
        try:
            return os.lstat(path)
        except OSError:
            return None


def _git_lock(folder: str) -> str:
    """Return the lock of the repository that a folder is in, or nothing."""
    for parent in (Path(folder), *Path(folder).parents):
        git = parent / '.git'
        if os.path.isdir(git):
            return str(git / _GIT_LOCK)
        if os.path.isfile(git):
            # a work tree or submodule: `gitdir: PATH`
            try:
                target = git.read_text('utf-8').partition(':')[2].strip()
            except (OSError, UnicodeDecodeError):
                return ''
            return str(parent / target / _GIT_LOCK)
    return ''
