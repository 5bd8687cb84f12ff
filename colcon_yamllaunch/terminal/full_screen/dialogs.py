# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the user reads, answers or types beside the panes."""

from collections.abc import Callable
from typing import ClassVar
from typing import Literal

from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding
from textual.binding import BindingType
from textual.containers import VerticalScroll
from textual.screen import ModalScreen
from textual.widgets import Input
from textual.widgets import Static

#: What is to become of a launch that was started here: it is stopped, or runs
#: on, or nobody leaves.
Leaving = Literal['stop', 'leave', 'stay']

#: What is asked for: a text that lines have, or the name of a process.
Asked = Literal['search', 'find']

_PLACEHOLDERS: dict[Asked, str] = {
    'search': '/ a text that lines have',
    'find': ': a part of a name',
}


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
    """The question whether to stop the launch that was started here."""

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
        """Close with an answer."""
        self.dismiss(answer)


class Prompt(Input):
    """
    The line that a text or a name is typed in; hidden otherwise.

    :param take: Is called with what is typed, as it is typed
    :param done: Is called when it is entered
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
        """Hide; the caller sets the focus."""
        self.asked = None
        self.display = False

    def on_input_changed(self, event: Input.Changed) -> None:
        """Pass on what is typed."""
        event.stop()
        self._tell(event.value)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Pass on what was entered."""
        event.stop()
        self._tell(event.value)
        self._done()

    def _tell(self, text: str) -> None:
        if self.asked is not None:
            self._take(self.asked, text)
