# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The manifest of a workspace: what launches have sent there.

Only what is in the manifest, and is as it was sent, is replaced or deleted.
What others made, or edited since, is neither. rsync does the rest. This runs
on the machine.
"""

from collections.abc import Callable
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from dataclasses import field
import json
import os
from pathlib import Path
import time
from typing import Any
from typing import NamedTuple

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.common.json_files import read_json
from colcon_yamllaunch.remote.sync.contents import check_rsync
from colcon_yamllaunch.remote.sync.contents import content_at
from colcon_yamllaunch.remote.sync.contents import FOLDER
from colcon_yamllaunch.remote.sync.contents import have_same_data
from colcon_yamllaunch.remote.sync.contents import packed
from colcon_yamllaunch.remote.sync.contents import shown
from colcon_yamllaunch.remote.sync.contents import tree_state
from colcon_yamllaunch.remote.sync.contents import unpacked
from colcon_yamllaunch.remote.sync.contents import UNSETTLED
from colcon_yamllaunch.workspace.packages.trust import Trust

Say = Callable[[str], None]

#: The name of the file, below the workspace.
MANIFEST_NAME = '.colcon_launch.synced.json'
#: To be raised when what is in it changes.
_VERSION = 2
#: How long a file system's clock takes at most to move on (seconds); see
#: `fingerprint.TICK`.
_SETTLED = 0.03


class Sent(NamedTuple):
    """
    A file, link or folder as it is after a launch has sent it.

    :param token: Its token at the launcher
    :param content: Its content here, which a build may have changed since
    :param status: Its size and times here; empty if they prove nothing
    :param was_here: Whether it was here before any launch sent it, so that it
      is never deleted
    """

    token: str
    content: str
    status: list[int]
    was_here: bool = False


@dataclass
class Folder:
    """
    What was sent to one folder of the workspace.

    :param origin: The workspace that it comes from
    :param state: The state of its tokens, empty while it is being sent
    :param files: What is here, by paths relative to it
    :param coming: Token and content of what a transfer brings
    """

    origin: str
    state: str = ''
    files: dict[str, Sent] = field(default_factory=dict)
    coming: dict[str, list[str]] = field(default_factory=dict)

    def contents_sent(self, inner: str) -> list[str]:
        """Return the contents that launches have sent to a path."""
        found = [self.files[inner].content] if inner in self.files else []
        return found + self.coming.get(inner, [])[1:]


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
                        {p: Sent(*s) for p, s in folder['files'].items()},
                        dict(folder['coming']),
                    )
                    for place, folder in found['folders'].items()
                }

    def write(self) -> None:
        """
        Write it.

        :raises UserError: when it cannot be written
        """
        temporary = self._path.with_name(f'{MANIFEST_NAME}.{os.getpid()}')
        values = {
            'version': _VERSION,
            'root': self._root,
            'folders': {p: vars(f) for p, f in self.folders.items()},
        }
        try:
            try:
                temporary.write_bytes(json.dumps(values).encode())
                temporary.replace(self._path)
            finally:
                temporary.unlink(missing_ok=True)
        except OSError as e:
            raise _not_written(e, str(self._path)) from e

    def path(self, place: str, inner: str) -> str:
        """Return the path of what is in a folder."""
        return '/'.join(filter(None, (self._root, place, inner)))

    def is_as_sent(self, place: str, origin: str, state: str) -> bool:
        """Return whether a folder has what the launcher has."""
        folder = self.folders.get(place)
        return (
            folder is not None
            and folder.origin == origin
            and folder.state == state != ''
            and all(
                is_unchanged(self.path(place, inner), sent)
                for inner, sent in folder.files.items()
            )
        )


def changed_places(
    root: str, origin: str, states: Mapping[str, str]
) -> list[str]:
    """
    Return the places whose folders are not as the launcher has them.

    :param states: The states of the folders at the launcher, by place
    """
    manifest = Manifest(root)
    return [
        place
        for place, state in states.items()
        if not manifest.is_as_sent(place, origin, state)
    ]


def prepare(arguments: Mapping[str, Any], say: Say) -> dict[str, Any]:
    """
    Find out what rsync is to send, and delete what is gone at the launcher.

    The arguments are `root`, the workspace; `origin`, what it comes from;
    `tokens` by place and path, packed; `contents` of files likewise, as far
    as they were asked for; and `places`, those of all packages at the origin,
    or None: what it sent elsewhere is deleted.

    Return, packed, by place: the paths whose contents are `needed` to go on,
    with which nothing was done yet; else the paths that are `in_the_way`, with
    which nothing was done either; else those that are to be sent as others
    have no such `data`, or only to have another `mode`; and how many were
    `deleted`.
    """
    root, origin = str(arguments['root']), str(arguments['origin'])
    manifest = Manifest(root)
    trees: dict[str, dict[str, str]] = unpacked(arguments['tokens'])
    contents = unpacked(arguments['contents'])
    if arguments['places'] is not None:
        for place, folder in manifest.folders.items():
            if folder.origin == origin and place not in arguments['places']:
                trees.setdefault(place, {})
    changes = {
        place: _Changes(manifest, place, origin, tokens, contents.get(place))
        for place, tokens in trees.items()
    }

    def by_place(name: str) -> dict[str, list[str]]:
        found = {p: list(getattr(c, name)) for p, c in changes.items()}
        return {place: paths for place, paths in found.items() if paths}

    for name in ('needed', 'in_the_way'):
        if found := by_place(name):
            return {name: packed(found)}
    for change in changes.values():
        for note in change.notes:
            say(note)
        if change.data or change.mode:
            check_rsync('there')
        change.record()
    # before anything is done, as who is interrupted goes on from there
    manifest.write()
    try:
        deleted = sum(change.delete() for change in changes.values())
    except OSError as e:
        raise _not_written(e, str(e.filename)) from e
    for place in by_place('tokens').keys() - by_place('coming').keys():
        folder = manifest.folders[place]
        folder.state = tree_state(trees[place])
    manifest.write()
    return {
        'data': packed(by_place('data')),
        'mode': packed(by_place('mode')),
        'deleted': deleted,
    }


def finish(arguments: Mapping[str, Any], say: Say) -> dict[str, Any]:  # noqa: ARG001
    """
    Record what has come.

    The arguments are `root` and `places`, those of the folders. Return the
    paths that `differ`, packed, as files were changed at the launcher
    meanwhile.
    """
    manifest = Manifest(str(arguments['root']))
    differ = []
    # so that a change of what is here now will show in its times
    time.sleep(_SETTLED)
    for place in arguments['places']:
        folder = manifest.folders[place]
        for inner, (token, content) in list(folder.coming.items()):
            path = manifest.path(place, inner)
            found, status = _look(path, token)
            if not have_same_data(found, content):
                differ.append(path)
            before = folder.files.get(inner)
            was_here = before is not None and before.was_here
            folder.files[inner] = Sent(token, found, status, was_here)
        folder.coming = {}
        if not differ:
            folder.state = tree_state(
                {inner: sent.token for inner, sent in folder.files.items()}
            )
    manifest.write()
    return {'differ': packed(differ)}


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
                    not is_unchanged(path, sent)
                    and os.path.isfile(path)
                    and os.lstat(path).st_mtime >= begin
                ):
                    found, status = _look(path, sent.token)
                    folder.files[inner] = sent._replace(
                        content=found, status=status
                    )
                    is_changed = True
    if is_changed:
        manifest.write()


class _Changes:
    """
    What differs between a folder and the launcher's.

    :param tokens: What the launcher has
    :param contents: The contents of these files, as far as they are known
    """

    def __init__(
        self,
        manifest: Manifest,
        place: str,
        origin: str,
        tokens: Mapping[str, str],
        contents: Mapping[str, str] | None,
    ) -> None:
        self._manifest = manifest
        self._place = place
        self._origin = origin
        self._contents = contents or {}
        self._folder = manifest.folders.get(place) or Folder('')
        self._same: dict[str, Sent] = {}
        self._lost: list[str] = []
        self._gone: dict[str, str] = {}
        self.tokens = tokens
        self.needed: list[str] = []
        self.in_the_way: list[str] = []
        self.notes: list[str] = []
        #: Token and content of what is to be sent, by paths.
        self.data: dict[str, list[str]] = {}
        self.mode: dict[str, list[str]] = {}
        for inner in {**self._folder.files, **self._folder.coming}:
            if inner not in tokens:
                self._compare_gone(inner)
        for inner, token in tokens.items():
            self._compare(inner, token)

    @property
    def coming(self) -> dict[str, list[str]]:
        """What is sent."""
        return self.data | self.mode

    def record(self) -> None:
        """Record what is about to be done."""
        if not self.tokens:
            self._manifest.folders.pop(self._place, None)
            return
        folder = self._folder
        for inner in (*self._gone, *self._lost):
            folder.files.pop(inner, None)
        folder.files |= self._same
        for inner in self.data.keys() & folder.files.keys():
            folder.files[inner] = folder.files[inner]._replace(was_here=False)
        folder.origin, folder.state = self._origin, ''
        folder.coming = self.coming
        self._manifest.folders[self._place] = folder

    def delete(self) -> int:
        """Delete what is gone, and return how many files these were."""
        count = 0
        # what is inside of a folder before that
        for inner in sorted(self._gone, reverse=True):
            path = self._path(inner)
            if self._gone[inner] == FOLDER:
                with suppress(OSError):
                    # what others have made in it is left
                    os.rmdir(path)
            else:
                os.unlink(path)
                count += 1
        parent = os.path.dirname(self._path(''))
        if self.tokens:
            # rsync would replace a file by it
            os.makedirs(parent, exist_ok=True)
        else:
            with suppress(OSError):
                os.removedirs(parent)
        return count

    def _compare_gone(self, inner: str) -> None:
        path = self._path(inner)
        found = content_at(path)
        sent = self._folder.files.get(inner)
        if not found or (found == FOLDER and sent and sent.was_here):
            self._lost.append(inner)
        elif sent is not None and sent.was_here:
            self._leave(inner, 'was not brought by a launch')
        elif found == FOLDER or found in self._folder.contents_sent(inner):
            self._gone[inner] = found
        else:
            self._leave(inner, 'was changed there')

    def _leave(self, inner: str, reason: str) -> None:
        self._lost.append(inner)
        path = shown(f'{self._place}/{inner}'.strip('/'))
        self.notes.append(
            f'{path} is left there, as it {reason}; here it is gone'
        )

    def _compare(self, inner: str, token: str) -> None:
        path, sent = self._path(inner), self._folder.files.get(inner)
        if (
            sent is not None
            and sent.token == token != UNSETTLED
            and self._folder.origin == self._origin
            and is_unchanged(path, sent)
        ):
            return
        content = self._contents.get(inner) if token[0] == 'f' else token
        if content is None:
            self.needed.append(inner)
            return
        found, status = _look(path, token)
        is_ours = found in self._folder.contents_sent(inner)
        if have_same_data(found, content):
            was_here = not is_ours if sent is None else sent.was_here
            self._same[inner] = Sent(token, found, status, was_here)
            if found != content:
                self.mode[inner] = [token, content]
        elif (
            self._has_others(inner)
            if found == FOLDER
            else (found and not is_ours)
        ):
            self.in_the_way.append(inner)
        else:
            self.data[inner] = [token, content]

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


def is_unchanged(path: str, sent: Sent) -> bool:
    """Return whether what is at a path is as it was sent."""
    if sent.status and _status(path) == sent.status:
        return True
    try:
        if sent.content == FOLDER:
            return os.path.isdir(path)
        return content_at(path) == sent.content
    except UserError:
        return False


def _look(path: str, token: str) -> tuple[str, list[int]]:
    """Return the content and the status of a path, for what has a token."""
    # an edit between the two is noticed later
    status = _status(path)
    if token == FOLDER and os.path.isdir(path):
        # also a link to one
        return FOLDER, status
    return content_at(path), status


def _status(path: str) -> list[int]:
    """Return what any change of a file changes; empty if some would not."""
    try:
        now = Fingerprint.of(os.lstat(path))
    except OSError:
        return []
    if now.size < 0 or not now.is_settled:
        return []
    return [now.size, now.mtime, now.ctime, now.inode]


def _not_written(error: OSError, path: str) -> UserError:
    return UserError(
        f'cannot write {shown(path)}: {error.strerror}. Make the workspace '
        'there writable, or make room in it'
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
