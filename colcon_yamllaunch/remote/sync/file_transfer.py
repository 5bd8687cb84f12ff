# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Files of a folder here brought to a folder of a machine, by rsync.

rsync runs here and there, through the connection that there is; see
`remote_shell.py`. Where it is not installed, here or there, files come whole,
in the format of `tar`. They get the time at which they arrive: one that is as
old as it is here could be older than what was compiled of it before.
"""

from collections.abc import Callable
from collections.abc import Sequence
from contextlib import closing
from contextlib import suppress
import io
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tarfile
import tempfile
import threading
from typing import Any
from typing import BinaryIO

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.remote.sync import remote_shell
from colcon_yamllaunch.remote.sync.remote_connection import Connection
from colcon_yamllaunch.remote.sync.remote_connection import ProgramThere

#: How much is passed on at once (bytes).
_CHUNK = 128 * 1024
#: How long the command of rsync may be (bytes).
_COMMAND = 64 * 1024
#: How many lines of what rsync says are shown.
_SHOWN_LINES = 4
#: What a full disk is called there.
_FULL = ('No space left on device', 'Disk quota exceeded')
#: That some files vanished while they were sent (rsync(1)).
_VANISHED = 24

#: Unpacks there what comes without rsync: each file is complete or not there.
_UNPACK = """\
import os, shutil, sys, tarfile, tempfile
os.chdir(sys.argv[1])
try:
    with tarfile.open(fileobj=sys.stdin.buffer, mode='r|') as archive:
        for member in archive:
            name = member.name
            handle, path = tempfile.mkstemp(
                prefix='.sync-', dir=os.path.dirname(name) or '.')
            try:
                with os.fdopen(handle, 'wb') as file:
                    shutil.copyfileobj(archive.extractfile(member), file)
                os.chmod(path, member.mode)
                os.replace(path, name)
            except BaseException:
                os.unlink(path)
                raise
except OSError as e:
    print(e.strerror or e, flush=True)
    sys.exit(1)
"""


def transfer(
    connection: Connection,
    folder: str,
    paths: Sequence[str],
    folder_there: str,
    *,
    by_rsync: bool,
    python_there: str,
) -> None:
    """
    Bring files.

    The folders that they are in are there already. A file that vanishes
    meanwhile is left out.

    :param folder: What the paths are relative to, here
    :param folder_there: And there
    :param by_rsync: Whether rsync is installed there
    :param python_there: A Python there
    :raises UserError: when it cannot be done
    """
    if by_rsync and shutil.which('rsync'):
        _by_rsync(connection, folder, paths, folder_there)
    else:
        _by_archive(connection, folder, paths, folder_there, python_there)


def _by_rsync(
    connection: Connection,
    folder: str,
    paths: Sequence[str],
    folder_there: str,
) -> None:
    ours, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    shell = ' '.join(
        f'"{word}"'
        for word in (
            *(sys.executable, '-I', '-S', remote_shell.__file__),
            str(its.fileno()),
        )
    )
    with (
        ours,
        tempfile.TemporaryFile() as names,
        tempfile.TemporaryFile() as errors,
    ):
        names.write(b''.join(os.fsencode(path) + b'\0' for path in paths))
        names.seek(0)
        with its:
            process = subprocess.Popen(
                [
                    *('rsync', '--rsh', shell, '--secluded-args'),
                    *('--from0', '--files-from=-', '--no-implied-dirs'),
                    # what links lead to; what stays one is made there
                    *('--copy-links', '--keep-dirlinks'),
                    # what is listed has other content than there
                    *('--ignore-times', '--compress'),
                    # a folder with a colon in its name is no machine
                    *('--', f'{folder}/', f'there:{folder_there}/'),
                ],
                stdin=names,
                stdout=subprocess.DEVNULL,
                stderr=errors,
                pass_fds=[its.fileno()],
                # Ctrl-C is for the launcher, which ends it
                start_new_session=True,
                env=_environment(),
            )
        try:
            said = _serve(connection, ours)
            ours.close()
            code = process.wait()
        finally:
            if process.poll() is None:
                with suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)
                process.wait()
        if code not in (0, _VANISHED):
            errors.seek(0)
            lines = [*_lines(errors), *said]
            raise _failure('rsync', code, lines)


def _environment() -> dict[str, str]:
    """Return the variables for rsync, without options of the user's."""
    return {
        name: value
        for name, value in os.environ.items()
        if not name.startswith('RSYNC_')
    }


def _serve(connection: Connection, rsync: socket.socket) -> list[str]:
    """
    Run there what rsync asks for, if it does.

    Return what that says besides.
    """
    message, descriptors, _, _ = socket.recv_fds(rsync, _COMMAND, 2)
    if not message:
        # it has ended
        return []
    from_rsync, to_rsync = descriptors
    try:
        command = json.loads(message)
        with closing(connection.stream(command)) as program:
            copier = _Thread(lambda: _copy_in(from_rsync, program))
            try:
                _copy(program.stdout, to_rsync)
                # rsync is to see the end of that
                os.close(to_rsync)
                to_rsync = -1
                rsync.send(str(program.wait()).encode())
            except OSError:
                # it has ended already
                pass
            finally:
                # rsync ends by this, and so does what the copier reads, who
                # must not write to a descriptor that is closed
                rsync.shutdown(socket.SHUT_RDWR)
                copier.end()
            return program.errors.splitlines()
    finally:
        for descriptor in (from_rsync, to_rsync):
            if descriptor != -1:
                os.close(descriptor)


class _Thread:
    """A thread whose error is raised in that which waits for it."""

    def __init__(self, work: Callable[[], None]) -> None:
        self._work = work
        self._error: Exception | None = None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def end(self) -> None:
        self._thread.join()

    def check(self) -> None:
        self.end()
        if self._error is not None:
            raise self._error

    def _run(self) -> None:
        try:
            self._work()
        except Exception as e:  # noqa: BLE001
            self._error = e


def _copy_in(source: int, program: ProgramThere) -> None:
    _copy(source, program.stdin)
    program.end_input()
    # who writes what is not read any more has an answer to read, which says
    # why
    while os.read(source, _CHUNK):
        pass


def _copy(source: int, target: int) -> None:
    """Pass on all that comes; who does not read it has no need of it."""
    with suppress(BrokenPipeError, ConnectionResetError):
        while data := os.read(source, _CHUNK):
            _write(target, data)


def _write(target: int, data: bytes) -> None:
    rest = memoryview(data)
    while rest:
        rest = rest[os.write(target, rest) :]


def _by_archive(
    connection: Connection,
    folder: str,
    paths: Sequence[str],
    folder_there: str,
    python_there: str,
) -> None:
    command = [python_there, '-I', '-S', '-c', _UNPACK, folder_there]
    with closing(connection.stream(command)) as program:
        said = bytearray()
        reader = _Thread(lambda: _read(program.stdout, said))
        with suppress(BrokenPipeError, ConnectionResetError):
            _send(folder, paths, program.stdin)
        program.end_input()
        code = program.wait()
        reader.check()
        text = said.decode(errors='replace') + program.errors
    if code:
        raise _failure('the transfer', code, text.splitlines())


def _send(folder: str, paths: Sequence[str], target: int) -> None:
    with (
        open(target, 'wb', closefd=False) as stream,
        tarfile.open(
            fileobj=stream, mode='w|', format=tarfile.PAX_FORMAT
        ) as archive,
    ):
        for path in paths:
            with suppress(FileNotFoundError):
                _add(archive, os.path.join(folder, path), path)


def _add(archive: tarfile.TarFile, path: str, name: str) -> None:
    try:
        file = open(path, 'rb')  # noqa: SIM115
    except FileNotFoundError:
        return
    except OSError as e:
        raise UserError(f'{path} cannot be read: {e.strerror}') from e
    with file:
        status = os.fstat(file.fileno())
        member = tarfile.TarInfo(name)
        member.size = status.st_size
        member.mode = status.st_mode & 0o777 | 0o200
        archive.addfile(member, _Exactly(file, status.st_size))


class _Exactly(io.RawIOBase):
    """A file that has as many bytes as it had, whatever is done to it."""

    def __init__(self, file: BinaryIO, size: int) -> None:
        super().__init__()
        self._file = file
        self._left = size

    def read(self, size: int = -1, /) -> bytes:
        wanted = self._left if size < 0 else min(size, self._left)
        data = self._file.read(wanted)
        data += bytes(wanted - len(data))
        self._left -= wanted
        return data


def _read(source: int, found: bytearray) -> None:
    while data := os.read(source, _CHUNK):
        found += data


def _lines(file: Any) -> list[str]:
    text = file.read().decode(errors='replace')
    return [line for line in text.splitlines() if line.strip()]


def _failure(what: str, code: int, lines: Sequence[str]) -> UserError:
    told = one_line('; '.join(lines[:_SHOWN_LINES]))
    if any(text in told for text in _FULL):
        return UserError(f'the disk is full there: make room ({told})')
    return UserError(f'{what} failed with exit code {code}: {told}')


def is_installed() -> bool:
    """Tell whether rsync is installed here."""
    return shutil.which('rsync') is not None
