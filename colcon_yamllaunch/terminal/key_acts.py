# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is done with a process as somebody presses a key for it."""

from collections.abc import Callable
from collections.abc import Iterable
from typing import Any

from colcon_yamllaunch.engine import commands
from colcon_yamllaunch.engine.commands import Command
from colcon_yamllaunch.engine.commands import Described
from colcon_yamllaunch.engine.commands import Refused
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.state import ComponentState
from colcon_yamllaunch.engine.state import ProcessState
from colcon_yamllaunch.terminal.attachment import Attachment
from colcon_yamllaunch.terminal.keymap import cannot_be_typed_at
from colcon_yamllaunch.terminal.keys import Act
from colcon_yamllaunch.terminal.keys import DOWN
from colcon_yamllaunch.terminal.keys import Keys
from colcon_yamllaunch.terminal.status_model import StatusModel


class KeyActs:
    """
    Does what keys stand for; what is refused is told in the status block.

    :param show: Shows lines, the first one a heading
    :param page: Leaves the terminal to the pager, with the log of a process
    """

    def __init__(
        self,
        engine: Engine,
        model: StatusModel,
        keys: Keys,
        attachment: Attachment,
        show: Callable[[Iterable[str]], None],
        page: Callable[[str, str | None], None],
    ) -> None:
        self._engine = engine
        self._model = model
        self._keys = keys
        self._attachment = attachment
        self._show = show
        self._page = page

    def do(self, act: Act) -> None:
        """Do something with a process or component."""
        label = act.label
        part = self._model.part(label)
        if act.action in ('stop', 'kill') and part and part.condition in DOWN:
            self._keys.tell(f'{label} does not run')
        match act.action:
            case 'stop':
                self._ask(commands.Stop(label))
            case 'restart':
                self._ask(commands.Restart(label))
            case 'kill':
                self._ask(commands.Kill(label))
            case 'debug':
                self._ask(
                    commands.Debug(label),
                    lambda _: self._attachment.await_start(label),
                )
            case 'attach':
                if not self._attachment.attach(label):
                    self._keys.tell(self._no_keyboard(label))
            case 'detach':
                self._attachment.detached(label)
            case 'log':
                self._ask(commands.Describe(label), self._page_described)
            case 'describe':
                self._ask(commands.Describe(label), self._describe)

    def switch_watch(self) -> None:
        """Have nothing follow from changes of files, or again."""
        is_paused = self._engine.state.watch_paused
        self._ask(commands.Watch('resume' if is_paused else 'pause'))

    def _ask(
        self,
        command: Command[Any],
        then: Callable[[Any], None] = lambda _: None,
    ) -> None:
        """Send a command; show why it is refused, or call `then`."""

        def reply(response: Any) -> None:
            if isinstance(response, Refused):
                self._keys.tell(response.error)
            else:
                then(response)

        self._engine.dispatcher.ask(command, reply)

    def _page_described(self, response: Described) -> None:
        described = response.description
        self._page(described.label, described.log)

    def _describe(self, response: Described) -> None:
        # few are asked for it
        from colcon_yamllaunch.control.description_lines import (
            description_lines,
        )

        self._show(description_lines(response.description))

    def _no_keyboard(self, label: str) -> str:
        part = self._model.part(label)
        return cannot_be_typed_at(
            label,
            is_process=not isinstance(part, ComponentState),
            runs=isinstance(part, ProcessState) and part.pid is not None,
        )
