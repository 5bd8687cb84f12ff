# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Programs in a terminal of their own, typed at as users do."""

import contextlib
import fcntl
import os
from pathlib import Path
import select
import signal
import struct
import subprocess
import termios
import time
from typing import Any

#: Seconds; a loaded machine needs some.
DEADLINE = 120


class Terminal:
    """
    A terminal, and the program that has it for its session.

    :param argv: The program
    :param cwd: Where it runs
    :param environment: Its environment
    :param columns: How wide it is; 0 if that is not known
    """

    def __init__(
        self,
        argv: list[str],
        cwd: Path,
        environment: dict[str, str],
        columns: int = 0,
    ) -> None:
        self._ours, self._theirs = os.openpty()
        size = struct.pack('HHHH', 0, columns, 0, 0)
        fcntl.ioctl(self._theirs, termios.TIOCSWINSZ, size)
        #: The modes before anything ran.
        self.modes_before = self.modes()
        self._seen = b''
        self.process = subprocess.Popen(
            argv,
            cwd=cwd,
            env=environment,
            stdin=self._theirs,
            stdout=self._theirs,
            stderr=self._theirs,
            start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
        )

    @property
    def screen(self) -> str:
        """All that has been shown."""
        while select.select([self._ours], [], [], 0)[0]:
            self._seen += os.read(self._ours, 1 << 16)
        return self._seen.decode(errors='replace')

    def shows(self, text: str, times: int = 1) -> 'Terminal':
        """Wait until a text has been shown."""
        deadline = time.monotonic() + DEADLINE
        while self.screen.count(text) < times:
            assert time.monotonic() < deadline, f'{text!r}: {self.screen}'
            time.sleep(0.02)
        return self

    def types(self, keys: str) -> 'Terminal':
        """Type keys."""
        os.write(self._ours, keys.encode())
        return self

    def modes(self) -> list[Any]:
        """Return the modes of the terminal."""
        return termios.tcgetattr(self._theirs)

    def ends(self) -> int:
        """Wait for the end of the program."""
        deadline = time.monotonic() + DEADLINE
        while self.process.poll() is None:
            # who writes at a terminal waits for it to be read
            screen = self.screen
            assert time.monotonic() < deadline, screen
            time.sleep(0.02)
        assert 'Traceback' not in self.screen, self.screen
        return self.process.wait()

    def hangs_up(self) -> int:
        """Close the terminal, and wait for the end of the program."""
        os.close(self._ours)
        self._ours = -1
        return self.process.wait(DEADLINE)

    def close(self) -> None:
        """Leave nothing behind, whatever the test did."""
        if self.process.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
        if self._ours != -1:
            os.close(self._ours)
        os.close(self._theirs)
