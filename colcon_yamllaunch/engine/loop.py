# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The loop of a launch: descriptors, timers, signals and child processes.

It has the interface of an asyncio event loop, as far as a launch needs it.
asyncio itself would cost a part on another machine, which imports nothing of
colcon, 8 MB of memory and 30 ms at its start. It would also pass exceptions to
a handler instead of the caller, and it has no end of a turn.

Signals arrive as bytes on a pipe, see :func:`caught`. Only the given children
are reaped: those of other code are left alone. If one of these is reported
first, ours are checked one by one.
"""

from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
import heapq
from itertools import count
import os
import select
import signal
import time
from typing import Any

from colcon_yamllaunch.engine import limits

#: The signals that stop the launch.
STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_CAUGHT = (
    *STOPPING,
    # with which a shell suspends and continues jobs
    *(signal.SIGTSTP, signal.SIGCONT),
    *(signal.SIGCHLD, signal.SIGWINCH),
)
# these stay ignored if a parent ignored them, as nohup and a shell without job
# control do; an ignored SIGINT is caught all the same
_RESPECTED = frozenset((signal.SIGHUP, signal.SIGTSTP))

_PEEK = os.WNOHANG | os.WNOWAIT
_SUSPENDED = os.WSTOPPED | os.WCONTINUED

# an error or a hangup is reported to readers and writers, as in `selectors`
_READABLE = ~select.EPOLLOUT
_WRITABLE = ~select.EPOLLIN
_GONE = select.EPOLLERR | select.EPOLLHUP


def do_nothing(*_: object) -> None:
    """Do nothing, as the callback of what nobody waits for."""


class TimerHandle:
    """A callback that is called at a time, unless it is cancelled."""

    __slots__ = ('_args', '_callback', '_order', '_when')

    def __init__(
        self,
        when: float,
        order: int,
        callback: Callable[..., object],
        args: tuple[Any, ...],
    ) -> None:
        self._when = when
        self._order = order
        self._callback: Callable[..., object] | None = callback
        self._args = args

    def __lt__(self, other: 'TimerHandle') -> bool:
        return (self._when, self._order) < (other._when, other._order)

    def when(self) -> float:
        """Return the time of the callback, by the clock of the loop."""
        return self._when

    def cancel(self) -> None:
        """Do not call the callback."""
        self._callback = None
        self._args = ()

    def cancelled(self) -> bool:
        """Return whether the callback was called or cancelled."""
        return self._callback is None

    def run(self) -> None:
        """Call the callback, unless it was called or cancelled."""
        callback, args = self._callback, self._args
        if callback is not None:
            self.cancel()
            callback(*args)


class Timers:
    """Callbacks in the order of their times; equal times keep their order."""

    def __init__(self) -> None:
        self._heap: list[TimerHandle] = []
        self._orders = count()

    def add(
        self, when: float, callback: Callable[..., object], *args: Any
    ) -> TimerHandle:
        """Call `callback` once :meth:`run_due` gets `when` or a later time."""
        handle = TimerHandle(when, next(self._orders), callback, args)
        heapq.heappush(self._heap, handle)
        return handle

    def run_due(self, now: float) -> None:
        """Call the callbacks whose time has come."""
        while self._heap and self._heap[0].when() <= now:
            heapq.heappop(self._heap).run()

    def next_due(self) -> float | None:
        """Return the time of the next callback, or None."""
        while self._heap and self._heap[0].cancelled():
            heapq.heappop(self._heap)
        return self._heap[0].when() if self._heap else None

    def pending(self) -> list[TimerHandle]:
        """Return the handles of all callbacks that are still to be called."""
        return [handle for handle in self._heap if not handle.cancelled()]


class Loop:
    """
    Waits for descriptors, times and signals, and calls callbacks.

    No callback may block. A callback of a descriptor may be called although
    nothing is ready, as the descriptor's number may have been reused in the
    same turn. An exception of a callback ends :meth:`run_once`.

    :param clock: Returns seconds; it never goes back
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        #: The time by which timers are called.
        self.time = clock
        self._poll = select.epoll()
        self._readers: dict[int, Callable[[], object]] = {}
        self._writers: dict[int, Callable[[], object]] = {}
        self._hangups: dict[int, Callable[[], object]] = {}
        self._masks: dict[int, int] = {}
        self._timers = Timers()
        self._soon: deque[TimerHandle] = deque()
        #: The child processes that serve the launch, by process ID: what to
        #: call with the wait status of one that was reaped, and what to call
        #: when one is suspended.
        self.children: dict[
            int, tuple[Callable[[int], object], Callable[[], object]]
        ] = {}

    def call_at(
        self, when: float, callback: Callable[..., object], *args: Any
    ) -> TimerHandle:
        """Call `callback(*args)` at the time `when`."""
        return self._timers.add(when, callback, *args)

    def call_later(
        self, delay: float, callback: Callable[..., object], *args: Any
    ) -> TimerHandle:
        """Call `callback(*args)` in `delay` seconds."""
        return self._timers.add(self.time() + delay, callback, *args)

    def call_soon(
        self, callback: Callable[..., object], *args: Any
    ) -> TimerHandle:
        """Call `callback(*args)` in the next turn, which begins at once."""
        handle = TimerHandle(self.time(), 0, callback, args)
        self._soon.append(handle)
        return handle

    def wake(self) -> None:
        """Begin the next turn at once."""
        if not self._soon:
            self.call_soon(do_nothing)

    def wake_at(self, when: float) -> TimerHandle:
        """Run a turn at the time `when`, if none runs then."""
        # to call `wake` would make another turn follow that one
        return self._timers.add(when, do_nothing)

    def add_child(
        self,
        pid: int,
        ended: Callable[[int], object],
        suspended: Callable[[], object] = do_nothing,
    ) -> None:
        """
        Call `ended` with the wait status of a child process.

        The engine reaps it, and calls `suspended` when it is suspended.
        """
        self.children[pid] = ended, suspended

    def remove_child(self, pid: int) -> None:
        """Call nothing for a child process, as the caller reaps it."""
        self.children.pop(pid, None)

    def add_reader(
        self, descriptor: int, callback: Callable[..., object], *args: Any
    ) -> None:
        """
        Call `callback(*args)` when `descriptor` is readable or at its end.

        :raises PermissionError: when it is an ordinary file
        """
        self._readers[descriptor] = partial(callback, *args)
        self._update(descriptor)

    def remove_reader(self, descriptor: int) -> None:
        """Call nothing any more when `descriptor` is readable."""
        if self._readers.pop(descriptor, None) is not None:
            self._update(descriptor)

    def add_writer(
        self, descriptor: int, callback: Callable[..., object], *args: Any
    ) -> None:
        """
        Call `callback(*args)` when `descriptor` is writable or broken.

        :raises PermissionError: when it is an ordinary file
        """
        self._writers[descriptor] = partial(callback, *args)
        self._update(descriptor)

    def remove_writer(self, descriptor: int) -> None:
        """Call nothing any more when `descriptor` is writable."""
        if self._writers.pop(descriptor, None) is not None:
            self._update(descriptor)

    def add_hangup_handler(
        self, descriptor: int, callback: Callable[..., object], *args: Any
    ) -> None:
        """
        Call `callback(*args)` when the other end of `descriptor` is closed.

        :raises PermissionError: when it is an ordinary file
        """
        self._hangups[descriptor] = partial(callback, *args)
        self._update(descriptor)

    def remove(self, descriptor: int) -> None:
        """Call nothing any more for `descriptor`; before it is closed."""
        for callbacks in (self._readers, self._writers, self._hangups):
            callbacks.pop(descriptor, None)
        self._update(descriptor)

    def run_once(self, until: float | None = None) -> None:
        """
        Run one turn: wait until something is due, and call the callbacks.

        Those that are added meanwhile by :meth:`call_soon` have the next turn.

        :param until: When to stop waiting, by the clock of the loop
        """
        count = len(self._soon)
        for descriptor, mask in self._poll.poll(self._timeout(until)):
            if mask & _GONE and descriptor in self._hangups:
                self._hangups[descriptor]()
            if mask & _READABLE and descriptor in self._readers:
                self._readers[descriptor]()
            if mask & _WRITABLE and descriptor in self._writers:
                self._writers[descriptor]()
        self._timers.run_due(self.time())
        for _ in range(count):
            self._soon.popleft().run()

    def close(self) -> None:
        """Wait for nothing any more."""
        self._poll.close()

    def _timeout(self, until: float | None = None) -> float | None:
        if self._soon:
            return 0.0
        dues = [d for d in (self._timers.next_due(), until) if d is not None]
        if not dues:
            return None
        return min(max(0.0, min(dues) - self.time()), limits.LONGEST_LOOP_WAIT)

    def _update(self, descriptor: int) -> None:
        mask = select.EPOLLIN * (descriptor in self._readers)
        mask |= select.EPOLLOUT * (descriptor in self._writers)
        known = self._masks.get(descriptor)
        if not mask and descriptor not in self._hangups:
            if self._masks.pop(descriptor, None) is not None:
                self._poll.unregister(descriptor)
        elif known is None:
            self._masks[descriptor] = mask
            try:
                self._poll.register(descriptor, mask)
            except OSError:
                del self._masks[descriptor]
                self.remove(descriptor)
                raise
        elif mask != known:
            self._poll.modify(descriptor, mask)
            self._masks[descriptor] = mask


def accept_signals() -> None:
    """
    Unblock all signals, and notice the end of children.

    A parent may have blocked signals or ignored SIGCHLD; both are inherited.
    An ignored SIGCHLD hides exit codes. Shells unblock SIGCHLD, too.
    """
    signal.pthread_sigmask(signal.SIG_SETMASK, ())
    if signal.getsignal(signal.SIGCHLD) == signal.SIG_IGN:
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)


@contextmanager
def caught(
    numbers: Iterable[signal.Signals] = _CAUGHT,
) -> Iterator[int]:
    """
    Catch signals, and give the descriptor where each arrives as a byte.

    Works in the main thread only, as Python handles signals there.
    """
    reader, writer = os.pipe()
    os.set_blocking(reader, False)
    os.set_blocking(writer, False)
    wakeup = signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    before = {}
    try:
        for number in numbers:
            handler = signal.getsignal(number)
            if handler == signal.SIG_IGN and number in _RESPECTED:
                continue
            before[number] = handler
            # the wake-up descriptor reports the signal
            signal.signal(number, do_nothing)
        yield reader
    finally:
        for number, handler in before.items():
            signal.signal(
                number, signal.SIG_DFL if handler is None else handler
            )
        signal.set_wakeup_fd(wakeup)
        os.close(reader)
        os.close(writer)


def received(reader: int) -> list[int]:
    """Return the signals that arrived since the last call."""
    numbers: list[int] = []
    with suppress(BlockingIOError):
        while data := os.read(reader, 4096):
            numbers.extend(data)
    return numbers


def suspend_ourselves() -> None:
    """
    Do what SIGTSTP does to a program that does not handle it.

    The system does not stop a process whose group is orphaned (POSIX), as no
    shell with job control could continue it.
    """
    handler = signal.signal(signal.SIGTSTP, signal.SIG_DFL)
    os.kill(os.getpid(), signal.SIGTSTP)
    signal.signal(signal.SIGTSTP, handler)


def ended_children(ours: Collection[int]) -> Iterator[tuple[int, int]]:
    """Return the children that ended, with what :func:`os.waitpid` says."""
    for result in _reported(ours, os.WEXITED):
        yield result.si_pid, os.waitpid(result.si_pid, 0)[1]


def suspended_children(
    ours: Collection[int],
) -> Iterator[tuple[int, int | None]]:
    """Return the children that a signal suspended, with it, or that go on."""
    for result in _reported(ours, _SUSPENDED):
        # taken note of, it is not reported again
        os.waitid(os.P_PID, result.si_pid, _SUSPENDED | os.WNOHANG)
        goes_on = result.si_code == os.CLD_CONTINUED
        yield result.si_pid, None if goes_on else result.si_status


def has_ended(pid: int) -> bool:
    """Return whether a child has ended; it is reaped if so."""
    try:
        return os.waitpid(pid, os.WNOHANG)[0] == pid
    except ChildProcessError:
        return True


def _reported(ours: Collection[int], what: int) -> Iterator[os.waitid_result]:
    while True:
        result = _look(os.P_ALL, 0, what)
        if result is None:
            return
        if result.si_pid not in ours:
            break
        yield result
    for pid in ours:
        result = _look(os.P_PID, pid, what)
        if result is not None:
            yield result


def _look(kind: int, pid: int, what: int) -> os.waitid_result | None:
    try:
        return os.waitid(kind, pid, what | _PEEK)
    except ChildProcessError:
        return None


def readable(
    descriptors: Iterable[int], seconds: float | None = None
) -> list[int]:
    """
    Wait until there is something to read, and return where.

    The end of a file counts. `select` refuses descriptors from 1024 on, and a
    shell may hand on that many (select(2), FD_SETSIZE).

    :param seconds: How long to wait at most, None for ever
    """
    poll = select.poll()
    for descriptor in descriptors:
        poll.register(descriptor, select.POLLIN)
    found = poll.poll(None if seconds is None else seconds * 1000)
    return [descriptor for descriptor, _ in found]
