# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The changes that are being handled, and the line that reports each result.

Each change is reported once: when its job is done and everything that it
restarts has started or failed to start. At most one change has a job; a later
one that needs a job takes over the earlier one.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from colcon_yamllaunch.engine import events

#: Seconds after the report of a change within which a failure of something
#: that it restarted is reported, too.
FAILURE_WINDOW = 10.0
#: Files that a line names before it only counts them.
_FILES_SHOWN = 3
_KINDS = {'new': 'added', 'deleted': 'deleted', 'again': 'saved again'}


@dataclass(slots=True, eq=False)
class PendingChange:
    """
    A change of one or more files, and its results so far.

    :param since: When it was first noticed, by the monotonic clock
    :param files: The names of the files, each with the kind of the change
    :param late: The labels to restart after the job, whatever it changes
    :param pending: The labels that have yet to start or end
    :param has_job: Whether the preparer has a job for it
    :param is_lost: Whether it needs the preparer, which has ended
    :param details: The output of its job
    :param kept: The machines that do not receive it, with the reasons
    :param suspects: Python files that may not compile
    :param broken: The labels that are not restarted because of such files
    :param crashed: The labels that failed after their start
    :param revised: The labels that have other settings, and run on
    """

    since: float
    files: Mapping[str, str]
    late: set[str] = field(default_factory=set)
    pending: set[str] = field(default_factory=set)
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
    revised: tuple[str, ...] = ()

    @property
    def is_done(self) -> bool:
        """Whether its result is known."""
        return not (self.has_job or self.pending)

    def add_restarted(self, labels: Iterable[str]) -> None:
        """Add labels that are being restarted."""
        labels = tuple(labels)
        self.pending.update(labels)
        self.restarted = _joined(self.restarted, labels)

    def take_over(self, other: 'PendingChange') -> None:
        """Become the change that `other` and this one make together."""
        self.files = {**other.files, **self.files}
        self.late |= other.late
        self.pending |= other.pending
        for name in ('restarted', 'failed', 'kept', 'suspects', 'crashed'):
            both = _joined(getattr(other, name), getattr(self, name))
            setattr(self, name, both)

    def line(self, what: str, now: float) -> str:
        """Return the line that reports `what` with the time that it took."""
        return f'{self.title}: {what} ({now - self.since:.2f} s)'

    @property
    def title(self) -> str:
        """Which files changed, and how."""
        names = list(self.files)
        kinds = {_KINDS.get(k, 'changed') for k in self.files.values()}
        what = kinds.pop() if len(kinds) == 1 else 'changed'
        if len(names) <= _FILES_SHOWN:
            return f'{", ".join(names)} {what}'
        first = ', '.join(names[: _FILES_SHOWN - 1])
        return f'{first} and {len(names) - _FILES_SHOWN + 1} more {what}'

    def result(self, now: float) -> events.ChangeReported | None:
        """Return the event that reports the result, if it is worth a line."""
        down = (*self.failed, *self.crashed)
        results = {
            'built': self.built,
            'stopped': self.stopped,
            'started': without(self.started, down),
            'restarted': without(self.restarted, down),
            'could not start': self.failed,
            'failed once started:': self.crashed,
            'not restarted, as Python code does not compile:': self.broken,
            'not sent to': self.kept,
            'other settings for': without(self.revised, down),
        }
        parts = [
            f'{what} {events.listed(names)}'
            for what, names in results.items()
            if names
        ]
        if self.is_lost:
            parts.append('what builds for --watch is gone')
        is_rewrite = set(self.files.values()) == {'again'}
        if is_rewrite and not (parts or self.details):
            return None
        what = ', '.join(parts) or 'nothing that runs differs'
        failed = bool((*down, *self.broken)) or self.is_lost
        text = self.line(what, now)
        return events.ChangeReported(text, failed=failed, details=self.details)


class PendingChanges(list[PendingChange]):
    """The changes that are not reported yet; it also has the last report."""

    def __init__(self) -> None:
        super().__init__()
        self._reported: PendingChange | None = None
        self._reported_at = 0.0

    @property
    def with_job(self) -> PendingChange | None:
        """The change that the preparer has a job for."""
        return next((change for change in self if change.has_job), None)

    @property
    def has_done(self) -> bool:
        """Whether :meth:`pop_done` returns any."""
        return any(change.is_done for change in self)

    def add(self, change: PendingChange) -> None:
        """Add a change; failures do not belong to the last report any more."""
        self.append(change)
        self._reported = None

    def pop_done(self, now: float) -> list[PendingChange]:
        """Return the changes to report, and remove them."""
        done = [change for change in self if change.is_done]
        self[:] = [change for change in self if not change.is_done]
        if done:
            self._reported, self._reported_at = done[-1], now
        return done

    def crashed(self, label: str, now: float) -> PendingChange | None:
        """
        Note that a process failed by itself.

        :return: The last reported change, if it has restarted the process
        """
        last = self._reported
        if now > self._reported_at + FAILURE_WINDOW:
            last = None
        concerned = [
            change
            for change in (*self, *([] if last is None else [last]))
            if label in (*change.restarted, *change.started)
            and label not in (*change.pending, *change.crashed)
        ]
        for change in concerned:
            change.crashed = (*change.crashed, label)
        return last if last in concerned else None

    def lose_preparer(self) -> None:
        """Note that there is no preparer any more."""
        for change in self:
            change.is_lost = change.is_lost or change.has_job
            change.has_job = False

    def started(self, label: str, *, failed: bool) -> list[PendingChange]:
        """
        Note that something started, or failed to start.

        :return: The changes that have restarted it
        """
        waiting = [c for c in self if label in c.pending]
        for change in waiting:
            change.pending.discard(label)
            if failed:
                change.failed = _joined(change.failed, (label,))
        return [c for c in waiting if label in c.restarted and not failed]

    def dropped(self, label: str) -> None:
        """Note that something is not part of the launch any more."""
        for change in self:
            change.pending.discard(label)

    def stopped(self, label: str) -> None:
        """Note that the user has stopped something."""
        for change in self:
            if label not in change.stopped:
                change.pending.discard(label)
                change.restarted = without(change.restarted, (label,))


def without(names: Iterable[str], others: Iterable[str]) -> tuple[str, ...]:
    """Return the names that are not among `others`, in their order."""
    excluded = set(others)
    return tuple(name for name in names if name not in excluded)


def _joined(first: tuple[str, ...], second: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys((*first, *second)))
