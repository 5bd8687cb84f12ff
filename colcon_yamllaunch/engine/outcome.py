# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How a process ended, and what that means."""

import os
import signal

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.plan.plan import Process

#: Signals that end a process on request. systemd and a closed terminal send
#: them to a whole session, and so to our processes, too.
STOP_SIGNALS = frozenset(
    (signal.SIGINT, signal.SIGTERM, signal.SIGKILL, signal.SIGHUP)
)


@dataclass(frozen=True, slots=True)
class Outcome:
    """
    How a process ended.

    :param code: Its exit code, or None when a signal ended it
    :param signal: The number of that signal, or None
    :param core_dumped: Whether the system wrote a core dump
    :param lost: The machine that it was lost with, if its end is not known;
      else empty
    :param limit: The limit that it exceeded, as a part of a sentence; else
      empty
    """

    code: int | None = None
    signal: int | None = None
    core_dumped: bool = False
    lost: str = ''
    limit: str = ''

    @staticmethod
    def from_status(status: int) -> 'Outcome':
        """Read what :func:`os.waitpid` returned."""
        if os.WIFSIGNALED(status):
            return Outcome(
                signal=os.WTERMSIG(status), core_dumped=os.WCOREDUMP(status)
            )
        return Outcome(code=os.WEXITSTATUS(status))

    def __str__(self) -> str:
        if self.lost:
            return f'lost with {self.lost}'
        if self.limit and self.signal == signal.SIGKILL:
            return f'killed: {self.limit}'
        reason = f' ({self.limit})' if self.limit else ''
        if self.signal is None:
            return f'exited with code {self.code}{reason}'
        text = f'died by {signal_name(self.signal)}'
        meaning = signal.strsignal(self.signal)
        if meaning:
            text += f' ({meaning.lower()})'
        text += reason
        return f'{text}, core dumped' if self.core_dumped else text


def ending_of(outcome: Outcome, asked: bool) -> str:
    """
    Return how a process ended, as a part of a sentence.

    :param asked: Whether it had been asked to stop
    """
    if outcome.code == 0:
        return 'finished'
    if asked and outcome.signal == signal.SIGINT:
        # most processes that are asked to stop end by SIGINT
        return 'stopped'
    if asked and not is_failure(outcome, asked):
        return f'stopped, {outcome}'
    return str(outcome)


def signal_name(number: int) -> str:
    """Return the name of a signal, as SIGSEGV."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return f'signal {number}'


def is_failure(outcome: Outcome, asked: bool) -> bool:
    """
    Return whether a process failed.

    :param asked: Whether it had been asked to stop; then any exit code is
      fine, and so is the end by one of :data:`STOP_SIGNALS`, but a crash on
      the way out is not
    """
    if outcome.lost:
        return True
    if outcome.signal is None:
        return outcome.code != 0 and not asked
    return not (asked and outcome.signal in STOP_SIGNALS)


def delay_of_respawn(process: Process, quick_ends: int) -> float:
    """
    Return after how many seconds a process is started again.

    That is what the launch file says. Where it says nothing, or 0, a process
    that ends at once time after time has to wait longer and longer, so that
    it does not keep the machine busy.

    :param quick_ends: How often in a row it ended at once
    """
    excess = quick_ends - limits.QUICK_ENDS_WITHOUT_PAUSE
    if process.respawn_delay > 0 or excess <= 0:
        return process.respawn_delay
    # no more powers than the longest pause needs
    pause = limits.SHORTEST_RESTART_PAUSE * 2.0 ** min(excess - 1, 10)
    return min(pause, limits.LONGEST_RESTART_PAUSE)
