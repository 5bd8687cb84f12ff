# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The connection of the keyboard to one process of the launch."""

from abc import abstractmethod
import termios
from typing import ClassVar

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.suggestions import listing
from colcon_yamllaunch.control.process_names import meant_by, ProcessNames
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.terminals import with_terminals
from colcon_yamllaunch.observers.screen import Screen
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.terminal.keyboard import (
    ESCAPE,
    ESCAPE_NAME,
    WatchedKeyboard,
)
from colcon_yamllaunch.terminal.keys import Keys


def with_terminal(plan: Plan, name: str) -> tuple[Plan, str]:
    """
    Return the plan with a terminal for the attached process, and its label.

    :param name: Its name, or a glob
    :raises UserError: when not exactly one is meant
    """
    known = [ProcessNames.of_plan(p) for p in plan.processes()]
    labels = [names.label for names in known]
    meant = [labels[index] for index in meant_by(name, known)]
    if len(meant) != 1:
        raise UserError(
            f'--attach {name} means {listing(meant)}: it takes one process'
            if meant
            else f"--attach: there is no process '{name}'; there is "
            f'{listing(labels) or "none"}'
        )
    return with_terminals(plan, meant[0]), meant[0]


class Attachment:
    """
    The connection of the keyboard and the screen to a process.

    When the process is restarted, the connection is restored.

    :param label: The process to connect when it starts; None for none
    """

    #: What is said about the keys when a process is connected.
    hint: ClassVar[str]

    def __init__(self, screen: Screen, label: str | None) -> None:
        self._screen = screen
        self._wanted = label
        self._attached: str | None = None
        self._started: dict[str, events.Started] = {}

    def connect(self, engine: Engine) -> None:
        """Use an engine, before it runs."""
        self._engine: Engine = engine

    def close(self) -> None:
        """Disconnect."""
        self._end()

    def shows(self, label: str) -> bool:
        """Return whether the output of a process is shown as it comes."""
        return self._attached == label

    def before(self, event: events.Event) -> None:
        """Handle an event before it is shown."""
        if isinstance(event, events.Exited):
            self._started.pop(event.process.label, None)
            if self.shows(event.process.label):
                self._end()

    def after(self, event: events.Event) -> None:
        """Handle an event after it was shown."""
        if isinstance(event, events.Started):
            label = event.process.label
            self._started[label] = event
            if label == self._wanted:
                self._attach_awaited(label)

    def attach(self, label: str) -> bool:
        """Connect a process, and return whether that is possible."""
        engine, started = self._engine, self._started.get(label)
        if (
            started is None
            or not engine.terminals.has_keyboard(label)
            or not self._connect_keyboard(label)
        ):
            return False
        self._wanted = self._attached = label
        engine.emit(events.Attached(started.process, self.hint))
        engine.terminals.add_sink(label, self._show)
        return True

    def detach(self, label: str) -> None:
        """Disconnect a process, as the user pressed the escape key."""
        self._wanted = None
        self._end()
        started = self._started.get(label)
        if started is not None:
            self._engine.emit(events.Detached(started.process))

    def _attach_awaited(self, label: str) -> None:
        """Connect the awaited process, which has started."""
        self.attach(label)

    def _end(self) -> None:
        label, self._attached = self._attached, None
        if label is not None:
            self._disconnect_keyboard()
            self._engine.terminals.remove_sink(label, self._show)
            # the next output may come from another process, or the shell
            self._screen.end_line()

    def _show(self, stream: events.Stream, data: bytes) -> None:
        self._screen.show_raw((self._attached, stream), data)

    @abstractmethod
    def _connect_keyboard(self, label: str) -> bool:
        """Send what is typed to a process; return whether that is possible."""

    @abstractmethod
    def _disconnect_keyboard(self) -> None:
        """Stop sending what is typed to a process."""


class KeysAttachment(Attachment):
    """
    The connection of a process to the keys of a status block.

    A process that reads lines gets lines, which are edited below the output;
    one that has its terminal in raw mode gets each key.
    """

    hint = f'attached: {ESCAPE_NAME} goes back'

    def __init__(self, keys: Keys, screen: Screen, label: str | None) -> None:
        super().__init__(screen, label)
        self._keys = keys

    @property
    def is_wanted(self) -> bool:
        """Whether a process is connected, or will be when it starts."""
        return self._wanted is not None

    def await_start(self, label: str) -> None:
        """Connect a process when it starts next."""
        self._wanted = label

    def attach(self, label: str) -> bool:
        """Connect a process, and return whether that is possible."""
        is_attached = super().attach(label)
        self.read_modes()
        return is_attached

    def type(self, keys: bytes) -> None:
        """Send what was typed to the process."""
        if self._attached is not None:
            self._engine.terminals.type(self._attached, keys)

    def read_modes(self) -> None:
        """Read whether the process takes lines or keys now."""
        if self._attached is None:
            return
        local = self._engine.terminals.input_modes(self._attached)
        if local is not None:
            self._keys.attach(
                self._attached,
                is_raw=not local & termios.ICANON,
                is_secret=not local & termios.ECHO,
            )

    def _attach_awaited(self, label: str) -> None:
        # if it has no terminal this time, do not attach its next start
        self._wanted = None
        super()._attach_awaited(label)

    def _connect_keyboard(self, label: str) -> bool:
        self._end()
        self._keys.attach(label)
        return True

    def _disconnect_keyboard(self) -> None:
        self._keys.attached = None

    def _show(self, stream: events.Stream, data: bytes) -> None:
        self.read_modes()
        super()._show(stream, data)


class LocalAttachment(Attachment):
    """
    The connection of a process to a keyboard, without a status block.

    Its output has no prefix and may be half a line, such as a prompt; that of
    other processes starts a new line.

    :param show: Shows an event
    """

    hint = (
        f'attached: {ESCAPE_NAME} detaches, Ctrl-C stops the launch, Ctrl-Z '
        'suspends it'
    )

    def __init__(
        self,
        label: str,
        descriptor: int,
        screen: Screen,
        show: events.Listener,
    ) -> None:
        super().__init__(screen, label)
        self._label = label
        self._keyboard = WatchedKeyboard(descriptor, self._typed)
        self._show_event = show

    def connect(self, engine: Engine) -> None:
        """Use an engine, before it runs."""
        super().connect(engine)
        self._keyboard.connect(engine.loop)
        engine.when_suspended.append(self._suspend)

    def handle(self, event: events.Event) -> None:
        """Show an event, and follow the process."""
        if isinstance(event, events.Output) and self.shows(
            event.process.label
        ):
            return
        self.before(event)
        self._show_event(event)
        self.after(event)

    def _connect_keyboard(self, label: str) -> bool:  # noqa: ARG002
        return self._keyboard.watch(keeps_early=True) is not None

    def _disconnect_keyboard(self) -> None:
        self._keyboard.release()

    def _suspend(self, is_suspended: bool) -> None:
        if is_suspended:
            self._keyboard.release()
        elif self._attached is None:
            if self._wanted is not None:
                self.attach(self._wanted)
        elif self._keyboard.watch(keeps_early=True) is None:
            # the launch goes on in the background
            self._end()

    def _typed(self, data: bytes) -> None:
        """Send typed bytes to the process; no bytes mean a hang-up."""
        keys, escape, _ = data.partition(ESCAPE)
        self._engine.terminals.type(self._label, keys)
        if escape or not data:
            self.detach(self._label)
