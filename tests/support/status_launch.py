# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A launch in a terminal, with the state of all below the output."""

from collections.abc import Callable
import fcntl
import os
import termios
from typing import Any

from support.virtual_screen import VirtualScreen

#: How the line begins that tells what the keys mean.
HINT = ' ? help'


class StatusLaunch:
    """A launch that has a terminal for itself, or the shell that runs it."""

    def __init__(
        self,
        make: Callable[..., Any],
        size: tuple[int, int],
        entries: tuple[dict[str, Any], ...],
        shell: tuple[str, ...],
        settings: dict[str, Any],
    ) -> None:
        self.screen = VirtualScreen(*size)
        self.modes = termios.tcgetattr(self.screen.theirs)
        terminal = self.screen.theirs
        environment = {
            'TERM': 'xterm',
            'PYTHONIOENCODING': 'utf-8',
            **settings.pop('variables', {}),
        }
        self.launch = make(
            *entries,
            color=True,
            status=True,
            environment=environment,
            popen={
                'stdin': settings.pop('stdin', terminal),
                'stdout': terminal,
                'stderr': terminal,
                'preexec_fn': lambda: fcntl.ioctl(1, termios.TIOCSCTTY, 0),
            },
            shell=shell,
            **settings,
        )

    def types(self, keys: str) -> 'StatusLaunch':
        """Type at the terminal."""
        os.write(self.screen.ours, keys.encode())
        return self

    def shows(self, *texts: str) -> list[str]:
        """
        Wait until the last lines begin with some texts, and return all.

        What the keys mean is left out.
        """

        def are_there(lines: list[str]) -> bool:
            lines = [line for line in lines if not line.startswith(HINT)]
            return len(lines) >= len(texts) and all(
                line.startswith(text)
                for line, text in zip(lines[-len(texts) :], texts, strict=True)
            )

        return self.screen.shows(are_there)

    def ends(self) -> int:
        """Wait for the end; the terminal is as it was."""
        # who writes at a terminal waits for it to be read
        self.screen.shows(lambda _: self.launch.popen.poll() is not None)
        assert termios.tcgetattr(self.screen.theirs) == self.modes
        return int(self.launch.popen.wait())
