# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Keeping runs that go on at once from hearing one another.

Where the system allows it, a run has a network of its own, in which there is
nothing but the loopback interface, see network_namespaces(7), and a
`/dev/shm` of its own, as DDS speaks by shared memory, too. Without the right
to make these, it is tried within a user namespace, in which the user remains
who he is, see user_namespaces(7). What the system does not allow is found out
once, by a process that tries.
"""

from contextlib import suppress
import errno
import os
import signal
import socket
import struct

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
_PR_SET_PDEATHSIG = 1
#: Where POSIX shared memory is on Linux, see shm_overview(7).
_SHARED_MEMORY = b'/dev/shm'
#: What errors of unshare(2) mean for users, as far as that is not what they
#: say.
_REASONS = {
    errno.EPERM: 'the system permits it to nobody but root',
    errno.ENOSPC: 'the limits of the system, /proc/sys/user, allow no more',
    errno.EINVAL: 'its kernel cannot do it',
}


def reason_for_no_network() -> str:
    """Return why a run can have no network of its own, '' if it can."""
    reader, writer = os.pipe()
    pid = os.fork()
    if not pid:
        try:
            os.close(reader)
            try:
                enter_own_network()
                text = b''
            except OSError as e:
                text = _REASONS.get(e.errno or 0, e.strerror or '?').encode()
            os.write(writer, text or b'.')
        finally:
            os._exit(0)
    os.close(writer)
    with open(reader, 'rb') as file:
        said = file.read()
    os.waitpid(pid, 0)
    # one that was killed has said nothing
    return '' if said == b'.' else said.decode() or 'it is not allowed'


def enter_own_network(*, again: bool = False) -> None:
    """
    Be in a network of our own from now on, with all that we start.

    :param again: Whether this process is in one already, which it leaves

    :raises OSError: when that is not possible
    """
    uid, gid = os.getuid(), os.getgid()
    try:
        _unshare(_CLONE_NEWNET | _CLONE_NEWNS)
    except PermissionError:
        _unshare(_CLONE_NEWUSER | _CLONE_NEWNET | _CLONE_NEWNS)
        # without this nobody without privileges may map groups
        with suppress(OSError):
            _write('/proc/self/setgroups', 'deny')
        _write('/proc/self/uid_map', f'{uid} {uid} 1')
        _write('/proc/self/gid_map', f'{gid} {gid} 1')
    _bring_loopback_up()
    with suppress(OSError):
        # what is mounted outside later is to be seen here, but not the other
        # way round
        _mount(b'none', b'/', None, _MS_REC | _MS_SLAVE)
        if again:
            # what others left there goes
            _unmount(_SHARED_MEMORY)
        _mount(b'tmpfs', _SHARED_MEMORY, b'mode=1777', _MS_NOSUID_NODEV)


def end_with(parent: int) -> None:
    """
    Have SIGTERM sent to us when our parent ends, whatever ends it.

    To be called behind :func:`enter_own_network`, which undoes it; see
    PR_SET_PDEATHSIG in prctl(2).

    :param parent: The process id that it has, in case it has ended already
    """
    import ctypes

    arguments = [ctypes.c_ulong(n) for n in (signal.SIGTERM, 0, 0, 0)]
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, *arguments)
    if os.getppid() != parent:
        os.kill(os.getpid(), signal.SIGTERM)


def _unshare(flags: int) -> None:
    # late, as it is needed in few commands; Python has it from 3.12 on
    import ctypes

    libc = ctypes.CDLL(None, use_errno=True)
    if libc.unshare(ctypes.c_int(flags)):
        raise _error(ctypes.get_errno())


def _mount(
    source: bytes, target: bytes, options: bytes | None, flags: int
) -> None:
    import ctypes

    libc = ctypes.CDLL(None, use_errno=True)
    result = libc.mount(source, target, source, ctypes.c_ulong(flags), options)
    if result:
        raise _error(ctypes.get_errno())


def _unmount(target: bytes) -> None:
    import ctypes

    libc = ctypes.CDLL(None, use_errno=True)
    if libc.umount2(target, _MNT_DETACH):
        raise _error(ctypes.get_errno())


def _error(number: int) -> OSError:
    return OSError(number, os.strerror(number))


def _bring_loopback_up() -> None:
    """
    Let the loopback interface pass all that nodes say, by multicast as well.

    DDS finds others by multicast; the interface has that switched off, and
    without another one there is no route for it.
    """
    # as late as this, as most commands do without
    import ctypes
    import fcntl

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


def _write(path: str, text: str) -> None:
    descriptor = os.open(path, os.O_WRONLY)
    try:
        os.write(descriptor, text.encode())
    finally:
        os.close(descriptor)
