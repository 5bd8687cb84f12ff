# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Isolation of concurrent runs: a network and a ROS_DOMAIN_ID for each.

Where the system allows it, a run has its own network with nothing but the
loopback interface, see network_namespaces(7), and its own `/dev/shm`, as DDS
uses shared memory, too. Without the right to make these, a user namespace is
tried, in which the user stays the same, see user_namespaces(7). A child
process tries once what the system allows.

Nodes of one domain find one another. DDS computes its ports from the domain:
Linux gives those of the domains from 102 to 214 to any program, and 232 is the
last domain (ROS 2, "The ROS_DOMAIN_ID").
"""

from collections import deque
from collections.abc import Mapping
from contextlib import suppress
import errno
import fcntl
import os
from pathlib import Path
import socket
import struct

from colcon_yamllaunch.common.files import temporary_folders

DOMAIN_VARIABLE = 'ROS_DOMAIN_ID'
#: 0 is the domain of everybody who does not choose.
DOMAIN_IDS = (*range(1, 102), *range(215, 233))

_CLONE_NEWNS = 0x00020000
_CLONE_NEWUSER = 0x10000000
_CLONE_NEWNET = 0x40000000
_MS_REC = 0x4000
_MS_SLAVE = 0x80000
_MS_NOSUID_NODEV = 0x6
_MNT_DETACH = 0x2
_SIOCSIFFLAGS = 0x8914
_IFF_UP_RUNNING_MULTICAST = 0x1041
_SIOCADDRT = 0x890B
_RTF_UP = 0x0001
#: POSIX shared memory on Linux, see shm_overview(7).
_SHARED_MEMORY = b'/dev/shm'
#: The meaning of errors of unshare(2) for users, where their text is unclear.
_REASONS = {
    errno.EPERM: 'the system permits it to nobody but root',
    errno.ENOSPC: 'the limits of the system, /proc/sys/user, allow no more',
    errno.EINVAL: 'its kernel cannot do it',
}


class DomainIds:
    """
    Reserves a ROS_DOMAIN_ID for each run.

    :param environment: The user's environment; its own domain is not used
    :param shared: Whether the runs share a network with others, also with
      those of other sweeps of the user
    """

    def __init__(
        self, environment: Mapping[str, str], *, shared: bool
    ) -> None:
        own = environment.get(DOMAIN_VARIABLE, '').strip()
        others = (n for n in DOMAIN_IDS if str(n) != own)
        self._ids: deque[int] = deque(others)
        self._shared = shared
        # the lock files, by the domain
        self._reserved: dict[int, int] = {}
        self._folder = (
            temporary_folders(environment)[0]
            / f'colcon_sweep_domains_{os.getuid()}'
        )

    @property
    def count(self) -> int:
        """The number of runs that can have different ones."""
        return len(self._ids)

    def reserve(self) -> int | None:
        """
        Return a free one, None if there is none.

        In separate networks, runs may have the same.
        """
        for _ in range(self.count):
            number = self._next()
            if number not in self._reserved:
                lock = self._lock(number) if self._shared else -1
                if lock is not None:
                    self._reserved[number] = lock
                    return number
        return None if self._shared else self._next()

    def release(self, number: int) -> None:
        """Release it for another run."""
        lock = self._reserved.pop(number, -1)
        if lock != -1:
            os.close(lock)

    def close(self) -> None:
        """Release all."""
        for number in tuple(self._reserved):
            self.release(number)

    def _next(self) -> int:
        self._ids.rotate(-1)
        return self._ids[-1]

    def _lock(self, number: int) -> int | None:
        """Return the locked file of one; -1 if there can be no such file."""
        try:
            self._folder.mkdir(mode=0o700, exist_ok=True)
            status = self._folder.lstat()
            # nobody else may put links there
            if not self._folder.is_dir() or status.st_uid != os.getuid():
                return -1
            flags = os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW
            lock = os.open(self._folder / str(number), flags, 0o600)
        except OSError:
            return -1
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(lock)
            return None
        return lock


def reason_for_no_network() -> str:
    """Return why a run cannot have its own network, '' if it can."""
    pid = os.fork()
    if not pid:
        number = errno.EPERM
        try:
            enter_own_network()
            number = 0
        except OSError as e:
            number = e.errno or number
        finally:
            os._exit(number)
    _, status = os.waitpid(pid, 0)
    number = os.waitstatus_to_exitcode(status)
    if number < 0:
        return 'it is not allowed'
    return _REASONS.get(number, os.strerror(number)) if number else ''


def enter_own_network(*, again: bool = False) -> None:
    """
    Move this process, and all that it will start, to a network of its own.

    :param again: Whether it is in one already, which it leaves
    :raises OSError: when that is not possible
    """
    uid, gid = os.getuid(), os.getgid()
    try:
        _call('unshare', _CLONE_NEWNET | _CLONE_NEWNS)
    except PermissionError:
        _call('unshare', _CLONE_NEWUSER | _CLONE_NEWNET | _CLONE_NEWNS)
        # without this nobody without privileges may map groups
        folder = Path('/proc/self')
        with suppress(OSError):
            (folder / 'setgroups').write_text('deny')
        (folder / 'uid_map').write_text(f'{uid} {uid} 1')
        (folder / 'gid_map').write_text(f'{gid} {gid} 1')
    _start_loopback()
    with suppress(OSError):
        # later mounts outside appear here, but not the other way round
        none = b'none'
        _call('mount', none, b'/', none, _MS_REC | _MS_SLAVE, None)
        if again:
            # with the files of the previous run
            _call('umount2', _SHARED_MEMORY, _MNT_DETACH)
        name, options = b'tmpfs', b'mode=1777'
        _call('mount', name, _SHARED_MEMORY, name, _MS_NOSUID_NODEV, options)


def _call(name: str, *arguments: int | bytes | None) -> None:
    """
    Call a function of the C library.

    :raises OSError: when it fails
    """
    # late, as few commands need it
    import ctypes

    libc = ctypes.CDLL(None, use_errno=True)
    values = [
        ctypes.c_ulong(a) if isinstance(a, int) else a for a in arguments
    ]
    if libc[name](*values):
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))


def _start_loopback() -> None:
    """
    Switch the loopback interface on, for multicast as well.

    DDS finds others by multicast; that is off by default, and there is no
    route for it without another interface.
    """
    import ctypes

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as anything:
        up = struct.pack('16sh14x', b'lo', _IFF_UP_RUNNING_MULTICAST)
        fcntl.ioctl(anything, _SIOCSIFFLAGS, up)
        name = ctypes.create_string_buffer(b'lo')
        route = struct.pack(
            # struct rtentry of <net/route.h>
            'L 16s 16s 16s H h L P h P L L H',
            0,
            _address('224.0.0.0'),
            _address('0.0.0.0'),
            _address('240.0.0.0'),
            _RTF_UP,
            *(0, 0, 0, 0),
            ctypes.addressof(name),
            *(0, 0, 0),
        )
        with suppress(OSError):
            # without it, nodes may still find one another by shared memory
            fcntl.ioctl(anything, _SIOCADDRT, route)


def _address(text: str) -> bytes:
    """Return an IPv4 address as struct sockaddr."""
    return struct.pack('HH4s8x', socket.AF_INET, 0, socket.inet_aton(text))
