# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A pager that runs in the terminal of a launch as its foreground job."""

from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import suppress
import os
from pathlib import Path
import shlex
import shutil
import signal
import time

from colcon_yamllaunch.engine import events

#: The variable with the program, as all have it (environ(7)).
PAGER = 'PAGER'
#: Seconds that it gets to end when the launch does.
END_TIMEOUT = 1.0
_USUAL = ('less', 'more')
#: The options of `less`: colours, and the end of the log first.
LESS = '-R +G'
#: Bytes of output that are kept meanwhile, and those that a piece of it counts
#: for beside its own.
KEPT = 256 * 1024
PIECE = 256


class Pager:
    """
    The pager, which shows a file until the user quits it.

    :param terminal: A descriptor of the terminal, which is ours
    :raises OSError: when there is no such program
    :raises ValueError: when :data:`PAGER` is no command line
    """

    def __init__(
        self, path: Path, terminal: int, environment: Mapping[str, str]
    ) -> None:
        self._terminal = terminal
        argv = [*command(environment), str(path)]
        #: Its process, which is the leader of its group, too.
        self.pid = os.posix_spawnp(
            argv[0],
            argv,
            {'LESS': LESS, **environment},
            setpgroup=0,
            setsigdef=(signal.SIGPIPE, signal.SIGTSTP, signal.SIGHUP),
        )
        self._set_foreground(self.pid)
        # it is stopped if it used the terminal before it got it
        with suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGCONT)

    def quit(self) -> None:
        """Ask it to end; it restores the terminal."""
        with suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGTERM)
            os.killpg(self.pid, signal.SIGCONT)

    def end(self) -> None:
        """End it, by SIGKILL if necessary, and wait for that."""
        self.quit()
        deadline = time.monotonic() + END_TIMEOUT
        while not os.waitpid(self.pid, os.WNOHANG)[0]:
            if time.monotonic() > deadline:
                os.killpg(self.pid, signal.SIGKILL)
                os.waitpid(self.pid, 0)
                return
            time.sleep(0.01)

    def reclaim(self) -> None:
        """Make the launch the foreground job again."""
        self._set_foreground(os.getpgrp())

    def _set_foreground(self, group: int) -> None:
        # a background job that calls tcsetpgrp(3) gets SIGTTOU otherwise
        before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGTTOU,))
        with suppress(OSError):
            os.tcsetpgrp(self._terminal, group)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class PagedOutput:
    """
    The events while a pager has the terminal, which are shown after it.

    Of much output, the end is kept.
    """

    def __init__(self, pager: Pager) -> None:
        self.pager = pager
        #: Lines that are not kept.
        self.lost = 0
        self._held: deque[tuple[float, events.Event]] = deque()
        self._size = 0

    def hold(self, event: events.Event) -> None:
        """Keep an event."""
        self._held.append((time.time(), event))
        if isinstance(event, events.Output):
            self._size += PIECE + len(event.data)
        while self._size > KEPT:
            self._drop_oldest()

    def held(self) -> Iterator[tuple[float, events.Event]]:
        """Iterate over the events, with the time of each."""
        while self._held:
            yield self._held.popleft()

    def _drop_oldest(self) -> None:
        for index, (_, event) in enumerate(self._held):
            if isinstance(event, events.Output):
                del self._held[index]
                self._size -= PIECE + len(event.data)
                self.lost += event.data.count(b'\n')
                return


def command(environment: Mapping[str, str]) -> list[str]:
    """
    Return the command line that shows files.

    :raises ValueError: when :data:`PAGER` is no command line
    """
    words = shlex.split(environment.get(PAGER, ''))
    if words:
        return words
    path = environment.get('PATH', os.defpath)
    found = (name for name in _USUAL if shutil.which(name, path=path))
    return [next(found, 'cat')]
