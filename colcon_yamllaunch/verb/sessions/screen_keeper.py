# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A process that looks after the terminal of the full screen.

It gives the terminal back should the full screen be killed, or be stopped by
SIGSTOP, and tells the full screen, by SIGHUP, when the terminal is gone.
"""

from contextlib import suppress
import os
import select
import signal
import termios
import time
from types import TracebackType
from typing import Any

from colcon_yamllaunch.common.process_scan import is_suspended

# ends what the library begins: keys of the kitty protocol, the mouse, pastes
# and changes of focus and size that are told, one drawing at once, no wraps,
# the other screen, no cursor; see xterm's ctlseqs
_RESTORE = (
    b'\x1b[<u\x1b[?1000;1002;1003;1006;1015;1016l\x1b[?2004l\x1b[?1004l'
    b'\x1b[?2048l\x1b[?2026l\x1b[0m\x1b[?7h\x1b[?1049l\x1b[?25h'
)
_ON, _OFF = b'+', b'-'
#: Seconds between two times that it tells of a terminal that is gone, or looks
#: whether the screen is stopped.
_INTERVAL = 0.5
_SIGNALS = (
    *(signal.SIGINT, signal.SIGQUIT, signal.SIGTERM, signal.SIGHUP),
    *(signal.SIGTSTP, signal.SIGTTOU, signal.SIGTTIN),
)


class ScreenKeeper:
    """
    Watches over the full screen as long as it is open.

    :param terminal: A descriptor of the terminal
    """

    def __init__(self, terminal: int) -> None:
        before = termios.tcgetattr(terminal)
        screen = os.getpid()
        reader, self._writer = os.pipe()
        self._pid = os.fork()
        if self._pid == 0:
            code = 1
            try:
                os.close(self._writer)
                _keep(reader, terminal, before, screen)
                code = 0
            finally:
                os._exit(code)
        os.close(reader)

    def take(self, *, is_shown: bool) -> None:
        """Take note that the screen is shown now, or is not."""
        with suppress(OSError):
            os.write(self._writer, _ON if is_shown else _OFF)

    def __enter__(self) -> 'ScreenKeeper':
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.take(is_shown=False)
        os.close(self._writer)
        with suppress(ChildProcessError):
            os.waitpid(self._pid, 0)


def _keep(reader: int, terminal: int, before: list[Any], screen: int) -> None:
    """Be that process: wait until the screen is gone."""
    # it is no part of the job, which others suspend, hang up and kill
    os.setpgid(0, 0)
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    last = _OFF
    poll = select.poll()
    poll.register(reader, select.POLLIN)
    # that it is hung up is told in any case
    poll.register(terminal, 0)
    while True:
        found = dict(poll.poll(1000 * _INTERVAL if last == _ON else None))
        if reader in found:
            if not (read := os.read(reader, 64)):
                break
            last = read[-1:]
        elif found:
            # who is no job of that terminal, or has given it to another
            # program, does not hear of it otherwise
            os.kill(screen, signal.SIGHUP)
            time.sleep(_INTERVAL)
        elif is_suspended(screen):
            # it takes the terminal anew when it goes on
            _restore(terminal, before)
            last = _OFF
    if last == _ON:
        _restore(terminal, before)


def _restore(terminal: int, before: list[Any]) -> None:
    """Make the terminal what it was before the screen."""
    with suppress(OSError, termios.error):
        os.write(terminal, _RESTORE)
        # with it, keys make no signals; if they do, a shell was faster
        if not termios.tcgetattr(terminal)[3] & termios.ISIG:
            termios.tcsetattr(terminal, termios.TCSANOW, before)
