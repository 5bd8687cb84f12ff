# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The sockets of a user's running launches, in private folders.

A launch has its socket in the first usable folder. Clients look in all of
them, as another terminal may have other variables:

- `colcon-launch` in `XDG_RUNTIME_DIR` (XDG Base Directory Specification)
  where that is a folder of the user's own that nobody else may write to; else
  in the folder that it stands for, `/run/user/UID` (pam_systemd), likewise;
- `colcon-launch-UID` in each folder for temporary files.

A service of the system has a folder of its own, which systemd makes for its
user (`RuntimeDirectory=`). Root finds the launches of all such services.

A folder that others made or may enter is not used. Everything in it is
reached through its descriptor, so it cannot be exchanged between a check and
its use, and the path of a socket is never too long.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
import os
from pathlib import Path
import socket
import stat
import struct

from colcon_yamllaunch.common.files import names_in, temporary_folders
from colcon_yamllaunch.engine.own_files import OwnFile

#: The ending of a socket's name; before it stands the launcher's process id.
SUFFIX = '.sock'

#: Where the system makes a folder for each user who is logged in.
USER_FOLDERS = '/run/user'

#: Where systemd makes a folder for each service of the system.
SERVICE_FOLDERS = Path('/run/colcon_launch')

# a socket that nobody listens on yet has another name, so that it is not
# taken for a stale one
_UNREADY = '.new'
_CREDENTIALS = struct.Struct('3i')

_NAME = 'colcon-launch'
_FLAGS = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC


class FolderError(Exception):
    """A folder cannot be used; the text says why, in one line."""


def folders(environment: Mapping[str, str]) -> tuple[Path, ...]:
    """
    Return the folders where sockets may be, the one to be tried first.

    With both variables, and a runtime folder that is not the system's, the
    launches are separate from the other ones of the user.
    """
    usual = f'{USER_FOLDERS}/{os.getuid()}'
    runtime = environment.get('XDG_RUNTIME_DIR', '')
    if not os.path.isabs(runtime) or not _is_own(runtime):
        runtime = usual
    found = [Path(runtime) / _NAME] if _is_own(runtime) else []
    service = Path(environment.get('RUNTIME_DIRECTORY', ''))
    if service.parent == SERVICE_FOLDERS and _is_own(str(service)):
        found.insert(0, service)
    places = temporary_folders(environment)
    if runtime != usual and environment.get('TMPDIR'):
        places = places[:1]
    found += [folder / f'{_NAME}-{os.getuid()}' for folder in places]
    return tuple(found)


def service_folders() -> list[Path]:
    """Return the folders of the services of the system that run."""
    return sorted(SERVICE_FOLDERS / n for n in names_in(SERVICE_FOLDERS))


def readable_folders(environment: Mapping[str, str]) -> list[Path]:
    """Return the folders with sockets that the user may connect to."""
    found = list(folders(environment))
    for folder in service_folders():
        may_enter = os.getuid() == 0 or _is_own(str(folder))
        if may_enter and folder not in found:
            found.append(folder)
    return found


def services_of_others() -> dict[str, int]:
    """Return the users of the services that only they and root may see."""
    found: dict[str, int] = {}
    for folder in service_folders() if os.getuid() else ():
        with suppress(OSError):
            user = os.stat(folder).st_uid
            if user != os.getuid():
                found[folder.name] = user
    return found


def has_sockets(environment: Mapping[str, str]) -> bool:
    """Return whether launches of the user may run, without connecting."""
    for folder in readable_folders(environment):
        with suppress(OSError):
            if any(name.endswith(SUFFIX) for name in os.listdir(folder)):
                return True
    return False


def open_folder(path: Path, *, make: bool) -> int:
    """
    Check that a folder is the user's alone, and return its descriptor.

    :raises FolderError: when it is not the user's alone, or cannot be made
    :raises FileNotFoundError: when it does not exist
    """
    try:
        if make:
            # the owner of an existing one is checked below
            with suppress(FileExistsError):
                path.mkdir(mode=0o700)
        descriptor = os.open(path, _FLAGS)
    except FileNotFoundError:
        raise
    except OSError as error:
        raise FolderError(f'{path}: {error.strerror}') from error
    status = os.fstat(descriptor)
    # root may look into the folders that systemd made for others
    is_ours = not make and os.getuid() == 0 and path.parent == SERVICE_FOLDERS
    is_ours |= status.st_uid == os.getuid()
    if not is_ours or stat.S_IMODE(status.st_mode) & 0o077:
        os.close(descriptor)
        raise FolderError(
            f'{path} is not yours alone; remove it, or make it so: '
            f'chmod 700 {path}'
        )
    return descriptor


def inside(descriptor: int, name: str) -> str:
    """Return a short path of something in an open folder."""
    return f'/proc/self/fd/{descriptor}/{name}'


def _is_own(path: str) -> bool:
    try:
        status = os.stat(path)
    except OSError:
        return False
    mode = stat.S_IMODE(status.st_mode)
    return (
        stat.S_ISDIR(status.st_mode)
        and status.st_uid == os.getuid()
        and not mode & 0o022
    )


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
    def file(self) -> OwnFile:
        """What is at its path; see :mod:`own_files`."""
        status = os.stat(
            self._name, dir_fd=self._folder, follow_symlinks=False
        )
        path = os.path.abspath(self.path)
        return OwnFile(path, status.st_dev, status.st_ino)

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
            # of an ended process with our process id
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

    :param warn: Is called with a folder that others may enter, and that is not
      used for this reason
    """
    found = []
    for folder in readable_folders(environment):
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
    """Return whether the other end is a process of this user."""
    return _credentials(connection)[1] == os.getuid()


def is_permitted(connection: socket.socket) -> bool:
    """Return whether the other end is a process of this user or of root."""
    return is_own(connection) or _credentials(connection)[1] == 0


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
        # nobody else listens in a folder of this user
        if _credentials(connection)[1] == os.fstat(folder).st_uid:
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
