# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Signals to the launcher, as bytes on a pipe that the loop reads."""

from collections.abc import Iterable
from collections.abc import Iterator
from contextlib import contextmanager
import os
import signal

#: Those that stop the launch.
STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
#: Those that a shell holds and continues jobs with.
JOB_CONTROL = (signal.SIGTSTP, signal.SIGCONT)
#: Those that tell what else the loop reacts to.
OTHERS = (signal.SIGCHLD, signal.SIGWINCH)

# whoever ignores these for us means it, as nohup and a shell without job
# control do; a SIGINT that is sent all the same is meant, too
_RESPECTED = frozenset((signal.SIGHUP, signal.SIGTSTP))


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
    numbers: Iterable[signal.Signals] = (*STOPPING, *JOB_CONTROL, *OTHERS),
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
            signal.signal(number, _ignored)
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
    try:
        while data := os.read(reader, 4096):
            numbers.extend(data)
    except BlockingIOError:
        return numbers
    return numbers


def stop_ourselves() -> None:
    """
    Do what SIGTSTP does to a program that does not handle it.

    The system does not stop a process whose group is orphaned (POSIX): nobody
    could continue it, as there is no shell with job control.
    """
    handler = signal.signal(signal.SIGTSTP, signal.SIG_DFL)
    os.kill(os.getpid(), signal.SIGTSTP)
    signal.signal(signal.SIGTSTP, handler)


def _ignored(number: int, frame: object) -> None:
    """Let the wake-up descriptor do the work."""
