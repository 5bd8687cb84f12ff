# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The connection of the keyboard to one process of the launch."""

import termios

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.observers.screen import Screen
from colcon_yamllaunch.terminal.keyboard import ESCAPE_NAME
from colcon_yamllaunch.terminal.keys import Keys

_HINT = f'attached: {ESCAPE_NAME} goes back'


class Attachment:
    """
    The connection of the keyboard and the screen to a process.

    A process that reads lines gets lines, which are edited below the output;
    one that has its terminal in raw mode gets each key. When it is restarted,
    the connection is restored.

    :param label: The process to connect when it starts; None for none
    """

    def __init__(self, keys: Keys, screen: Screen, label: str | None) -> None:
        self._keys = keys
        self._screen = screen
        self._engine: Engine | None = None
        self._wanted = label
        self._started: dict[str, events.Started] = {}

    def connect(self, engine: Engine) -> None:
        """Use an engine, before it runs."""
        self._engine = engine

    def close(self) -> None:
        """Disconnect."""
        self._end()
        self._engine = None

    @property
    def is_wanted(self) -> bool:
        """Whether a process is connected, or will be when it starts."""
        return self._wanted is not None or self._keys.attached is not None

    def shows(self, label: str) -> bool:
        """Return whether the output of a process is shown as it comes."""
        return self._keys.attached == label

    def before(self, event: events.Event) -> None:
        """Handle an event before it is shown."""
        if isinstance(event, events.Exited):
            self._started.pop(event.process.label, None)
            if self.shows(event.process.label):
                self._end()

    def after(self, event: events.Event) -> None:
        """Handle an event after it was shown."""
        if not isinstance(event, events.Started):
            return
        label = event.process.label
        self._started[label] = event
        if label == self._wanted:
            self._wanted = None
            self.attach(label)

    def await_start(self, label: str) -> None:
        """Connect a process when it starts next."""
        self._wanted = label

    def attach(self, label: str) -> bool:
        """Connect a process, and return whether that is possible."""
        engine, started = self._engine, self._started.get(label)
        if engine is None or started is None:
            return False
        if not engine.terminals.has_keyboard(label):
            return False
        self._wanted = label
        self._keys.attach(label)
        engine.tell(events.Attached(started.process, _HINT))
        engine.terminals.add_sink(label, self._show)
        self.read_modes()
        return True

    def detached(self, label: str) -> None:
        """Disconnect, as the user pressed the escape key."""
        self._wanted = None
        self._end(label)
        started = self._started.get(label)
        if started is not None and self._engine is not None:
            self._engine.tell(events.Detached(started.process))

    def type(self, keys: bytes) -> None:
        """Send what was typed to the process."""
        label = self._keys.attached
        if label is not None and self._engine is not None:
            self._engine.terminals.type(label, keys)

    def read_modes(self) -> None:
        """Read whether the process takes lines or keys now."""
        label = self._keys.attached
        if label is None or self._engine is None:
            return
        local = self._engine.terminals.input_modes(label)
        if local is None:
            return
        is_raw = not local & termios.ICANON
        is_secret = not local & termios.ECHO
        self._keys.attach(label, is_raw=is_raw, is_secret=is_secret)

    def _show(self, stream: events.Stream, data: bytes) -> None:
        self.read_modes()
        self._screen.show_raw((self._keys.attached, stream), data)

    def _end(self, label: str | None = None) -> None:
        label = label or self._keys.attached
        if label is not None and self._engine is not None:
            self._keys.detach()
            self._engine.terminals.remove_sink(label, self._show)
            # what is shown next may be of another one
            self._screen.end_line()
