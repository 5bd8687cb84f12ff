# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The process that is typed at in the terminal of its launch."""

import termios

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.observers.screen import Screen
from colcon_yamllaunch.terminal.keyboard import ESCAPE_NAME
from colcon_yamllaunch.terminal.keys import Keys

_HINT = f'attached: {ESCAPE_NAME} goes back'


class Attachment:
    """
    What is typed goes to a process, and its output is shown as it comes.

    One that reads lines gets lines, which are edited below the output; one
    that has its terminal in raw mode gets each key. The process may be
    started anew meanwhile.

    :param label: Of the process, as soon as it starts; None for none yet
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
        """Type at none any more."""
        self._end()
        self._engine = None

    @property
    def is_wanted(self) -> bool:
        """Whether a process is typed at, or is to be."""
        return self._wanted is not None or self._keys.attached is not None

    def shows(self, label: str) -> bool:
        """Tell whether the output of a process is shown here."""
        return self._keys.attached == label

    def before(self, event: events.Event) -> None:
        """Follow what happens, before it is shown."""
        if isinstance(event, events.Exited):
            self._started.pop(event.process.label, None)
            if self.shows(event.process.label):
                self._end()

    def after(self, event: events.Event) -> None:
        """Follow what happens, after it has been shown."""
        if not isinstance(event, events.Started):
            return
        label = event.process.label
        self._started[label] = event
        if label == self._wanted:
            self._wanted = None
            self.attach(label)

    def await_start(self, label: str) -> None:
        """Attach to a process when it starts next."""
        self._wanted = label

    def attach(self, label: str) -> bool:
        """Type at a process, and return whether it can be typed at."""
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
        """Take into account that the user has gone back."""
        self._wanted = None
        self._end(label)
        started = self._started.get(label)
        if started is not None and self._engine is not None:
            self._engine.tell(events.Detached(started.process))

    def type(self, keys: bytes) -> None:
        """Pass on what was typed."""
        label = self._keys.attached
        if label is not None and self._engine is not None:
            self._engine.terminals.type(label, keys)

    def read_modes(self) -> None:
        """See whether the process takes lines or keys now."""
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
