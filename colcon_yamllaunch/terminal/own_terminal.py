# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The terminal that a launch was started in, as far as there is one.

What has to do with it is imported where it is needed: most launches by
programs have no terminal.
"""

from collections.abc import Callable
from contextlib import ExitStack
import sys
from typing import TYPE_CHECKING

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.engine.output.writer import Writer
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.engine.stopping.guard_link import GuardLink
from colcon_yamllaunch.observers.display import Display
from colcon_yamllaunch.observers.display import is_same_terminal
from colcon_yamllaunch.observers.screen import Screen

if TYPE_CHECKING:
    from colcon_yamllaunch.terminal.local_attachment import LocalAttachment
    from colcon_yamllaunch.terminal.terminal_session import TerminalSession


def status_writer(descriptor: int) -> Writer:
    """Return what writes to a terminal, with a status block below that."""
    from colcon_yamllaunch.terminal.status_writer import StatusWriter

    return StatusWriter(descriptor)


class OwnTerminal:
    """
    Shows what happens, and has done what is typed.

    :param show: Shows it above the status block, if there is one
    :param display: Has a writer by :func:`status_writer` if there is to be a
      status block
    :param attach: The label of the process that has the keyboard at first
    """

    def __init__(
        self,
        show: events.Listener,
        state: LaunchState,
        display: Display,
        screen: Screen,
        guard: GuardLink,
        conditions: ExitConditions,
        clock: Callable[[], float],
        attach: str | None,
        *,
        has_status: bool,
    ) -> None:
        #: Shows what happens.
        self.show = show
        self._attachment: LocalAttachment | None = None
        self._session: TerminalSession | None = None
        has_keys = has_status and is_same_terminal(
            sys.stdin, display.descriptor
        )
        if attach is not None and not has_keys:
            self._attachment = _attachment(attach, screen, show)
            self.show = self._attachment.handle
        if has_status:
            self._session = _session(
                state,
                display,
                screen,
                guard,
                conditions,
                clock,
                attach,
                has_keys=has_keys,
            )
            self.show = self._session.showing(self.show)

    def connect(self, engine: Engine, stack: ExitStack) -> None:
        """
        Use an engine, before it runs.

        :param stack: Gives the terminal back
        """
        if self._session is not None:
            self._session.connect(engine)
            stack.callback(self._session.close)
        if self._attachment is not None:
            self._attachment.connect(engine)
            stack.callback(self._attachment.close)


def _attachment(
    label: str, screen: Screen, show: events.Listener
) -> 'LocalAttachment':
    from colcon_yamllaunch.terminal.keyboard import Keyboard
    from colcon_yamllaunch.terminal.local_attachment import LocalAttachment

    return LocalAttachment(label, Keyboard(sys.stdin.fileno()), screen, show)


def _session(
    state: LaunchState,
    display: Display,
    screen: Screen,
    guard: GuardLink,
    conditions: ExitConditions,
    clock: Callable[[], float],
    attach: str | None,
    *,
    has_keys: bool,
) -> 'TerminalSession':
    from colcon_yamllaunch.terminal.keyboard import Keyboard
    from colcon_yamllaunch.terminal.status_writer import StatusWriter
    from colcon_yamllaunch.terminal.terminal_session import TerminalSession

    assert isinstance(display.writer, StatusWriter)
    keyboard = None
    if has_keys:
        keyboard = Keyboard(sys.stdin.fileno())
    elif attach is None:
        # what would be shown of keys would be in the block
        keyboard = Keyboard(display.descriptor, takes_keys=False)
    return TerminalSession(
        state,
        display.writer,
        screen,
        guard,
        keyboard,
        color=display.color,
        is_plain=display.is_ascii,
        environment=display.environment,
        conditions=conditions,
        clock=clock,
        attach=attach if has_keys else None,
    )
