# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What covers the panes for a moment: texts to read, and a question."""

from typing import ClassVar
from typing import Literal

from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding
from textual.binding import BindingType
from textual.containers import VerticalScroll
from textual.screen import ModalScreen
from textual.widgets import Static

#: What is to become of a launch that was started here: it is stopped, or runs
#: on, or nobody leaves.
Leaving = Literal['stop', 'leave', 'stay']


class Reading(ModalScreen[None]):
    """A text that may be longer than the screen."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding('escape,q,i,E,enter,question_mark', 'dismiss', show=False),
        Binding('ctrl+c', 'app.interrupt', show=False),
    ]

    def __init__(self, title: str, text: Text | Table) -> None:
        super().__init__()
        self._title = title
        self._text = text

    def compose(self) -> ComposeResult:
        """Make the widgets."""
        with VerticalScroll(classes='box') as box:
            box.border_title = Text(self._title)
            box.border_subtitle = Text('arrows scroll, Esc goes back')
            yield Static(self._text)


class LeaveQuestion(ModalScreen[Leaving]):
    """Asks what is to become of a launch that was started here."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding('s', 'answer("stop")', show=False),
        Binding('l', 'answer("leave")', show=False),
        Binding('escape,q', 'answer("stay")', show=False),
        Binding('ctrl+c', 'app.interrupt', show=False),
    ]

    def compose(self) -> ComposeResult:
        """Make the widgets."""
        with VerticalScroll(classes='box question') as box:
            box.border_title = 'Leave'
            yield Static(
                'The launch runs.\n\n'
                's    stop it, and leave\n'
                # for a terminal of 40 columns
                'l    leave it running:\n'
                '     --ui comes back to it,\n'
                '     --stop ends it\n'
                'Esc  stay'
            )

    def action_answer(self, answer: Leaving) -> None:
        """Take the answer."""
        self.dismiss(answer)
