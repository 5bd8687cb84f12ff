# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The terminal that a launch was started in, as far as there is one.

Modules for it are imported where they are needed: most launches by programs
have no terminal.
"""

from collections.abc import Callable
from contextlib import ExitStack
import sys
from typing import TYPE_CHECKING

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.engine.guard_link import GuardLink
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.engine.writer import Writer
from colcon_yamllaunch.observers.display import Display
from colcon_yamllaunch.observers.display import is_same_terminal
from colcon_yamllaunch.observers.screen import Screen

if TYPE_CHECKING:
    from colcon_yamllaunch.terminal.local_attachment import LocalAttachment
    from colcon_yamllaunch.terminal.terminal_session import TerminalSession

    _User = LocalAttachment | TerminalSession


def status_writer(descriptor: int) -> Writer:
    """Return a writer to a terminal that draws a status block."""
    from colcon_yamllaunch.terminal.status_writer import StatusWriter

    return StatusWriter(descriptor)


class LaunchTerminal:
    """
    The status block and the keyboard of a launch, if it has them.

    :param show: Shows an event; the status block stays below that
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
        #: Shows an event.
        self.show = show
        self._users: list[_User] = []
        has_keys = has_status and is_same_terminal(
            sys.stdin, display.descriptor
        )
        if attach is not None and not has_keys:
            from colcon_yamllaunch.terminal.keyboard import Keyboard
            from colcon_yamllaunch.terminal.local_attachment import (
                LocalAttachment,
            )

            keyboard = Keyboard(sys.stdin.fileno())
            attachment = LocalAttachment(attach, keyboard, screen, show)
            self._users.append(attachment)
            self.show = attachment.handle
        if has_status:
            from colcon_yamllaunch.terminal.terminal_session import (
                TerminalSession,
            )

            session = TerminalSession(
                state,
                display,
                screen,
                self.show,
                guard,
                conditions,
                clock,
                attach,
                has_keys=has_keys,
            )
            self._users.insert(0, session)
            self.show = session.handle

    def connect(self, engine: Engine, stack: ExitStack) -> None:
        """
        Use an engine, before it runs.

        :param stack: Gives the terminal back
        """
        for user in self._users:
            user.connect(engine)
            stack.callback(user.close)
