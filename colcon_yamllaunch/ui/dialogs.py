# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What covers the panes for a moment: texts to read, and a question."""

from collections.abc import Iterable
from collections.abc import Sequence
from typing import ClassVar
from typing import Literal

from colcon_yamllaunch.ui.key_table import Key
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding
from textual.binding import BindingType
from textual.containers import VerticalScroll
from textual.screen import ModalScreen
from textual.widgets import Static

#: What is to become of a launch that was started here: it is stopped, or runs
#: on, or nobody leaves.
Leaving = Literal['stop', 'go', 'stay']


class Reading(ModalScreen[None]):
    """A text that may be longer than the screen."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding('escape,q,i,enter,question_mark', 'dismiss', show=False),
        Binding('ctrl+c', 'app.interrupt', show=False),
    ]

    def __init__(self, title: str, text: Text) -> None:
        super().__init__()
        self._title = title
        self._text = text

    def compose(self) -> ComposeResult:
        """Make the widgets."""
        with VerticalScroll(classes='box') as box:
            box.border_title = Text(self._title)
            box.border_subtitle = Text('Esc goes back')
            yield Static(self._text)


class LeaveQuestion(ModalScreen[Leaving]):
    """Asks what is to become of a launch that was started here."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding('s', 'answer("stop")', show=False),
        Binding('l', 'answer("go")', show=False),
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
                'l    leave it running: colcon launch --ui comes back,\n'
                '     colcon launch --stop ends it\n'
                'Esc  stay'
            )

    def action_answer(self, answer: Leaving) -> None:
        """Take the answer."""
        self.dismiss(answer)


def help_text(
    sections: Sequence[tuple[str, Iterable[Key]]], last: str
) -> Text:
    """
    Return what the keys do.

    :param last: What Ctrl-C does
    """
    text = Text()
    for title, keys in sections:
        text.append(f'{title}\n', 'bold')
        for key in keys:
            text.append(f'  {key.shown:<7}', 'cyan')
            text.append(f'{key.text}\n')
        text.append('\n')
    text.append('  Ctrl-C ', 'cyan')
    text.append(f'{last}\n')
    text.append('  Ctrl-Z ', 'cyan')
    text.append('suspend the full screen, and not the launch\n')
    text.append(
        '\nArrows, Page up and down, Home and End scroll; the output follows '
        'what comes while its end is in sight.'
    )
    return text
