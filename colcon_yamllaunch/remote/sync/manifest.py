# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The manifest of a workspace: what launches have sent there.

Only a file that is in the manifest, and is as it was sent, is replaced or
deleted. What others made, or edited since, is neither. rsync does the rest.
This module runs on the machine.

A *content* is a text that differs where two files do: `f DIGEST`, `xf DIGEST`
for one that its owner may execute, `l TARGET` for a symbolic link, `d` for a
folder, and an empty text where there is nothing. Names that are not UTF-8 are
as Python has them (`os.fsdecode`), which JSON keeps.
"""

from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
import os
from pathlib import Path
import shutil
import stat
import time
from typing import Any, NamedTuple

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.files import read_json, save_json
from colcon_yamllaunch.common.fingerprint import content_digest, Fingerprint

Say = Callable[[str], None]

#: The name of the file, below the workspace.
MANIFEST_NAME = '.colcon_launch.synced.json'
#: Raise it when the format of the file changes.
_VERSION = 4
#: How long a file system's clock takes at most to move on (seconds); see
#: `fingerprint.TICK`.
_SETTLED = 0.03
#: How many of the files that are in the way an error names.
_SHOWN = 5
#: The content of a folder.
FOLDER = 'd'
#: The beginning of the content of a link; its target follows.
LINK = 'l '
#: Read files of any size (bytes).
_ANY_SIZE = 2**62
_INSTALL_COMMANDS = (
    *('apt install', 'dnf install', 'zypper install'),
    *('pacman -S', 'apk add'),
)


class SentFile(NamedTuple):
    """
    A file, link or folder as it is after a launch has sent it.

    :param sent: Its content at the launcher
    :param content: Its content here, which a build may have changed since;
      while it is being sent, the one before
    :param status: Its size and times here; empty if they prove nothing, and
      None while it is being sent
    :param was_here: Whether it was here before any launch sent it, so that it
      is never deleted
    """

    sent: str
    content: str
    status: list[int] | None
    was_here: bool = False


@dataclass
class Folder:
    """
    What was sent to one folder of the workspace.

    :param origin: The workspace that it comes from
    :param state: The state of its files at the launcher
    :param files: What is here, by paths relative to it
    """

    origin: str = ''
    state: str = ''
    files: dict[str, SentFile] = field(default_factory=dict)


class Manifest:
    """
    The manifest of one workspace.

    :param root: The workspace
    """

    def __init__(self, root: str) -> None:
        self._root = root
        self._path = Path(root, MANIFEST_NAME)
        self.folders: dict[str, Folder] = {}
        found = read_json(self._path)
        with suppress(KeyError, TypeError, AttributeError):
            # texts that were sent name the workspace
            if (found['version'], found['root']) == (_VERSION, root):
                self.folders = {
                    place: Folder(
                        folder['origin'],
                        folder['state'],
                        {p: SentFile(*s) for p, s in folder['files'].items()},
                    )
                    for place, folder in found['folders'].items()
                }

    def write(self) -> None:
        """
        Write it.

        :raises UserError: when it cannot be written
        """
        values = {
            'version': _VERSION,
            'root': self._root,
            'folders': {p: vars(f) for p, f in self.folders.items()},
        }
        try:
            save_json(self._path, values)
        except OSError as e:
            raise _not_written(e, str(self._path)) from e

    def path(self, place: str, inner: str) -> str:
        """Return the path of a file in a folder."""
        return '/'.join(filter(None, (self._root, place, inner)))

    def changed_places(
        self, origin: str, states: Mapping[str, str]
    ) -> list[str]:
        """
        Return the places whose folders differ from those of the launcher.

        :param states: The states of the folders at the launcher, by place
        """
        changed = []
        for place, state in states.items():
            folder = self.folders.get(place, Folder())
            if (
                (folder.origin, folder.state) != (origin, state)
                or not state
                or not all(
                    _is_unchanged(self.path(place, inner), sent)
                    for inner, sent in folder.files.items()
                )
            ):
                changed.append(place)
        return changed


def prepare(arguments: Mapping[str, Any], say: Say) -> dict[str, Any]:
    """
    Compare folders with the launcher's; delete what is gone there.

    The arguments are `root`, the workspace; `origin`, the workspace that the
    files come from; `contents` by place and path; `states` by place;
    and `places`, those of all packages at the origin, or None: what it sent
    elsewhere is deleted.

    Return how many files were `deleted`, and the paths of the files to `send`
    by rsync, by place; then, or if there are only places,
    :func:`finish` is due.

    :raises UserError: when files of others are in the way; then nothing was
      done
    """
    root, origin = str(arguments['root']), str(arguments['origin'])
    places, states = arguments['places'], arguments['states']
    manifest = Manifest(root)
    wanted: dict[str, dict[str, str]] = arguments['contents']
    if places is not None:
        for place, folder in manifest.folders.items():
            if folder.origin == origin and place not in places:
                wanted.setdefault(place, {})
    changes = {p: _Changes(manifest, p, c) for p, c in wanted.items()}
    in_the_way = [p for c in changes.values() for p in c.in_the_way]
    if in_the_way:
        raise UserError(_in_the_way(root, in_the_way))
    coming = {p: found for p, c in changes.items() if (found := c.coming())}
    files = {
        place: [inner for inner, content in found.items() if is_file(content)]
        for place, found in coming.items()
    }
    if any(files.values()):
        check_rsync('there')
    deleted = 0
    try:
        for place, change in changes.items():
            for note in change.notes:
                say(note)
            deleted += change.apply(origin, states.get(place, ''))
        # a transfer that is interrupted now goes on from there
        manifest.write()
        for place, found in coming.items():
            for inner, content in found.items():
                _create(manifest.path(place, inner), content)
    except OSError as e:
        raise _not_written(e, str(e.filename)) from e
    return {'send': files, 'deleted': deleted}


def finish(arguments: Mapping[str, Any], say: Say) -> dict[str, Any]:  # noqa: ARG001
    """
    Record the files that rsync has sent.

    The arguments are `root` and `places`, those of the folders. Return the
    paths that `differ`, as files were changed at the launcher meanwhile.
    """
    manifest = Manifest(str(arguments['root']))
    differ = []
    # so that the times of a file show that it was changed after this
    time.sleep(_SETTLED)
    for place in arguments['places']:
        folder = manifest.folders[place]
        for inner, sent in folder.files.items():
            if sent.status is None:
                path = manifest.path(place, inner)
                folder.files[inner] = now = _updated(sent, path)
                if not have_same_data(now.content, sent.sent):
                    differ.append(path)
                    folder.state = ''
    manifest.write()
    return {'differ': differ}


def record_build(root: str, begin: float) -> None:
    """
    Record what a build has written into its sources.

    :param begin: When it began (seconds since 1970)
    """
    manifest = Manifest(root)
    is_changed = False
    for place, folder in manifest.folders.items():
        for inner, sent in folder.files.items():
            path = manifest.path(place, inner)
            with suppress(OSError, UserError):
                if (
                    not _is_unchanged(path, sent)
                    and os.path.isfile(path)
                    and os.lstat(path).st_mtime >= begin
                ):
                    folder.files[inner] = _updated(sent, path)
                    is_changed = True
    if is_changed:
        manifest.write()


class _Changes:
    """
    The differences between a folder and the launcher's.

    :param wanted: The contents at the launcher, by paths
    """

    def __init__(
        self, manifest: Manifest, place: str, wanted: Mapping[str, str]
    ) -> None:
        self._manifest = manifest
        self._place = place
        self._wanted = wanted
        self._before = manifest.folders.get(place, Folder()).files
        self._after: dict[str, SentFile] = {}
        self._gone: dict[str, str] = {}
        self._other_modes: list[str] = []
        #: Lines for the user.
        self.notes: list[str] = []
        #: Paths below the workspace that hold something of others.
        self.in_the_way: list[str] = []
        for inner, sent in self._before.items():
            if inner not in wanted:
                self._compare_gone(inner, sent)
        for inner, content in wanted.items():
            self._compare(inner, content)

    def coming(self) -> dict[str, str]:
        """Return the contents that are to replace others, by paths."""
        after = self._after.items()
        return {p: sent.sent for p, sent in after if sent.status is None}

    def apply(self, origin: str, state: str) -> int:
        """
        Delete what is gone at the launcher, and record the rest.

        :param origin: The workspace that the files come from
        :param state: The state of the folder there
        :return: How many files were deleted
        """
        deleted = self._delete()
        if not self._wanted:
            self._manifest.folders.pop(self._place, None)
            return deleted
        # rsync would replace a file by a folder
        os.makedirs(os.path.dirname(self._path('')), exist_ok=True)
        for inner in self._other_modes:
            path, sent = self._path(inner), self._after[inner]
            _set_executable(path, sent.sent.startswith('x'))
            self._after[inner] = _updated(sent, path)
        self._manifest.folders[self._place] = Folder(
            origin, state, self._after
        )
        return deleted

    def _delete(self) -> int:
        """Delete what is gone; return how many files that were."""
        count = 0
        # first what is inside of a folder
        for inner in sorted(self._gone, reverse=True):
            path = self._path(inner)
            if self._gone[inner] == FOLDER:
                with suppress(OSError):
                    # others may have made something in it
                    os.rmdir(path)
            else:
                os.unlink(path)
                count += 1
        if not self._wanted:
            with suppress(OSError):
                os.removedirs(os.path.dirname(self._path('')))
        return count

    def _compare_gone(self, inner: str, sent: SentFile) -> None:
        found = content_at(self._path(inner))
        if not found or (found == FOLDER and sent.was_here):
            return
        if sent.was_here:
            self._note(inner, 'was not brought by a launch')
        elif found in (FOLDER, sent.sent, sent.content):
            self._gone[inner] = found
        else:
            self._note(inner, 'was changed there')

    def _note(self, inner: str, reason: str) -> None:
        path = shown(f'{self._place}/{inner}'.strip('/'))
        self.notes.append(
            f'{path} is left there, as it {reason}; here it is gone'
        )

    def _compare(self, inner: str, content: str) -> None:
        path, sent = self._path(inner), self._before.get(inner)
        if (
            sent is not None
            and sent.sent == content
            and _is_unchanged(path, sent)
        ):
            self._after[inner] = sent
            return
        found, status = _look(path, content)
        is_ours = sent is not None and found in (sent.sent, sent.content)
        if have_same_data(found, content):
            was_here = sent is None or sent.was_here
            self._after[inner] = SentFile(content, found, status, was_here)
            if found != content:
                self._other_modes.append(inner)
        elif (
            self._has_others(inner)
            if found == FOLDER
            else (found and not is_ours)
        ):
            self.in_the_way.append(f'{self._place}/{inner}'.strip('/'))
        else:
            self._after[inner] = SentFile(content, found, None)

    def _has_others(self, inner: str) -> bool:
        """Return whether there is something of others in a folder."""
        top = self._path('')
        return any(
            os.path.relpath(os.path.join(path, name), top) not in self._gone
            for path, folders, files in os.walk(self._path(inner))
            for name in (*folders, *files)
        )

    def _path(self, inner: str) -> str:
        return self._manifest.path(self._place, inner)


def _is_unchanged(path: str, sent: SentFile) -> bool:
    """Return whether the file at `path` is as it was sent."""
    if sent.status is None:
        return False
    if sent.status and _status(path) == sent.status:
        return True
    try:
        if sent.content == FOLDER:
            return os.path.isdir(path)
        return content_at(path) == sent.content
    except UserError:
        return False


def _updated(sent: SentFile, path: str) -> SentFile:
    """Return the record of a file with its content and status now."""
    content, status = _look(path, sent.sent)
    return sent._replace(content=content, status=status)


def _look(path: str, wanted: str) -> tuple[str, list[int]]:
    """Return the content and the status of a path that should be `wanted`."""
    # an edit between the two is noticed later
    status = _status(path)
    if wanted == FOLDER and os.path.isdir(path):
        # also a link to one
        return FOLDER, status
    return content_at(path), status


def _status(path: str) -> list[int]:
    """Return size and times; empty if a change of the file may keep them."""
    try:
        now = Fingerprint.of(os.lstat(path))
    except OSError:
        return []
    if now.size < 0 or not now.is_settled:
        return []
    return [now.size, now.mtime, now.ctime, now.inode]


def _create(path: str, content: str) -> None:
    """Create a link or folder; rsync sends only files."""
    is_folder = content == FOLDER
    if is_file(content) or (is_folder and os.path.isdir(path)):
        return
    if os.path.isdir(path) and not os.path.islink(path):
        os.rmdir(path)
    elif os.path.lexists(path):
        os.unlink(path)
    folder = path if is_folder else os.path.dirname(path)
    os.makedirs(folder, exist_ok=True)
    if not is_folder:
        os.symlink(content.removeprefix(LINK), path)


def _set_executable(path: str, is_executable: bool) -> None:
    """Make a file executable for its readers, or for nobody."""
    mode = os.stat(path).st_mode & 0o777
    readers = (mode & 0o444) >> 2
    os.chmod(path, mode | readers if is_executable else mode & ~0o111)


def _in_the_way(root: str, paths: Collection[str]) -> str:
    listed = sorted(paths)
    lines = ''.join(f'\n  {shown(path)}' for path in listed[:_SHOWN])
    more = len(listed) - _SHOWN
    if more > 0:
        lines += f'\n  and {more} more'
    return (
        f'in {root} there is something else that no launch has brought, or '
        f'that was changed there since:{lines}\nNothing was changed. Save '
        'there what is to be kept and delete these files, or leave the code '
        'there to somebody else by `sync: none`'
    )


def _not_written(error: OSError, path: str) -> UserError:
    return UserError(
        f'cannot write {shown(path)}: {error.strerror}. Make the workspace '
        'there writable, or make room in it'
    )


def content_at(path: str, *, follows_links: bool = False) -> str:
    """
    Return the content of the file at `path`.

    :raises UserError: when it cannot be read
    """
    try:
        status = os.stat(path, follow_symlinks=follows_links)
    except (FileNotFoundError, NotADirectoryError):
        return ''
    except OSError as e:
        raise unreadable(path, e.strerror) from e
    if stat.S_ISDIR(status.st_mode):
        return FOLDER
    if stat.S_ISLNK(status.st_mode):
        return LINK + os.readlink(path)
    if not stat.S_ISREG(status.st_mode):
        return 'other'
    found = content_digest(Path(path), status.st_size, _ANY_SIZE)
    if not found:
        raise unreadable(path, os.strerror(13))
    return f'{"x" if status.st_mode & stat.S_IXUSR else ""}f {found}'


def is_file(content: str) -> bool:
    """Return whether a content is that of a file."""
    return content.removeprefix('x').startswith('f ')


def have_same_data(one: str, other: str) -> bool:
    """Return whether two contents differ at most in who may execute them."""
    return one.removeprefix('x') == other.removeprefix('x')


def shown(path: str) -> str:
    """Return a path for a message, in one line."""
    text = os.fsencode(path).decode(errors='replace')
    return ''.join(c if c.isprintable() else '?' for c in text)


def unreadable(path: str, reason: str | None) -> UserError:
    """Return the error about a file that cannot be read."""
    return UserError(
        f'{shown(path)} cannot be read: {reason}. Make it readable, or take '
        'it out of the package'
    )


def check_rsync(where: str) -> None:
    """
    Check that rsync is installed.

    :param where: Names this machine: `here` or `there`
    :raises UserError: when it is not; the text names the command to install it
    """
    if shutil.which('rsync') is not None:
        return
    command = next(
        (c for c in _INSTALL_COMMANDS if shutil.which(c.partition(' ')[0])),
        _INSTALL_COMMANDS[0],
    )
    raise UserError(
        f'rsync is not installed {where}, which sends the code: install it '
        f"{where} by 'sudo {command} rsync'"
    )
