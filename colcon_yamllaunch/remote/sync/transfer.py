# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Files sent to a workspace on a machine by rsync, as far as they differ there.

The manifest there finds the differences, see `manifest.py`. rsync runs through
the existing connection, see `rsync_shell.py`. Files get the time at which they
arrive: with the time that they have here, a source could be older than the
object files that an earlier version was compiled into.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
import json
import os
from pathlib import Path
import shutil
import signal
import socket
import subprocess
import sys
import tempfile

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
    Say,
)
from colcon_yamllaunch.remote.sync import manifest, rsync_shell
from colcon_yamllaunch.remote.sync.listing import FileTree

#: The size from which on it is shown, as sending takes a while (bytes).
_LARGE = 10_000_000
#: How often files are sent again that change meanwhile.
_ROUNDS = 3
#: How many lines of rsync's output an error shows.
_SHOWN_LINES = 4
#: The maximum length of rsync's command (bytes).
_COMMAND = 64 * 1024
#: The messages about a full disk.
_FULL = ('No space left on device', 'Disk quota exceeded')
_RSYNC = (
    *('rsync', '--recursive', '--copy-links', '--executability'),
    *('--checksum', '--compress'),
    # links to folders that others have made there
    '--keep-dirlinks',
    # no shell there reads the path
    '-s',
)

#: Returns the contents of those of some files that differ there, by path.
ChangeTexts = Callable[[Iterable[str]], Mapping[str, bytes]]


@dataclass
class Transfer:
    """
    Trees that are sent to one workspace on a machine.

    :param root: The workspace there
    :param origin: Identifies the workspace here
    :param list_trees: Returns the files that are needed there
    :param places: The folders of all packages here; what was sent to others
      is deleted. None to delete nothing of others
    :param change_texts: Returns those of some files that need other contents
      there, and these, by their paths here
    """

    connection: MachineConnection
    root: str
    origin: str
    list_trees: Callable[[], Sequence[FileTree]]
    places: Sequence[str] | None
    say: Say
    change_texts: ChangeTexts

    def send(self, trees: Sequence[FileTree], changed: Collection[str]) -> int:
        """
        Send trees, and return how many files were sent or deleted.

        :param changed: The places of the trees that are not there
        :raises UserError: when it cannot be done; then nothing is built
        :raises ValueError: when the machine answers what makes no sense, and
          KeyError or TypeError likewise
        """
        manifest.check_rsync('here')
        count = 0
        for _ in range(_ROUNDS):
            wanted = {t.place: t for t in trees if t.place in changed}
            with tempfile.TemporaryDirectory(prefix='colcon-launch-') as made:
                self._adapt(wanted.values(), Path(made, 'texts'))
                done, differ = self._send(wanted, Path(made, 'files'))
            count += done
            if not differ:
                return count
            trees = self.list_trees()
            changed = {tree.place for tree in trees}
        raise UserError(
            f'{manifest.shown(differ[0])} was changed each time that it was '
            'sent: launch again when that has ended'
        )

    def _adapt(self, trees: Collection[FileTree], folder: Path) -> None:
        """Put texts that differ there in the place of the files here."""
        sources = [s for tree in trees for s in tree.sources.values()]
        adapted: dict[str, str] = {}
        folder.mkdir()
        for source, text in self.change_texts(sources).items():
            path = folder / str(len(adapted))
            path.write_bytes(text)
            shutil.copymode(source, path)
            adapted[source] = str(path)
        for tree in trees:
            for inner, source in tree.sources.items():
                tree.sources[inner] = adapted.get(source, source)

    def _send(
        self, trees: Mapping[str, FileTree], folder: Path
    ) -> tuple[int, list[str]]:
        """Return how many files were sent or deleted, and which differ."""
        contents = {place: tree.contents() for place, tree in trees.items()}
        answer = self.connection.ask(
            'manifest.prepare',
            {
                'root': self.root,
                'origin': self.origin,
                'contents': contents,
                'states': {place: tree.state for place, tree in trees.items()},
                'places': self.places,
            },
            self.say,
        )
        paths: Mapping[str, Sequence[str]] = answer['send']
        deleted = int(answer['deleted'])
        sources = {
            f'{place}/{inner}': trees[place].sources[inner]
            for place, inners in paths.items()
            for inner in inners
        }
        if sources:
            self._announce(sources.values())
            try:
                # rsync follows the links
                for there, source in sources.items():
                    path = Path(f'{folder}/{there}')
                    path.parent.mkdir(parents=True, exist_ok=True)
                    path.symlink_to(source)
                self._run_rsync(folder)
            except UserError:
                gone = [s for s in sources.values() if not os.path.exists(s)]
                if not gone:
                    raise
                return deleted, gone
        if not paths:
            return deleted, []
        finished = self.connection.ask(
            'manifest.finish',
            {'root': self.root, 'places': list(paths)},
            self.say,
        )
        return len(sources) + deleted, list(finished['differ'])

    def _announce(self, sources: Collection[str]) -> None:
        count, size = len(sources), 0
        for source in sources:
            with suppress(OSError):
                size += os.stat(source).st_size
        files = 'one file' if count == 1 else f'{count} files'
        if size >= _LARGE:
            files += f' ({size / 1e6:,.0f} MB)'
        self.say(f'bringing {files}')

    def _run_rsync(self, folder: Path) -> None:
        """
        Send the files below a folder.

        :raises UserError: when rsync fails
        """
        ours, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        words = sys.executable, '-I', '-S', rsync_shell.__file__, its.fileno()
        shell = ' '.join(f'"{word}"' for word in words)
        # without the user's options
        variables = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith('RSYNC_')
        }
        # a folder with a colon in its name is no machine
        paths = '--', f'{folder}/', f'there:{self.root}/'
        with ours, tempfile.TemporaryFile() as errors:
            with its:
                process = subprocess.Popen(
                    [*_RSYNC, '--rsh', shell, *paths],
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=errors,
                    pass_fds=[its.fileno()],
                    # Ctrl-C is for the launcher, which ends it
                    start_new_session=True,
                    env=variables,
                )
            try:
                said = self._serve(ours, folder.parent)
                ours.close()
                code = process.wait()
            finally:
                if process.poll() is None:
                    with suppress(ProcessLookupError):
                        os.killpg(process.pid, signal.SIGKILL)
                    process.wait()
            if code:
                errors.seek(0)
                lines = errors.read().decode(errors='replace').splitlines()
                lines = [line for line in lines if line.strip()] + said
                text = one_line('; '.join(lines[:_SHOWN_LINES]))
                raise UserError(
                    f'the disk is full there: make room ({text})'
                    if any(full in text for full in _FULL)
                    else f'rsync failed with exit code {code}: {text}'
                )

    def _serve(self, rsync: socket.socket, folder: Path) -> list[str]:
        """
        Run rsync's command there; return the errors that it prints.

        :param folder: What the shell of rsync removes if this is killed
        """
        message, descriptors, _, _ = socket.recv_fds(rsync, _COMMAND, 2)
        if not message:
            # rsync has ended before
            return []
        with suppress(OSError):
            rsync.send(os.fsencode(folder))
        code, said = self.connection.run_program(
            json.loads(message), *descriptors
        )
        with suppress(OSError):
            rsync.send(str(code).encode())
        return said
