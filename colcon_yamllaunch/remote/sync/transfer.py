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
        """Return how many files were sent or deleted, and which differ."""
        contents = {place: tree.contents() for place, tree in trees.items()}
        texts = self.change_texts(
            [s for tree in trees.values() for s in tree.sources.values()]
        )
        for place, tree in trees.items():
            for inner, source in tree.sources.items():
                found = contents[place].get(inner)
                if found is not None and source in texts:
                    contents[place][inner] = file_content(
                        digest(texts[source]),
                        is_executable=found.startswith('x'),
                    )
        answer = self.connection.ask(
            'manifest.prepare',
            {
                'root': self.root,
                'origin': self.origin,
                'contents': packed(contents),
                'states': {place: tree.state for place, tree in trees.items()},
                'places': self.places,
            },
            self.say,
        )
        paths: _Paths = unpacked(answer['send'])
        deleted = int(answer['deleted'])
        if not paths:
            return deleted, []
        sources = [
            trees[place].sources[inner]
            for place, inner in _each(paths)
            if inner in trees[place].sources
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
        return len(sources) + deleted, list(finished['differ'])

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
