# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The rounds of watching: what was changed, what it waits for, what came of it.

Each change makes a round, and each round is told of once: when the worker is
done with it and all that it has started anew is up, or could not be started.
The worker is at one round at most; a later one that needs it takes that over.
"""

from collections.abc import Iterable
from collections.abc import Mapping
from dataclasses import dataclass
from dataclasses import field

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.watch.watch_lines import came_of
from colcon_yamllaunch.watch.watch_lines import happened

#: How long after it was told what came of a change that may turn out to be a
#: failure (seconds).
SETTLING = 10.0


@dataclass(slots=True, eq=False)
class Round:
    """
    A change, or several that count as one, and what has come of it.

    :param since: When it was noticed first, by the clock that never goes back
    :param files: What was changed, with how
    :param late: What is started anew when all is built, whatever that brings
    :param waits: The labels of what is to come up, or to end, yet
    :param has_job: Whether the worker is at it
    :param is_lost: Whether it would have to be, but is gone
    :param details: What a build or an evaluation has said, if anything
    :param kept: The machines that the change is not sent to, with the reasons
    :param suspects: Python files that may not compile
    :param broken: The labels of what is not restarted for that
    :param crashed: The labels of what has failed once it was started
    """

    since: float
    files: Mapping[str, str]
    late: set[str] = field(default_factory=set)
    waits: set[str] = field(default_factory=set)
    has_job: bool = False
    is_lost: bool = False
    details: str = ''
    built: tuple[str, ...] = ()
    started: tuple[str, ...] = ()
    stopped: tuple[str, ...] = ()
    restarted: tuple[str, ...] = ()
    failed: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()
    suspects: tuple[str, ...] = ()
    broken: tuple[str, ...] = ()
    crashed: tuple[str, ...] = ()

    @property
    def is_over(self) -> bool:
        """Whether it can be told what came of it."""
        return not (self.has_job or self.waits)

    @property
    def is_as_before(self) -> bool:
        """Whether all files were just saved as they were."""
        return set(self.files.values()) == {'again'}

    def add_restarted(self, labels: Iterable[str]) -> None:
        """Wait for what is started anew."""
        labels = tuple(labels)
        self.waits.update(labels)
        self.restarted = _joined(self.restarted, labels)

    def take_over(self, other: 'Round') -> None:
        """Do what another one is at, too, and tell of both together."""
        self.late |= other.late
        self.files = {**other.files, **self.files}
        self.waits |= other.waits
        self.restarted = _joined(other.restarted, self.restarted)
        self.failed = _joined(other.failed, self.failed)
        self.kept = _joined(other.kept, self.kept)
        self.suspects = _joined(other.suspects, self.suspects)
        self.crashed = _joined(other.crashed, self.crashed)

    def line(self, what: str, now: float) -> str:
        """Return the line that tells what came of it, and after how long."""
        return f'{happened(self.files)}: {what} ({now - self.since:.2f} s)'

    def outcome(self, now: float) -> events.Watched | None:
        """Tell what came of it, if that is worth a line."""
        down = (*self.failed, *self.crashed)
        outcome = {
            'built': self.built,
            'stopped': self.stopped,
            'started': without(self.started, down),
            'restarted': without(self.restarted, down),
            'could not start': self.failed,
            'failed once started:': self.crashed,
            'not restarted, as Python code does not compile:': self.broken,
            'not sent to': self.kept,
        }
        is_silent = self.is_as_before and not self.is_lost
        if is_silent and not any((*outcome.values(), self.details)):
            return None
        text = self.line(came_of(outcome, is_lost=self.is_lost), now)
        failed = bool((*down, *self.broken)) or self.is_lost
        return events.Watched(text, failed=failed, details=self.details)


class Rounds:
    """The rounds that have not been told of."""

    def __init__(self) -> None:
        self._rounds: list[Round] = []
        # the one that was told of last, and when
        self._told: tuple[Round, float] | None = None

    @property
    def with_job(self) -> Round | None:
        """The one that the worker is at."""
        return next((r for r in self._rounds if r.has_job), None)

    @property
    def are_over(self) -> bool:
        """Whether :meth:`pop_over` has some."""
        return any(r.is_over for r in self._rounds)

    def add(self, one: Round) -> None:
        """Begin a round."""
        self._rounds.append(one)
        self._told = None

    def remove(self, one: Round) -> None:
        """Have a round not told of, as it has been or is with another."""
        self._rounds.remove(one)

    def clear(self) -> None:
        """Forget all of them."""
        self._rounds.clear()

    def pop_over(self, now: float) -> list[Round]:
        """Return those that are to be told of now, and remove them."""
        over = [r for r in self._rounds if r.is_over]
        self._rounds = [r for r in self._rounds if not r.is_over]
        for one in over:
            self._told = one, now
        return over

    def crashed(self, label: str, now: float) -> Round | None:
        """
        Take note that a process failed by itself.

        :return: The round that it belongs to, if that was told of already
        """
        told, at = self._told or (None, 0.0)
        if now > at + SETTLING:
            told = None
        rounds = [*self._rounds, *([] if told is None else [told])]
        concerned = [
            one
            for one in rounds
            if label in (*one.restarted, *one.started)
            and label not in (*one.waits, *one.crashed)
        ]
        for one in concerned:
            one.crashed = (*one.crashed, label)
        return told if told in concerned else None

    def lose_worker(self) -> None:
        """Take into account that there is no worker any more."""
        for one in self._rounds:
            one.is_lost = one.is_lost or one.has_job
            one.has_job = False

    def came_up(self, label: str, *, failed: bool) -> list[Round]:
        """
        Take note that something was started, or could not be.

        :return: Those that have restarted it
        """
        waiting = [r for r in self._rounds if label in r.waits]
        for one in waiting:
            one.waits.discard(label)
            if failed:
                one.failed = _joined(one.failed, (label,))
        return [r for r in waiting if label in r.restarted and not failed]

    def gone(self, label: str) -> None:
        """Take note that something was taken out of the launch."""
        for one in self._rounds:
            one.waits.discard(label)

    def stopped(self, label: str) -> None:
        """Take note that the user has stopped something."""
        for one in self._rounds:
            if label not in one.stopped:
                one.waits.discard(label)
                one.restarted = without(one.restarted, (label,))


def without(names: Iterable[str], others: Iterable[str]) -> tuple[str, ...]:
    """Return the names that are not among others, in their order."""
    left = set(others)
    return tuple(name for name in names if name not in left)


def _joined(first: tuple[str, ...], second: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys((*first, *second)))
