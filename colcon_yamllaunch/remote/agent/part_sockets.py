# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The sockets at which a launcher finds its parts when it connects again.

The engine of a part listens on a socket in a private folder of the user. Its
name has the boot and the container of the machine. An engine that ends in
order removes its socket. A socket without engine belongs to a part with
orphans, which :func:`stop_orphans` stops. The folder that systemd makes for
users who are logged in (`/run/user/UID`) is not used, as it is removed with
the connection.
"""

from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack, suppress
import os
from pathlib import Path
import re
import signal
import socket
import time
import zlib

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.escalation import (
    Escalation,
    Orphan,
    Targets,
    Timeouts,
    WHOLE,
)
from colcon_yamllaunch.common.files import temporary_folders
from colcon_yamllaunch.common.process_scan import read_process
from colcon_yamllaunch.control.socket_folder import (
    FolderError,
    inside,
    open_folder,
)
from colcon_yamllaunch.engine.cgroup import LaunchCgroup
from colcon_yamllaunch.engine.launch_scan import (
    find_orphans,
    is_guarded,
    Known,
    launcher_of,
)
from colcon_yamllaunch.plan.plan import (
    DEFAULT_SIGKILL_TIMEOUT,
    DEFAULT_SIGTERM_TIMEOUT,
)

_BOOT = '/proc/sys/kernel/random/boot_id'
_NAMESPACE = '/proc/self/ns/pid'
# an identity as new_identity() makes it, the boot and the namespace
_SOCKET = re.compile(r'([0-9a-f]{16})-([0-9a-f]{8})-([0-9a-f]{8})\.link')
_TIMEOUTS = Timeouts(DEFAULT_SIGTERM_TIMEOUT, DEFAULT_SIGKILL_TIMEOUT)
_INTERVAL = 0.05


def boot_of_machine() -> str:
    """Return what another start of the machine, or container, changes."""
    found = []
    with suppress(OSError):
        found.append(Path(_BOOT).read_text(encoding='ascii').strip())
    with suppress(OSError):
        found.append(os.readlink(_NAMESPACE))
    return ' '.join(found)


class PartSockets:
    """
    The folder with the sockets, opened.

    :param environment: `TMPDIR` in it is looked at
    :raises UserError: when there is no such folder
    """

    def __init__(self, environment: Mapping[str, str]) -> None:
        reasons = []
        for folder in _folders(environment):
            try:
                if folder.parent.name == 'colcon-launch':
                    folder.parent.mkdir(0o700, parents=True, exist_ok=True)
                self._folder = open_folder(folder, make=True)
                #: Its path.
                self.path = folder
                return
            except FolderError as error:
                reasons.append(str(error))
            except OSError as error:
                reasons.append(f'{folder}: {error.strerror}')
        raise UserError(
            'there is no folder for the socket of the launch: '
            f'{"; ".join(reasons)}'
        )

    def listen(self, identity: str) -> socket.socket:
        """
        Open the socket of a part.

        :raises OSError: when that cannot be
        """
        with ExitStack() as stack:
            server = stack.enter_context(socket.socket(socket.AF_UNIX))
            server.bind(inside(self._folder, _socket_of(identity)))
            server.listen(8)
            server.setblocking(False)
            stack.pop_all()
        return server

    def connect(self, identity: str) -> socket.socket:
        """
        Connect with the engine of a part.

        :raises OSError: when it is gone
        """
        with ExitStack() as stack:
            client = stack.enter_context(socket.socket(socket.AF_UNIX))
            client.connect(inside(self._folder, _socket_of(identity)))
            stack.pop_all()
        return client

    def has_socket(self, identity: str) -> bool:
        """Return whether a part has not ended in order."""
        with suppress(OSError):
            os.stat(_socket_of(identity), dir_fd=self._folder)
            return True
        return False

    def remove(self, identity: str) -> None:
        """Remove the socket of a part that has ended."""
        self._unlink(_socket_of(identity))

    def orphaned(self) -> Iterator[str]:
        """Iterate over the parts whose engine is gone, but not in order."""
        for name in os.listdir(self._folder):
            match = _SOCKET.fullmatch(name)
            if match is None:
                continue
            identity, boot, _ = match.groups()
            if f'-{boot}-' not in _socket_of(identity):
                self._unlink(name)
            elif name == _socket_of(identity):
                # others are of a container that shares the folder
                launcher = launcher_of(identity)
                if launcher is not None and not launcher[1]:
                    yield identity

    def _unlink(self, name: str) -> None:
        with suppress(OSError):
            os.unlink(name, dir_fd=self._folder)


def _socket_of(identity: str) -> str:
    """Return the name of the socket of a part that runs in this boot."""
    boot, _, namespace = boot_of_machine().partition(' ')
    digests = (zlib.crc32(text.encode()) for text in (boot, namespace))
    return '-'.join((identity, *(f'{d:08x}' for d in digests))) + '.link'


def _folders(environment: Mapping[str, str]) -> Iterator[Path]:
    # not TMPDIR first: the next connection may have another one
    name = f'colcon-launch-{os.getuid()}'
    yield from (folder / name for folder in temporary_folders({}))
    yield Path(os.path.expanduser('~')) / '.cache' / 'colcon-launch' / 'parts'
    if environment.get('TMPDIR'):
        yield Path(environment['TMPDIR']) / name


class _Orphans(Targets):
    """
    Processes with the mark of a launch, and their descendants.

    :param leader: A child of ours that leads a group and a session, or 0
    """

    def __init__(self, identity: str, leader: int) -> None:
        self._identity = identity
        self._leader = leader
        self._known: Known = {}
        pids = [orphan.pid for orphan in self.search(())]
        self._cgroup = LaunchCgroup.of_members(identity, pids)

    def groups(self) -> Mapping[int, int]:
        if self._leader and read_process(self._leader) is not None:
            return {self._leader: WHOLE}
        return {}

    def search(self, groups: Collection[int]) -> list[Orphan]:
        session = self._leader or -1
        made = {self._leader: WHOLE} if self._leader else {}
        return find_orphans(
            self._identity, session, made, groups, known=self._known
        )

    def kill(self, number: int) -> None:
        self._cgroup.kill(number)

    def remove(self) -> None:
        """Remove the control group."""
        self._cgroup.remove()


def stop_orphans(
    identity: str, *, leader: int = 0, timeouts: Timeouts = _TIMEOUTS
) -> None:
    """
    End all processes of a launch, and wait for that.

    A guard is left to its work as long as there is one: it knows the
    time-outs of each process.

    :param leader: A child of ours that is to be ended, too
    """
    while is_guarded(identity):
        time.sleep(_INTERVAL)
    orphans = _Orphans(identity, leader)
    Escalation(orphans, {WHOLE: timeouts}, time.monotonic()).run()
    orphans.remove()


def stop_orphans_in_fork(
    identity: str, leader: int, timeouts: Timeouts
) -> None:
    """
    End all processes of a request, even if this process is ended meanwhile.

    :param leader: A child of ours that is to be ended, too
    """
    pid = os.fork()
    if not pid:
        with suppress(BaseException):
            os.setsid()
            signal.signal(signal.SIGTERM, signal.SIG_IGN)
            stop_orphans(identity, leader=leader, timeouts=timeouts)
        os._exit(0)
    os.waitpid(pid, 0)
