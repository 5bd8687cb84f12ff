# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The steps by which processes are stopped: SIGINT, SIGTERM, SIGKILL.

The launcher and the guard take the same steps. This module is part of the
guard and imports little.
"""

from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Mapping
import math
import os
import signal

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.process_scan import Member

#: The signals in the order in which they are sent.
STEPS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)


@dataclass(frozen=True, slots=True)
class Timeouts:
    """
    How long a process may take to stop.

    :param sigterm: Seconds from SIGINT to SIGTERM
    :param sigkill: Seconds from SIGTERM to SIGKILL
    """

    sigterm: float
    sigkill: float


@dataclass(frozen=True, slots=True)
class Order:
    """
    A signal to be sent.

    :param number: The process of the plan that is meant
    :param target: A process group, or a process that is in none of them
    :param signal: The signal
    """

    number: int
    target: int | Member
    signal: signal.Signals


class Stopping:
    """
    Who is to be sent which signal, and when.

    :param timeouts: For each process of the plan its time-outs; a number
      that is not in it has the longest of them
    :param now: When stopping begins, in seconds of any clock
    """

    def __init__(self, timeouts: Mapping[int, Timeouts], now: float) -> None:
        self._timeouts = dict(timeouts)
        self._timeouts.setdefault(
            -1,
            Timeouts(
                max((t.sigterm for t in timeouts.values()), default=0.0),
                max((t.sigkill for t in timeouts.values()), default=0.0),
            ),
        )
        self._steps = dict.fromkeys(self._timeouts, 0)
        self._deadlines = {
            number: now + t.sigterm for number, t in self._timeouts.items()
        }
        self._sent: dict[int | Member, int] = {}

    def advance(self, now: float) -> None:
        """Take the steps that are due."""
        for number, deadline in self._deadlines.items():
            if deadline <= now:
                self._step(number, now)

    def hurry(self, numbers: Collection[int], now: float) -> None:
        """Take the next step for some processes at once."""
        for number in numbers:
            self._step(self._known(number), now)

    def orders(
        self, groups: Mapping[int, int], strays: Iterable[Member]
    ) -> list[Order]:
        """
        Return the signals that have not been sent yet.

        :param groups: The process groups that run, with their numbers
        :param strays: The processes besides those whose leader still runs
        """
        orders = []
        for group, number in groups.items():
            step = self._steps[self._known(number)]
            if self._sent.get(group, -1) < step:
                self._sent[group] = step
                orders.append(Order(number, group, STEPS[step]))
        for member in strays:
            step = self._steps[self._known(member.number)]
            # what its group was sent reached it, too
            sent = max(
                self._sent.get(member, -1), self._sent.get(member.group, -1)
            )
            if sent < step:
                self._sent[member] = step
                orders.append(Order(member.number, member, STEPS[step]))
        return orders

    def next_deadline(self, numbers: Iterable[int]) -> float:
        """Return when the next step is due for some, or infinity."""
        return min(
            (self._deadlines[self._known(n)] for n in numbers),
            default=math.inf,
        )

    def latest_signal(self, numbers: Iterable[int]) -> signal.Signals:
        """Return the furthest step that any of these has come to."""
        return STEPS[
            max((self._steps[self._known(n)] for n in numbers), default=0)
        ]

    def is_final(self, numbers: Iterable[int]) -> bool:
        """Tell whether all of these have been sent the last signal."""
        last = len(STEPS) - 1
        return all(self._steps[self._known(n)] == last for n in numbers)

    def _known(self, number: int) -> int:
        return number if number in self._steps else -1

    def _step(self, number: int, now: float) -> None:
        step = min(self._steps[number] + 1, len(STEPS) - 1)
        self._steps[number] = step
        self._deadlines[number] = (
            now + self._timeouts[number].sigkill
            if STEPS[step] == signal.SIGTERM
            else math.inf
        )


def send(order: Order) -> bool:
    """
    Send a signal.

    :returns: Whether there was somebody to send it to
    """
    # a stopped process takes a signal only when it is continued
    wake = order.signal != signal.SIGKILL
    try:
        if isinstance(order.target, Member):
            os.kill(order.target.pid, order.signal)
            if wake:
                os.kill(order.target.pid, signal.SIGCONT)
        else:
            os.killpg(order.target, order.signal)
            if wake:
                os.killpg(order.target, signal.SIGCONT)
    except (ProcessLookupError, PermissionError):
        return False
    return True
