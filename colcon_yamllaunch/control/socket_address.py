# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Making the socket of a launch, and finding those of others."""

from collections.abc import Callable
from collections.abc import Mapping
from contextlib import suppress
import os
from pathlib import Path
import socket
import stat
import struct

from colcon_yamllaunch.control.socket_folder import FolderError
from colcon_yamllaunch.control.socket_folder import folders
from colcon_yamllaunch.control.socket_folder import inside
from colcon_yamllaunch.control.socket_folder import open_folder
from colcon_yamllaunch.control.socket_folder import SUFFIX
from colcon_yamllaunch.engine.own_files import Place

# a socket that nobody listens on yet has another name, so that it is not
# taken for a stale one
_UNREADY = '.new'
_CREDENTIALS = struct.Struct('3i')


class Address:
    """
    The socket that the launch listens on, in the first usable folder.

    :raises FolderError: when there is none
    """

    def __init__(self, environment: Mapping[str, str]) -> None:
        #: What was wrong with the folders that come before, one a line.
        self.troubles: list[str] = []
        self._name = f'{os.getpid()}{SUFFIX}'
        for folder in folders(environment):
            try:
                self._open(folder)
            except FolderError as error:
                self.troubles.append(str(error))
            except OSError as error:
                self.troubles.append(f'{folder}: {error.strerror}')
            else:
                #: Its path.
                self.path = folder / self._name
                return
        raise FolderError('; '.join(self.troubles))

    def _open(self, folder: Path) -> None:
        self._folder = open_folder(folder, make=True)
        self.socket = socket.socket(
            socket.AF_UNIX, socket.SOCK_STREAM | socket.SOCK_NONBLOCK
        )
        try:
            self._listen()
        except OSError:
            self.close()
            raise

    @property
    def place(self) -> Place:
        """What is at its path; see :mod:`own_files`."""
        status = os.stat(
            self._name, dir_fd=self._folder, follow_symlinks=False
        )
        path = os.path.abspath(self.path)
        return Place(path, status.st_dev, status.st_ino)

    def close(self) -> None:
        """Listen no more, and remove the socket."""
        if self._folder != -1:
            for name in (self._name, self._name + _UNREADY):
                with suppress(OSError):
                    os.unlink(name, dir_fd=self._folder)
            self.socket.close()
            os.close(self._folder)
            self._folder = -1

    def _listen(self) -> None:
        unready = self._name + _UNREADY
        for name in (self._name, unready):
            # whoever had our process id before is gone
            with suppress(FileNotFoundError):
                os.unlink(name, dir_fd=self._folder)
        self.socket.bind(inside(self._folder, unready))
        os.chmod(unready, 0o600, dir_fd=self._folder)
        self.socket.listen()
        os.rename(
            unready,
            self._name,
            src_dir_fd=self._folder,
            dst_dir_fd=self._folder,
        )


def connections(
    environment: Mapping[str, str], warn: Callable[[str], None]
) -> list[socket.socket]:
    """
    Connect to all running launches of the user, the oldest process id first.

    What a launch left that was killed is removed.

    :param warn: Is told of a folder that others may enter, and that is not
      used for this reason
    """
    found = []
    for folder in folders(environment):
        try:
            descriptor = open_folder(folder, make=False)
        except FileNotFoundError:
            continue
        except FolderError as error:
            warn(str(error))
            continue
        try:
            for name in sorted(os.listdir(descriptor), key=_number):
                connection = _connect(descriptor, name)
                if connection is not None:
                    found.append(connection)
        finally:
            os.close(descriptor)
    return found


def is_own(connection: socket.socket) -> bool:
    """Tell whether the other end is a process of this user."""
    return _credentials(connection)[1] == os.getuid()


def peer_pid(connection: socket.socket) -> int:
    """Return the process id of the other end."""
    return _credentials(connection)[0]


def _credentials(connection: socket.socket) -> tuple[int, int]:
    data = connection.getsockopt(
        socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size
    )
    pid, user, _ = _CREDENTIALS.unpack(data)
    return pid, user


def _connect(folder: int, name: str) -> socket.socket | None:
    if name.endswith(SUFFIX + _UNREADY):
        if not Path(f'/proc/{_number(name)}').exists():
            _remove(folder, name)
        return None
    if not name.endswith(SUFFIX):
        return None
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        # a launch that is suspended and has many clients makes us wait
        connection.setblocking(False)
        connection.connect(inside(folder, name))
        connection.setblocking(True)
        if is_own(connection):
            return connection
    except ConnectionRefusedError:
        _remove(folder, name)
    except OSError:
        # it ended just now
        pass
    connection.close()
    return None


def _remove(folder: int, name: str) -> None:
    with suppress(OSError):
        status = os.stat(name, dir_fd=folder, follow_symlinks=False)
        if stat.S_ISSOCK(status.st_mode):
            os.unlink(name, dir_fd=folder)


def _number(name: str) -> int:
    digits = name.partition('.')[0]
    return int(digits) if digits.isdigit() else 0
