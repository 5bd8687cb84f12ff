# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The title and bell of a terminal, which show the result of a change."""

from collections.abc import Mapping

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.writer import Writer

# XTWINOPS 22 and 23: the terminal keeps former titles on a stack
_SAVE = b'\x1b[22;0t'
_RESTORE = b'\x1b[23;0t'
# the values of TERM of terminals without a window
_WITHOUT_WINDOW = frozenset((None, '', 'dumb', 'linux', 'vt100', 'unknown'))

# what stands before the title during a change, and after it
_UNDER_WAY, _DONE, _FAILED = '…', '✓', '✗'


def has_window(environment: Mapping[str, str]) -> bool:
    """Return whether the terminal of `environment` may have a window."""
    return environment.get('TERM') not in _WITHOUT_WINDOW


class TerminalTitle:
    """
    Shows in the title of a window how the last change went.

    :param writer: Writes to the terminal
    :param title: The title of the launch, None to leave that of the window
    :param bell: Whether to ring when something fails
    """

    def __init__(
        self, writer: Writer, title: str | None, *, bell: bool
    ) -> None:
        self._writer = writer
        self._title = title
        self._bell = bell
        # the labels of processes that have failed since the change
        self._failed: set[str] = set()
        if title:
            writer.steer(_SAVE + _steering(title))

    def handle(self, event: events.Event) -> None:
        """Show the sign of an event."""
        match event:
            case events.Changed():
                self._failed.clear()
                self._show(_UNDER_WAY)
            case events.Started():
                self._failed.discard(event.process.label)
            case events.Exited(failed=True, asked=False):
                is_first = not self._failed
                self._failed.add(event.process.label)
                if is_first:
                    self._fail()
            case events.Watched(is_final=True) | events.Checked():
                if event.severity != 'INFO' and not self._failed:
                    self._fail()
                else:
                    self._show(_FAILED if self._failed else _DONE)

    def restore(self) -> None:
        """Give the window its former title back."""
        if self._title:
            self._writer.steer(_RESTORE)
            self._writer.flush()

    def _fail(self) -> None:
        self._show(_FAILED)
        if self._bell:
            self._writer.steer(b'\a')

    def _show(self, sign: str) -> None:
        if self._title:
            self._writer.steer(_steering(f'{sign} {self._title}'))


def _steering(title: str) -> bytes:
    shown = ''.join(c for c in title if c.isprintable())
    return f'\x1b]2;{shown}\x07'.encode(errors='replace')
