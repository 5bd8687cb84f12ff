# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The loop of a launch: descriptors, timers and signals.

It has the interface of an asyncio event loop, as far as a launch needs it.
asyncio itself would cost a part on another machine, which imports nothing of
colcon, 8 MB of memory and 30 ms at its start. It would also pass exceptions to
a handler instead of the caller, and it has no end of a turn.
"""

from collections import deque
from collections.abc import Callable
import heapq
from itertools import count
import select
import time
from typing import Any

from colcon_yamllaunch.engine import limits

# an error or a hangup is reported to readers and writers, as in `selectors`
_READABLE = ~select.EPOLLOUT
_WRITABLE = ~select.EPOLLIN
_GONE = select.EPOLLERR | select.EPOLLHUP


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
        self._after_turn: list[Callable[[], object]] = []
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
            self.call_soon(_do_nothing)

    def wake_at(self, when: float) -> TimerHandle:
        """Run a turn at the time `when`, if none runs then."""
        # to call `wake` would make another turn follow that one
        return self._timers.add(when, _do_nothing)

    def after_turn(self, callback: Callable[[], object]) -> None:
        """Call `callback` after all other callbacks of each turn."""
        self._after_turn.append(callback)

    def add_child(
        self,
        pid: int,
        ended: Callable[[int], object],
        suspended: Callable[[], object] = bool,
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
        self._readers[descriptor] = _bound(callback, args)
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
        self._writers[descriptor] = _bound(callback, args)
        self._update(descriptor)

    def remove_writer(self, descriptor: int) -> None:
        """Call nothing any more when `descriptor` is writable."""
        if self._writers.pop(descriptor, None) is not None:
            self._update(descriptor)

    def add_hangup_handler(
        self, descriptor: int, callback: Callable[..., object], *args: Any
    ) -> None:
        """
        Call `callback(*args)` when nobody has the other end of `descriptor`.

        :raises PermissionError: when it is an ordinary file
        """
        self._hangups[descriptor] = _bound(callback, args)
        self._update(descriptor)

    def remove(self, descriptor: int) -> None:
        """Call nothing any more for `descriptor`; before it is closed."""
        for callbacks in (self._readers, self._writers, self._hangups):
            callbacks.pop(descriptor, None)
        self._update(descriptor)

    def run_once(self) -> None:
        """
        Run one turn: wait until something is due, and call the callbacks.

        Those that are added meanwhile by :meth:`call_soon` have the next turn.
        """
        count = len(self._soon)
        for descriptor, mask in self._poll.poll(self._timeout()):
            if mask & _GONE and descriptor in self._hangups:
                self._hangups[descriptor]()
            if mask & _READABLE and descriptor in self._readers:
                self._readers[descriptor]()
            if mask & _WRITABLE and descriptor in self._writers:
                self._writers[descriptor]()
        self._timers.run_due(self.time())
        for _ in range(count):
            self._soon.popleft().run()
        for callback in self._after_turn:
            callback()

    def close(self) -> None:
        """Wait for nothing any more."""
        self._poll.close()

    def _timeout(self) -> float | None:
        if self._soon:
            return 0.0
        due = self._timers.next_due()
        if due is None:
            return None
        return min(max(0.0, due - self.time()), limits.LONGEST_WAIT)

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


def _bound(
    callback: Callable[..., object], args: tuple[Any, ...]
) -> Callable[[], object]:
    return (lambda: callback(*args)) if args else callback


def _do_nothing() -> None:
    """Let the loop run a turn."""
