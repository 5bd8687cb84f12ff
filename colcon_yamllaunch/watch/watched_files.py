# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The known state of watched files, and their changes.

Only another content is a change, so saving a file unchanged is none, nor are
the temporary files of editors. A process that read a file while it was being
saved may have read something else, so rewritten files are noted, too.
"""

from collections.abc import Iterable, Iterator
import os
from pathlib import Path
import stat
from typing import Literal, NamedTuple

from colcon_yamllaunch.common.fingerprint import (
    Fingerprint,
    fingerprint,
    has_same_times,
    TICK,
    with_content,
)
from colcon_yamllaunch.workspace.packages.package import (
    is_skipped_file,
    source_folders,
)

#: Exists while git writes the work tree.
_GIT_LOCK = 'index.lock'
#: The size of a folder in its fingerprint.
_FOLDER = -1
#: What happened to a file; `mode` means that it became executable or is not
#: any more, and `again` that it was rewritten with its former content.
Kind = Literal['new', 'changed', 'deleted', 'mode', 'again']


class Change(NamedTuple):
    """
    A changed file.

    A file that is watched under several names has a change for each of them,
    all in one batch.

    :param path: The name under which it is watched: below the folder of a
      package, or as the plan names it
    :param real: Its path behind all symbolic links
    """

    kind: Kind
    path: str
    real: str


class Batch(NamedTuple):
    """
    Changes that are handled together, such as those of a checkout.

    :param seen_ns: When the first of them was noticed, by the monotonic clock
      (nanoseconds)
    """

    changes: tuple[Change, ...]
    seen_ns: int


class _File(NamedTuple):
    """A known file: the target of its links, and its fingerprint."""

    real: str
    fingerprint: Fingerprint


class WatchedFiles:
    """The files in folders, and single files."""

    def __init__(self) -> None:
        self._folders: tuple[str, ...] = ()
        self._files: tuple[str, ...] = ()
        self._known: dict[str, _File] = {}
        # the names of each scanned folder, by its path behind all links
        self._names: dict[str, set[str]] = {}
        # the names of each single file, likewise
        self._single: dict[str, set[str]] = {}
        self._roots: set[str] = set()
        #: The folders whose events matter, behind all links.
        self.watched_folders: frozenset[str] = frozenset()
        #: Files that exist while git changes watched files.
        self.git_locks: tuple[str, ...] = ()
        self._rewritten: list[Change] = []

    def watch(
        self, folders: Iterable[str], files: Iterable[str], since: int
    ) -> list[Change]:
        """
        Watch other folders and files from now on, and return changes.

        :param folders: Folders with everything below them that builds regard
          as source
        :param since: Files that were not watched before and were written after
          this time count as changed (nanoseconds since the epoch)
        """
        self._folders, self._files = tuple(folders), tuple(files)
        locks = {_git_lock(folder) for folder in self._folders}
        self.git_locks = tuple(sorted(locks - {''}))
        return self.scan(since)

    def changes(self, paths: Iterable[str]) -> list[Change]:
        """
        Return the changes of the files that events report.

        :param paths: Their paths behind all links
        """
        found = []
        for name, real in self._watched(paths):
            change = self._changed(name, real, fingerprint(name))
            if change is not None:
                found.append(change)
        return sorted(found, key=lambda change: change.path)

    def pop_rewritten(self) -> list[Change]:
        """Return the files that were rewritten unchanged, each once."""
        rewritten, self._rewritten = self._rewritten, []
        return rewritten

    def needs_scan(self, path: str) -> bool:
        """Return whether an event may concern more than one file."""
        if path in self._names or path in self._roots:
            return True
        # folders beside a single file do not matter, as in /tmp
        is_inside = os.path.dirname(path) in self._names
        return is_inside and os.path.isdir(path)

    def is_partly_written(self, path: str) -> bool:
        """Return whether a file seems to be being saved."""
        for name, _ in self._watched([path]):
            before, now = self._known.get(name), fingerprint(name)
            if before is None:
                return now is not None and now.size == 0
            is_empty = now is None or now.size == 0
            return before.fingerprint.size > 0 and is_empty
        return False

    def _watched(self, paths: Iterable[str]) -> Iterator[tuple[str, str]]:
        """Iterate over the names under which files are watched."""
        for path in paths:
            folder, _, base = path.rpartition(os.sep)
            if not is_skipped_file(base):
                for name in self._names.get(folder, ()):
                    yield f'{name}{os.sep}{base}', path
            for name in self._single.get(path, ()):
                yield name, path

    def scan(self, since: int | None = None) -> list[Change]:
        """
        Scan all files; return what changed.

        :param since: As for :meth:`watch`; None if the same files are watched
        """
        changes = []
        missing = set(self._known)
        # one by one, as thousands of them take memory
        for name, real, now in self._scan():
            is_new = name not in self._known
            missing.discard(name)
            change = self._changed(name, real, now)
            if is_new and since is not None:
                # the file may be old, as it was not watched before
                change = None
                if max(now.mtime, now.ctime) > since - TICK:
                    change = Change('changed', name, real)
            if change is not None:
                changes.append(change)
        for name in missing:
            gone = self._known.pop(name)
            if (
                since is None
                or name in self._files
                or any(name.startswith(f + os.sep) for f in self._folders)
            ):
                changes.append(Change('deleted', name, gone.real))
        return sorted(changes, key=lambda change: change.path)

    def _changed(
        self, name: str, real: str, now: Fingerprint | None
    ) -> Change | None:
        """Return the change of a file, and update its known state."""
        before = self._known.get(name)
        if now is None or now.size == _FOLDER:
            if before is None:
                return None
            del self._known[name]
            return Change('deleted', name, before.real)
        then = None if before is None else before.fingerprint
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
            self._rewritten.append(Change('again', name, real))
        return None

    def _scan(self) -> Iterator[tuple[str, str, Fingerprint]]:
        """Iterate over names, paths behind all links, and fingerprints."""
        self._names, self._single = {}, {}
        self._roots = set()
        for folder in self._folders:
            self._roots |= {folder, os.path.realpath(folder)}
            yield from self._below(folder)
        for name in self._files:
            real = os.path.realpath(name)
            self._single.setdefault(real, set()).add(name)
            now = fingerprint(name)
            if now is not None and now.size != _FOLDER:
                yield name, real, now
        self.watched_folders = frozenset(
            folder
            for folder in (
                *self._names,
                *(os.path.dirname(path) for path in self._single),
                *(os.path.dirname(path) for path in self._roots),
            )
            if os.path.isdir(folder) and os.access(folder, os.R_OK)
        )

    def _below(self, folder: str) -> Iterator[tuple[str, str, Fingerprint]]:
        """Iterate over the files of a package, as :meth:`_scan` does."""
        for path, files in source_folders(folder):
            folder_real = os.path.realpath(path)
            self._names.setdefault(folder_real, set()).add(path)
            for entry, status in files:
                name, real = entry.path, f'{folder_real}{os.sep}{entry.name}'
                if entry.is_symlink():
                    if not stat.S_ISLNK(status.st_mode):
                        # it is not dangling
                        real = os.path.realpath(name)
                    self._single.setdefault(real, set()).add(name)
                # they share one string if they are equal
                real = name if real == name else real
                yield name, real, Fingerprint.of(status)


def _kind(then: Fingerprint | None, now: Fingerprint) -> Kind | None:
    if then is None:
        return 'new'
    if (then.size, then.digest) != (now.size, now.digest) or (
        # a file that is too large to be read, or a broken link
        not now.digest and then.ctime != now.ctime
    ):
        return 'changed'
    return 'mode' if then.executable != now.executable else None


def _git_lock(folder: str) -> str:
    """Return the lock of the repository of a folder, or an empty path."""
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
