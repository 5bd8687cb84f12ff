# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The line that a text or a name is typed in."""

from collections.abc import Callable
from typing import Literal

from textual.widgets import Input

#: What is asked for: a text that lines have, or the name of a process.
Asked = Literal['search', 'find']

_PLACEHOLDERS: dict[Asked, str] = {
    'search': '/ a text that lines have',
    'find': ': a part of a name',
}


class Prompt(Input):
    """
    Asks for something, and is not to be seen otherwise.

    :param take: Is told what is typed, as it is typed
    :param done: Is called when all of it has been
    """

    def __init__(
        self, take: Callable[[Asked, str], None], done: Callable[[], None]
    ) -> None:
        super().__init__(id='prompt', compact=True)
        self.display = False
        #: What is asked for, None for nothing.
        self.asked: Asked | None = None
        self._take = take
        self._done = done

    def ask(self, what: Asked, value: str = '') -> None:
        """
        Ask for something.

        :param value: What is typed already
        """
        self.asked = None
        self.value = value
        self.placeholder = _PLACEHOLDERS[what]
        self.asked = what
        self.display = True
        # at once, so that what is typed next gets there
        self.screen.set_focus(self)

    def ask_no_more(self) -> None:
        """Vanish; who has the focus then is somebody else's choice."""
        self.asked = None
        self.display = False

    def on_input_changed(self, event: Input.Changed) -> None:
        """Take what is typed."""
        event.stop()
        self._tell(event.value)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Take what was typed."""
        event.stop()
        self._tell(event.value)
        self._done()

    def _tell(self, text: str) -> None:
        if self.asked is not None:
            self._take(self.asked, text)
