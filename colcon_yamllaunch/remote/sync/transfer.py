# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Files sent to a workspace on a machine by rsync, as far as they differ there.

The manifest there tells what differs and what is in the way, see
`manifest.py`. rsync runs through the one connection that there is, see
`rsync_shell.py`. Files get the time at which they arrive: one that is as old
as it is here could be older than what was compiled of it before.
"""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
import json
import os
from pathlib import Path
import signal
import socket
import subprocess
import sys
import tempfile
from typing import Any
from typing import BinaryIO

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.fingerprint import digest
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
)
from colcon_yamllaunch.remote.connection.machine_connection import Say
from colcon_yamllaunch.remote.sync import rsync_shell
from colcon_yamllaunch.remote.sync.contents import check_rsync
from colcon_yamllaunch.remote.sync.contents import content_at
from colcon_yamllaunch.remote.sync.contents import file_content
from colcon_yamllaunch.remote.sync.contents import FOLDER
from colcon_yamllaunch.remote.sync.contents import is_executable
from colcon_yamllaunch.remote.sync.contents import packed
from colcon_yamllaunch.remote.sync.contents import shown
from colcon_yamllaunch.remote.sync.contents import unpacked
from colcon_yamllaunch.remote.sync.listing import FileTree

#: From which size on it is said, as it takes a while (bytes).
_LARGE = 10_000_000
#: How often what is changed while it is sent is sent again.
_ROUNDS = 3
#: How many of the files that are in the way are shown.
_SHOWN = 5
#: How many lines of what rsync says are shown.
_SHOWN_LINES = 4
#: How long the command of rsync may be (bytes).
_COMMAND = 64 * 1024
#: What a full disk is called there.
_FULL = ('No space left on device', 'Disk quota exceeded')

#: Paths relative to their place, by places.
_Paths = Mapping[str, Sequence[str]]


@dataclass
class Transfer:
    """
    Trees that are sent to one workspace there.

    :param root: The workspace there
    :param origin: What tells the workspace here from others
    :param list_trees: Returns what is to be there
    :param places: The folders of all packages here; what was sent to others
      is deleted. None to delete nothing of others
    :param change_texts: Returns which of some files are to have other contents
      there, and these, by their paths here
    """

    connection: MachineConnection
    root: str
    origin: str
    list_trees: Callable[[], Sequence[FileTree]]
    places: Sequence[str] | None
    say: Say
    change_texts: Callable[[Iterable[str]], Mapping[str, bytes]] = lambda _: {}

    def send(self, trees: Sequence[FileTree], changed: Collection[str]) -> int:
        """
        Send trees, and return how many files were sent or deleted.

        :param changed: The places of the trees that are not there
        :raises UserError: when it cannot be done; then nothing is built
        :raises ValueError: when the machine answers what makes no sense, and
          KeyError or TypeError likewise
        """
        check_rsync('here')
        count = 0
        for _ in range(_ROUNDS):
            wanted = {t.place: t for t in trees if t.place in changed}
            done, differ = self._send(wanted)
            count += done
            if not differ:
                return count
            trees = self.list_trees()
            changed = {tree.place for tree in trees}
        raise UserError(
            f'{shown(differ[0])} was changed each time that it was sent: '
            'launch again when that has ended'
        )

    def _send(self, trees: Mapping[str, FileTree]) -> tuple[int, list[str]]:
        texts: dict[str, bytes] = {}
        answer = self._prepare(trees, {})
        if 'needed' in answer:
            contents = self._contents(trees, unpacked(answer['needed']), texts)
            answer = self._prepare(trees, contents)
        if 'in_the_way' in answer:
            raise UserError(self._in_the_way(unpacked(answer['in_the_way'])))
        data: _Paths = unpacked(answer['data'])
        deleted = int(answer['deleted'])
        paths = {
            place: [*data.get(place, ()), *more]
            for place, more in (
                dict.fromkeys(data, ()) | unpacked(answer['mode'])
            ).items()
        }
        if not paths:
            return deleted, []
        sources = [
            source
            for place, inner in _each(data)
            if (source := trees[place].sources.get(inner))
        ]
        self._announce(sources)
        try:
            self._send_paths(trees, paths, texts)
        except UserError:
            gone = [s for s in sources if not os.path.exists(s)]
            if not gone:
                raise
            return deleted, gone
        finished = self.connection.ask(
            'manifest.finish',
            {'root': self.root, 'places': list(paths)},
            self.say,
        )
        return len(sources) + deleted, unpacked(finished['differ'])

    def _prepare(
        self,
        trees: Mapping[str, FileTree],
        contents: Mapping[str, Mapping[str, str]],
    ) -> dict[str, Any]:
        tokens = {place: tree.tokens for place, tree in trees.items()}
        arguments = {
            'root': self.root,
            'origin': self.origin,
            'tokens': packed(tokens),
            'contents': packed(contents),
            'places': self.places,
        }
        return self.connection.ask('manifest.prepare', arguments, self.say)

    def _contents(
        self,
        trees: Mapping[str, FileTree],
        needed: _Paths,
        texts: dict[str, bytes],
    ) -> dict[str, dict[str, str]]:
        """Return the contents of files, and add those of changed texts."""
        texts |= self.change_texts(
            [trees[place].sources[inner] for place, inner in _each(needed)]
        )
        contents: dict[str, dict[str, str]] = {place: {} for place in needed}
        for place, inner in _each(needed):
            source = trees[place].sources[inner]
            content = content_at(source, follows_links=True)
            if not content:
                trees[place].drop(inner)
                continue
            if source in texts:
                content = file_content(
                    digest(texts[source]),
                    is_executable=content.startswith('x'),
                )
            contents[place][inner] = content
        return contents

    def _announce(self, sources: Sequence[str]) -> None:
        count, size = len(sources), 0
        for source in sources:
            with suppress(OSError):
                size += os.stat(source).st_size
        if count:
            files = 'one file' if count == 1 else f'{count} files'
            if size >= _LARGE:
                files += f' ({size / 1e6:,.0f} MB)'
            self.say(f'bringing {files}')

    def _in_the_way(self, found: _Paths) -> str:
        paths = sorted(f'{p}/{inner}'.strip('/') for p, inner in _each(found))
        lines = ''.join(f'\n  {shown(path)}' for path in paths[:_SHOWN])
        more = len(paths) - _SHOWN
        if more > 0:
            lines += f'\n  and {more} more'
        return (
            f'in {self.root} there is something else that no launch has '
            f'brought, or that was changed there since:{lines}\n'
            'Nothing was changed. Save there what is to be kept and delete '
            'these files, or leave the code there to somebody else by '
            '`sync: none`'
        )

    def _send_paths(
        self,
        trees: Mapping[str, FileTree],
        paths: _Paths,
        texts: Mapping[str, bytes],
    ) -> None:
        """
        Send files, links and folders.

        They are laid out in two folders, as they are to be there: links to
        files here, which rsync follows, and links that stay links.
        """
        with tempfile.TemporaryDirectory(prefix='colcon-launch-') as folder:
            for place, inner in _each(paths):
                tree = trees[place]
                token = tree.tokens[inner]
                is_link = token.startswith('l')
                path = Path(folder, 'links' if is_link else 'files')
                path = path / place / inner
                path.parent.mkdir(parents=True, exist_ok=True)
                if token == FOLDER:
                    path.mkdir(exist_ok=True)
                elif is_link:
                    path.symlink_to(token[2:])
                elif (source := tree.sources[inner]) in texts:
                    path.write_bytes(texts[source])
                    if is_executable(os.stat(source)):
                        path.chmod(0o755)
                else:
                    path.symlink_to(source)
            for name, option in (
                ('files', '--copy-links'),
                ('links', '--links'),
            ):
                if os.path.isdir(f'{folder}/{name}'):
                    self._run_rsync(f'{folder}/{name}', option)

    def _run_rsync(self, folder: str, option: str) -> None:
        """
        Send what is in a folder.

        :raises UserError: when it cannot be done
        """
        ours, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        shell = ' '.join(
            f'"{word}"'
            for word in (
                *(sys.executable, '-I', '-S', rsync_shell.__file__),
                str(its.fileno()),
            )
        )
        with ours, tempfile.TemporaryFile() as errors:
            with its:
                process = subprocess.Popen(
                    [
                        # -s: no shell there reads the path
                        *(
                            'rsync',
                            '--rsh',
                            shell,
                            '-s',
                            '--recursive',
                            option,
                        ),
                        *('--executability', '--checksum', '--compress'),
                        # links to folders that others have made there
                        '--keep-dirlinks',
                        # a folder with a colon in its name is no machine
                        *('--', f'{folder}/', f'there:{self.root}/'),
                    ],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=errors,
                    pass_fds=[its.fileno()],
                    # Ctrl-C is for the launcher, which ends it
                    start_new_session=True,
                    # without options of the user's
                    env={
                        name: value
                        for name, value in os.environ.items()
                        if not name.startswith('RSYNC_')
                    },
                )
            try:
                said = self._serve(ours)
                ours.close()
                code = process.wait()
            finally:
                if process.poll() is None:
                    with suppress(ProcessLookupError):
                        os.killpg(process.pid, signal.SIGKILL)
                    process.wait()
            if code:
                raise _failure(code, [*_lines(errors), *said])

    def _serve(self, rsync: socket.socket) -> list[str]:
        """
        Run there what rsync asks for, if it does.

        Return what that says besides.
        """
        message, descriptors, _, _ = socket.recv_fds(rsync, _COMMAND, 2)
        if not message:
            # it has ended
            return []
        code, said = self.connection.run_program(
            json.loads(message), *descriptors
        )
        with suppress(OSError):
            rsync.send(str(code).encode())
        return said


def _each(paths: _Paths) -> Iterable[tuple[str, str]]:
    return ((place, inner) for place in paths for inner in paths[place])


def _lines(file: BinaryIO) -> list[str]:
    file.seek(0)
    text = file.read().decode(errors='replace')
    return [line for line in text.splitlines() if line.strip()]


def _failure(code: int, lines: Sequence[str]) -> UserError:
    text = one_line('; '.join(lines[:_SHOWN_LINES]))
    if any(full in text for full in _FULL):
        return UserError(f'the disk is full there: make room ({text})')
    return UserError(f'rsync failed with exit code {code}: {text}')
