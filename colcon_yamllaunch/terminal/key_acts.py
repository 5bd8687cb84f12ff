# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is done with a process as somebody presses a key for it."""

from collections.abc import Callable
from collections.abc import Iterable
from typing import TYPE_CHECKING

from colcon_yamllaunch.control.acts import Acts
from colcon_yamllaunch.engine.state import ComponentState
from colcon_yamllaunch.engine.state import ProcessState
from colcon_yamllaunch.engine.tasks import RefusedError
from colcon_yamllaunch.terminal.attachment import Attachment
from colcon_yamllaunch.terminal.key_meanings import cannot_be_typed_at
from colcon_yamllaunch.terminal.keys import Act
from colcon_yamllaunch.terminal.keys import DOWN
from colcon_yamllaunch.terminal.keys import Keys
from colcon_yamllaunch.terminal.status_model import StatusModel

if TYPE_CHECKING:
    # few launches are asked
    from colcon_yamllaunch.control.description import Description


class KeyActs:
    """
    Does what keys stand for; what is refused is told in the status block.

    :param show: Shows lines, the first one a heading
    :param page: Leaves the terminal to the pager, with the log of a process
    """

    def __init__(
        self,
        acts: Acts,
        model: StatusModel,
        keys: Keys,
        attachment: Attachment,
        show: Callable[[Iterable[str]], None],
        page: Callable[[str, str | None], None],
    ) -> None:
        self._acts = acts
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
        try:
            match act.action:
                case 'stop' | 'restart' | 'kill' as action:
                    self._acts.act(action, label, self._done)
                case 'debug':
                    self._acts.act('debug', label, self._done)
                    self._attachment.await_start(label)
                case 'attach':
                    if not self._attachment.attach(label):
                        self._keys.tell(self._no_keyboard(label))
                case 'detach':
                    self._attachment.detached(label)
                case 'log':
                    self._acts.describe_to(label, self._page_described)
                case 'describe':
                    self._acts.describe_to(label, self._describe)
        except RefusedError as error:
            self._keys.tell(str(error))

    def switch_watch(self) -> None:
        """Have nothing follow from changes of files, or again."""
        try:
            self._acts.watch(paused=not self._acts.is_watch_paused)
        except RefusedError as error:
            self._keys.tell(str(error))

    def _done(self, error: str | None) -> None:
        if error is not None:
            self._keys.tell(error)

    def _page_described(self, told: 'Description | str') -> None:
        if isinstance(told, str):
            self._keys.tell(told)
        else:
            self._page(told.label, told.log)

    def _describe(self, told: 'Description | str') -> None:
        if isinstance(told, str):
            self._keys.tell(told)
            return
        # few are asked for it
        from colcon_yamllaunch.control.description_lines import (
            description_lines,
        )

        self._show(description_lines(told))

    def _no_keyboard(self, label: str) -> str:
        part = self._model.part(label)
        return cannot_be_typed_at(
            label,
            is_process=not isinstance(part, ComponentState),
            runs=isinstance(part, ProcessState) and part.pid is not None,
        )
