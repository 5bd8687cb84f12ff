# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Where a part of a launch is found by those who connect again.

Its engine listens on a socket in a folder that is the user's alone. A record
beside it goes when the engine has ended in order, so one whose engine is gone
tells of a part that something may be left of, which
:func:`end_what_is_left` ends. The folder that systemd makes for those who are
logged in (`/run/user/UID`) would go with the connection.
"""

from collections.abc import Collection
from collections.abc import Iterator
from collections.abc import Mapping
from contextlib import suppress
import os
from pathlib import Path
import re
import signal
import socket
import time

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.escalation import Escalation
from colcon_yamllaunch.common.escalation import Orphan
from colcon_yamllaunch.common.escalation import Targets
from colcon_yamllaunch.common.escalation import Timeouts
from colcon_yamllaunch.common.escalation import WHOLE
from colcon_yamllaunch.common.process_scan import read_process
from colcon_yamllaunch.common.temporary_folders import temporary_folders
from colcon_yamllaunch.control.socket_folder import FolderError
from colcon_yamllaunch.control.socket_folder import inside
from colcon_yamllaunch.control.socket_folder import open_folder
from colcon_yamllaunch.engine.cgroup import LaunchCgroup
from colcon_yamllaunch.engine.launch_scan import find_orphans
from colcon_yamllaunch.engine.launch_scan import is_guarded
from colcon_yamllaunch.engine.launch_scan import Known
from colcon_yamllaunch.engine.launch_scan import launcher_of
from colcon_yamllaunch.plan.plan import DEFAULT_SIGKILL_TIMEOUT
from colcon_yamllaunch.plan.plan import DEFAULT_SIGTERM_TIMEOUT

_SOCKET, _RECORD, _UNFINISHED = '.link', '.part', '.new'
_BOOT = '/proc/sys/kernel/random/boot_id'
_NAMESPACE = '/proc/self/ns/pid'
# as new_identity() makes it
_IDENTITY = re.compile('[0-9a-f]{16}')
_TIMEOUTS = Timeouts(DEFAULT_SIGTERM_TIMEOUT, DEFAULT_SIGKILL_TIMEOUT)
_LOOK = 0.05


def boot_of_machine() -> str:
    """Return what another start of the machine, or container, changes."""
    found = []
    with suppress(OSError):
        found.append(Path(_BOOT).read_text(encoding='ascii').strip())
    with suppress(OSError):
        found.append(os.readlink(_NAMESPACE))
    return ' '.join(found)


class PartPlace:
    """
    The folder with sockets and records, opened.

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
        Open the socket of a part, and write its record.

        :raises OSError: when that cannot be
        """
        server = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            server.bind(inside(self._folder, identity + _SOCKET))
            server.listen(8)
            flags = os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC
            # an unfinished record would be taken for one of another boot
            unfinished = identity + _UNFINISHED
            record = os.open(unfinished, flags, 0o600, dir_fd=self._folder)
            os.write(record, boot_of_machine().encode())
            os.close(record)
            os.rename(
                unfinished,
                identity + _RECORD,
                src_dir_fd=self._folder,
                dst_dir_fd=self._folder,
            )
        except BaseException:
            server.close()
            raise
        server.setblocking(False)
        return server

    def connect(self, identity: str) -> socket.socket:
        """
        Connect with the engine of a part.

        :raises OSError: when it is gone
        """
        client = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            client.connect(inside(self._folder, identity + _SOCKET))
        except BaseException:
            client.close()
            raise
        return client

    def has_record(self, identity: str) -> bool:
        """Tell whether a part has not ended in order."""
        with suppress(OSError):
            os.stat(identity + _RECORD, dir_fd=self._folder)
            return True
        return False

    def remove(self, identity: str) -> None:
        """Remove socket and record, as the part has ended."""
        for suffix in (_SOCKET, _RECORD, _UNFINISHED):
            with suppress(OSError):
                os.unlink(identity + suffix, dir_fd=self._folder)

    def left_behind(self) -> Iterator[str]:
        """Iterate over the parts whose engine is gone, but not in order."""
        for name in os.listdir(self._folder):
            identity = name.removesuffix(_RECORD)
            if identity == name or not _IDENTITY.fullmatch(identity):
                continue
            boot, _, namespace = self._read(name).partition(' ')
            ours = boot_of_machine().partition(' ')
            if boot != ours[0]:
                self.remove(identity)
                continue
            if namespace != ours[2]:
                # a container that shares the folder
                continue
            launcher = launcher_of(identity)
            if launcher is not None and not launcher[1]:
                yield identity

    def _read(self, name: str) -> str:
        flags = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
        with suppress(OSError):
            record = os.open(name, flags, dir_fd=self._folder)
            try:
                return os.read(record, 1024).decode(errors='replace')
            finally:
                os.close(record)
        return ''


def _folders(environment: Mapping[str, str]) -> Iterator[Path]:
    # not TMPDIR first: the next connection may have another one
    name = f'colcon-launch-{os.getuid()}'
    yield from (folder / name for folder in temporary_folders({}))
    yield Path(os.path.expanduser('~')) / '.cache' / 'colcon-launch' / 'parts'
    if environment.get('TMPDIR'):
        yield Path(environment['TMPDIR']) / name


class _Left(Targets):
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


def end_what_is_left(
    identity: str, *, leader: int = 0, timeouts: Timeouts = _TIMEOUTS
) -> None:
    """
    End all processes of a launch, and wait for that.

    A guard is left to its work as long as there is one: it knows the
    time-outs of each process.

    :param leader: A child of ours that is to be ended, too
    """
    while is_guarded(identity):
        time.sleep(_LOOK)
    left = _Left(identity, leader)
    Escalation(left, {WHOLE: timeouts}, time.monotonic()).run()
    left.remove()


def end_in_any_case(identity: str, leader: int, timeouts: Timeouts) -> None:
    """
    End all processes of a request, even if this process is ended meanwhile.

    :param leader: A child of ours that is to be ended, too
    """
    pid = os.fork()
    if not pid:
        with suppress(BaseException):
            os.setsid()
            signal.signal(signal.SIGTERM, signal.SIG_IGN)
            end_what_is_left(identity, leader=leader, timeouts=timeouts)
        os._exit(0)
    os.waitpid(pid, 0)
