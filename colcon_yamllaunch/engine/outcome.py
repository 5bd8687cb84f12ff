# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How a process ended, and what that means."""

import os
import signal

from colcon_yamllaunch.common.frozen import dataclass

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
