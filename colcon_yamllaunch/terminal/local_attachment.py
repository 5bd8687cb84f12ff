# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The keyboard of a launch without a status block, at one process."""

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.observers.screen import Screen
from colcon_yamllaunch.terminal.keyboard import ESCAPE
from colcon_yamllaunch.terminal.keyboard import ESCAPE_NAME
from colcon_yamllaunch.terminal.keyboard import Keyboard
from colcon_yamllaunch.terminal.keyboard import WatchedKeyboard

_HINT = (
    f'attached: {ESCAPE_NAME} detaches, Ctrl-C stops the launch, Ctrl-Z '
    'suspends it'
)


class LocalAttachment:
    """
    The connection of the keyboard and the screen to a process.

    Its output has no prefix and may be half a line, such as a prompt; that of
    other processes starts a new line. When it is respawned, the connection is
    restored.
    """

    def __init__(
        self,
        label: str,
        keyboard: Keyboard,
        screen: Screen,
        show: events.Listener,
    ) -> None:
        self._label = label
        self._keyboard = WatchedKeyboard(keyboard, self._typed)
        self._screen = screen
        self._show = show
        self._engine: Engine | None = None
        self._started: events.Started | None = None
        self._is_attached = False

    def connect(self, engine: Engine) -> None:
        """Use an engine, before it runs."""
        self._engine = engine
        self._keyboard.connect(engine.loop)
        engine.when_suspended.append(self._suspend)

    def handle(self, event: events.Event) -> None:
        """Show an event, and follow the process."""
        process = getattr(event, 'process', None)
        is_own = process is not None and process.label == self._label
        if is_own and self._is_attached and isinstance(event, events.Output):
            return
        if is_own and isinstance(event, events.Exited):
            self._started = None
            self._detach()
        self._show(event)
        if is_own and isinstance(event, events.Started):
            self._started = event
            self._attach()

    def close(self) -> None:
        """Restore the terminal."""
        self._detach()
        self._engine = None

    def _attach(self) -> None:
        engine, started = self._engine, self._started
        if engine is None or started is None or self._is_attached:
            return
        if self._keyboard.grab(keeps_early=True):
            self._is_attached = True
            engine.terminals.add_sink(self._label, self._show_raw)
            engine.tell(events.Attached(started.process, _HINT))

    def _detach(self) -> None:
        if self._is_attached and self._engine is not None:
            self._is_attached = False
            self._engine.terminals.remove_sink(self._label, self._show_raw)
            self._keyboard.release()
            # what is shown next may be the shell's
            self._screen.end_line()

    def _suspend(self, is_suspended: bool) -> None:
        if is_suspended:
            self._keyboard.release()
        elif not self._is_attached:
            self._attach()
        elif not self._keyboard.grab(keeps_early=True):
            # the launch goes on in the background
            self._detach()

    def _typed(self, data: bytes) -> None:
        """Pass on what was typed; nothing is the end of the terminal."""
        assert self._engine is not None
        keys, escape, _ = data.partition(ESCAPE)
        self._engine.terminals.type(self._label, keys)
        if escape or not data:
            self._give_up()

    def _give_up(self) -> None:
        started, self._started = self._started, None
        self._detach()
        if started is not None and self._engine is not None:
            self._engine.tell(events.Detached(started.process))
            self._engine = None

    def _show_raw(self, stream: events.Stream, data: bytes) -> None:
        self._screen.show_raw((self._label, stream), data)
