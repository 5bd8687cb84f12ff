# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The control group of a launch, where one can be made; see cgroups(7).

It is a folder in that of the control group (version 2) that the launcher is
in, with one folder for each process of the plan. What is born there cannot
leave it by another session, another parent or another environment. So it is
exact which process of the plan each one belongs to, and all of them can be
killed at once. The launcher and its guard stay in their group.

The groups of other programs are not changed. If the folder cannot be made,
the launch silently runs without a control group.

Where processes have limits, :meth:`LaunchCgroup.use` enables controllers.
Linux enables none in a group that has processes, so whatever is in the group
of the launcher may have to move to one inside it meanwhile, `NAME.launcher`.
:mod:`.limit_groups` finds out where that is possible.

This module is part of the guard and imports little.
"""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
import errno
import fcntl
from functools import cached_property
import os
import re
import time
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.process_scan import cgroup_of

if TYPE_CHECKING:
    from threading import Thread

#: The environment variable that, set to 0, keeps a launch from having one.
CGROUP_VARIABLE = 'COLCON_LAUNCH_CGROUP'

_PREFIX = 'colcon_launch-'
_NAME = re.compile(rf'{_PREFIX}[0-9a-f]{{16}}')
# the group of a launcher that had to leave its own one
_LAUNCHER = '.launcher'
_STALE = re.compile(rf'{_NAME.pattern}({re.escape(_LAUNCHER)})?')
# in the last launch of those that are nested
_OF_PROCESS = re.compile(rf'.*/{_NAME.pattern}/\d+(?=/|$)')
# With any other controller, what is in a group of its own gets another share
# of the machine than what is not; real-time processes may even get none.
_HARMLESS = {'memory', 'pids'}
# how often a folder is made that another launch takes for a stale one
_TRIES = 3
# Seconds that killed processes get to leave their folders; the kernel may
# take a moment longer with that than with reporting their end.
_KILL_TIMEOUT = 0.5
_INTERVAL = 0.002
# Seconds that the kernel is ready for another move at least, and how many
# moves of nobody keep it so: for half a second.
_READY_FOR = 0.004
_VAIN_MOVES = 125

# the thread of :func:`make_ready`; its move must end before any other
_early_move: 'Thread | None' = None


class LaunchCgroup:
    """
    The control group of a launch.

    :param identity: The identity of the launch
    :param wanted: Whether one is made
    """

    def __init__(self, identity: str, *, wanted: bool = True) -> None:
        self._name = _PREFIX + identity
        self._wanted = wanted
        self._lock = -1
        self._is_inside = self._stays_inside = False
        # those that its processes may be limited by, and those of them that
        # the group around it did not have before
        self._controllers: frozenset[str] = frozenset()
        self._enabled: frozenset[str] = frozenset()

    @classmethod
    def of_members(cls, identity: str, pids: Iterable[int]) -> 'LaunchCgroup':
        """Return the group that some processes of a launch are in."""
        group = cls(identity, wanted=False)
        name = f'/{group._name}'
        for pid in pids:
            outside, found, _ = (cgroup_of(pid) or '').partition(f'{name}/')
            if found:
                # cached, and where we are ourselves does not matter
                group._folder = _mounted(outside + name)
                break
        return group

    @contextmanager
    def entered(self, number: int) -> Iterator[None]:
        """
        Move to the group of a process, so that it starts there.

        If there can be none, nothing happens. The first move for a while takes
        some 10 ms, as the kernel waits until each processor took note of it,
        those soon after it 0.05 ms.

        :param number: The number of the process in the plan
        """
        if not self._can_use_folder or not self._enter(number):
            yield
            return
        try:
            yield
        finally:
            if not self._stays_inside:
                self.leave()

    @contextmanager
    def moves_at_once(self) -> Iterator[None]:
        """
        Move from one process's group to the next one's, and back at the end.

        That takes half as many moves, which are a fifth of what a start costs.
        Meanwhile, nothing else may be started; and before anybody looks for
        the members of a group, :meth:`leave` has to be called.
        """
        self._stays_inside = True
        try:
            yield
        finally:
            self._stays_inside = False
            self.leave()

    def leave(self) -> None:
        """Move back to where we were."""
        if not self._is_inside:
            return
        self._is_inside = False
        try:
            _move_to(str(self._home))
        except OSError:
            # where nothing is killed but by ourselves
            with suppress(OSError):
                _move_to(str(self._folder))

    def use(self, base: str, controllers: Iterable[str]) -> None:
        """
        Make the group where its processes can have limits.

        To be called before anything is started.

        :param base: The folder of the group around it; see `limit_groups`
        :param controllers: What limits them, such as `memory`
        :raises OSError: when that is not possible
        """
        _end_early_move()
        wanted = frozenset(controllers)
        self._folder = f'{base}/{self._name}'
        before = _read(f'{base}/cgroup.subtree_control').split()
        self._enabled = wanted.difference(before)
        if not self._enabled or is_root(base) or not _members(base):
            _enable(base, self._enabled)
        else:
            self._clear(base)
        self._controllers = wanted
        # may have been found out before
        vars(self).pop('_can_use_folder', None)
        if not self._can_use_folder:
            raise OSError(errno.EACCES, os.strerror(errno.EACCES))
        _enable(self._folder, wanted)

    @property
    def folder(self) -> str:
        """The folder of the group, empty for none."""
        return (self._folder or '') if self._can_use_folder else ''

    def prepare(self, number: int, limits: Mapping[str, str]) -> str | None:
        """
        Make the group of a process with limits, and return its folder.

        What it counted for an earlier run is forgotten. We do not enter it,
        as the limits would hold for us. None is returned where there can be
        no groups.

        :param limits: The contents of its files
        :raises OSError: when it does not take a limit
        """
        _end_early_move()
        self.leave()
        if not self._can_use_folder:
            return None
        folder = f'{self._folder}/{number}'
        with suppress(OSError):
            os.rmdir(folder)
        with suppress(FileExistsError):
            os.mkdir(folder)
        for name, value in limits.items():
            _write(f'{folder}/{name}', value.encode())
        return folder

    def kill(self, number: int) -> None:
        """Kill all that is in the group of a process, in one step."""
        self.leave()
        if self._folder is not None:
            self._kill(f'{self._folder}/{number}')

    def remove(self) -> None:
        """Kill all that is left, and remove the folders."""
        if self._folder is not None:
            deadline = time.monotonic() + _KILL_TIMEOUT
            while not _remove(self._folder) and time.monotonic() < deadline:
                self._kill(self._folder)
                time.sleep(_INTERVAL)
            self._restore(os.path.dirname(self._folder))
        if self._lock != -1:
            os.close(self._lock)
            self._lock = -1

    @cached_property
    def _path(self) -> str | None:
        return cgroup_of('self')

    @cached_property
    def _home(self) -> str | None:
        """The folder of the group that we are in."""
        folder = None if self._path is None else _mounted(self._path)
        if folder is None or str(os.getpid()) not in _members(folder):
            return None
        return folder

    @cached_property
    def _folder(self) -> str | None:
        if self._home is None:
            return None
        # the group of a launcher that left its own one is beside it
        beside = f'{os.path.dirname(self._home)}/{self._name}'
        if os.path.isdir(beside):
            return beside
        return f'{self._home}/{self._name}'

    @cached_property
    def _can_use_folder(self) -> bool:
        """Whether the folder could be made, which is tried at first use."""
        if not self._wanted or self._home is None or self._folder is None:
            return False
        base = os.path.dirname(self._folder)
        controllers = _read(f'{base}/cgroup.subtree_control').split()
        if not (self._controllers or _HARMLESS.issuperset(controllers)):
            return False
        _remove_stale(base)
        try:
            for _ in range(_TRIES):
                with suppress(FileExistsError):
                    os.mkdir(self._folder)
                self._lock = _lock(self._folder)
                if self._lock != -1:
                    return True
                time.sleep(_INTERVAL)
        except OSError:
            pass
        return False

    def _clear(self, base: str) -> None:
        """
        Move what is in a group to one inside it, and enable its controllers.

        :raises OSError: when it is not to be moved
        """
        inner = f'{self._folder}{_LAUNCHER}'
        os.mkdir(inner)
        for attempt in range(_TRIES):
            _move_all(base, inner)
            try:
                _enable(base, self._enabled)
                break
            except OSError:
                # something may have been started there meanwhile
                if attempt == _TRIES - 1:
                    self._restore(base)
                    raise
        self._home, self._path = inner, cgroup_of('self')

    def _restore(self, base: str) -> None:
        """Undo what :meth:`use` did to the group around that of the launch."""
        inner = f'{self._folder}{_LAUNCHER}'
        enabled: Iterable[str] = self._enabled
        is_moved = os.path.isdir(inner)
        if is_moved:
            # before it had processes, and so none of them
            enabled = _read(f'{base}/cgroup.subtree_control').split()
        # they stay while another launch uses them
        with suppress(OSError):
            _enable(base, enabled, '-')
            if is_moved:
                _move_all(inner, base)
                os.rmdir(inner)
                vars(self).pop('_home', None)

    def _enter(self, number: int) -> bool:
        _end_early_move()
        # if the launcher was moved to another group, its processes follow
        if not self._is_inside and cgroup_of('self') != self._path:
            return False
        folder = f'{self._folder}/{number}'
        try:
            with suppress(FileExistsError):
                os.mkdir(folder)
            _move_to(folder)
        except OSError:
            self.leave()
            return False
        self._is_inside = True
        return True

    def _kill(self, folder: str) -> None:
        ours = cgroup_of('self') or ''
        if self._name not in ours.split('/'):
            # Linux before 5.14 cannot kill a group
            with suppress(OSError):
                _write(f'{folder}/cgroup.kill', b'1')


def is_wanted(environment: Mapping[str, str]) -> bool:
    """Return whether a launch with these variables has a control group."""
    return environment.get(CGROUP_VARIABLE) != '0'


def make_ready() -> None:
    """
    Make the kernel ready for moves that this process is about to make.

    It takes 10 ms (see :meth:`LaunchCgroup.entered`), so a thread waits for
    it, and the first move waits for the thread.
    """
    global _early_move
    # the guard, which imports this module, has no use for it
    from threading import Thread

    _early_move = Thread(target=expect_moves, args=(1,))
    _early_move.start()


def _end_early_move() -> None:
    if _early_move is not None:
        _early_move.join()


def expect_moves(count: int | None = None) -> bool:
    """
    Keep the kernel ready for moves for a moment; they then take no time.

    By moves to where we are, again and again: the first one takes the 10 ms
    (see :meth:`LaunchCgroup.entered`) that one of any process takes else. To
    be called in a thread or a process of its own, as it returns only when that
    moment is over. Return False where there can be no moves.

    :param count: The number of moves, by default those of half a second
    """
    path = cgroup_of('self')
    folder = None if path is None else _mounted(path)
    if folder is None:
        return False
    with suppress(OSError):
        _move_to(folder)
        for _ in range((count or _VAIN_MOVES) - 1):
            time.sleep(_READY_FOR)
            _move_to(folder)
        return True
    return False


def own_folder() -> str | None:
    """Return the folder of the group that we are in, if it is seen here."""
    return LaunchCgroup('')._home


def is_root(folder: str) -> bool:
    """Return whether a group is that of the whole machine."""
    return not os.path.exists(f'{folder}/cgroup.events')


def is_of_launch(folder: str) -> bool:
    """Return whether a group belongs to a launch."""
    return any(map(_NAME.fullmatch, folder.split('/')))


def number_of(pid: int, identity: str) -> int | None:
    """Return which process of a launch one is in the group of, if any."""
    path = cgroup_of(pid) or ''
    number = path.partition(f'/{_PREFIX}{identity}/')[2].partition('/')[0]
    return int(number) if number.isdecimal() else None


def process_folder(pid: int) -> str | None:
    """Return the folder of the group that the process of a launch is in."""
    found = _OF_PROCESS.match(cgroup_of(pid) or '')
    return None if found is None else _mounted(found[0])


def processor_time(folder: str) -> float | None:
    """Return the seconds that processors have spent on a group."""
    for line in _read(f'{folder}/cpu.stat').splitlines():
        name, _, value = line.partition(' ')
        if name == 'usage_usec':
            return int(value) / 1e6
    return None


def memory(folder: str) -> int | None:
    """
    Return the bytes of memory of a group, if they are counted.

    Copies of files that the kernel drops as soon as it needs the memory are
    none of it.
    """
    total = _read(f'{folder}/memory.current').strip()
    if not total:
        return None
    for line in _read(f'{folder}/memory.stat').splitlines():
        name, _, value = line.partition(' ')
        if name == 'inactive_file':
            return max(0, int(total) - int(value))
    return int(total)


def members(folder: str) -> set[int]:
    """Return the processes of a group, and of all groups in it."""
    return {
        int(pid) for inner, _, _ in os.walk(folder) for pid in _members(inner)
    }


def own_members(folder: str) -> set[int]:
    """Return the processes of a group, but not of those in it."""
    return set(map(int, _members(folder)))


def words_in(path: str) -> list[str]:
    """Return the words of a file of a group, none if there is no such file."""
    return _read(path).split()


def number_in(path: str) -> int | None:
    """Return the number in a file of a group, if there is one."""
    text = _read(path).strip()
    return int(text) if text.isdecimal() else None


def _members(folder: str) -> list[str]:
    return words_in(f'{folder}/cgroup.procs')


def _mounted(path: str) -> str | None:
    """Return the folder of a group, if it is to be seen here."""
    for line in _read('/proc/self/mountinfo').splitlines():
        mount, _, file_system = line.partition(' - ')
        if not file_system.startswith('cgroup2 '):
            continue
        root, point = map(_unescaped, mount.split(' ')[3:5])
        root = root.rstrip('/')
        if path == root or path.startswith(f'{root}/'):
            folder = (point + path.removeprefix(root)).rstrip('/')
            if os.path.exists(f'{folder}/cgroup.procs'):
                return folder
    return None


def _unescaped(text: str) -> str:
    return re.sub(r'\\([0-7]{3})', lambda m: chr(int(m[1], 8)), text)


def _lock(folder: str) -> int:
    """
    Mark a folder as one that is in use; return -1 if that is not possible.

    The lock ends with the process.
    """
    try:
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except OSError:
        return -1
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # the former owner of the lock may have removed it
        if os.path.samestat(os.fstat(descriptor), os.stat(folder)):
            return descriptor
    except OSError:
        pass
    os.close(descriptor)
    return -1


def _remove_stale(home: str) -> None:
    """Remove what launches left that were killed, with their guards."""
    try:
        names = os.listdir(home)
    except OSError:
        return
    for name in names:
        folder = f'{home}/{name}'
        is_empty = 'populated 0' in _read(f'{folder}/cgroup.events')
        if not (_STALE.fullmatch(name) and is_empty):
            continue
        with suppress(OSError):
            if os.stat(folder).st_uid != os.geteuid():
                continue
            lock = _lock(folder)
            if lock != -1:
                _remove(folder)
                os.close(lock)


def _remove(folder: str) -> bool:
    """Remove a group in which nothing runs, and return whether it is gone."""
    for inner, _, _ in os.walk(folder, topdown=False):
        with suppress(OSError):
            os.rmdir(inner)
    return not os.path.exists(folder)


def _move_to(folder: str) -> None:
    _write(f'{folder}/cgroup.procs', b'0')


def _move_all(source: str, target: str) -> None:
    """Move all processes of a group to another one."""
    for pid in _members(source):
        # it may have ended
        with suppress(ProcessLookupError):
            _write(f'{target}/cgroup.procs', pid.encode())


def _enable(folder: str, controllers: Iterable[str], sign: str = '+') -> None:
    """Enable controllers for the groups inside one, or disable them (`-`)."""
    text = ' '.join(f'{sign}{name}' for name in sorted(controllers))
    if text:
        _write(f'{folder}/cgroup.subtree_control', text.encode())


def _write(path: str, data: bytes) -> None:
    descriptor = os.open(path, os.O_WRONLY | os.O_CLOEXEC)
    try:
        os.write(descriptor, data)
    finally:
        os.close(descriptor)


def _read(path: str) -> str:
    try:
        with open(path, errors='surrogateescape') as file:
            return file.read()
    except OSError:
        return ''
