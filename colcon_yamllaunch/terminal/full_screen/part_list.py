# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The pane with the processes, or with the plan."""

from collections.abc import Collection
from collections.abc import Sequence
from typing import ClassVar

from colcon_yamllaunch.terminal.line_filter import Filtering
from colcon_yamllaunch.terminal.status_model import LOOKS
from colcon_yamllaunch.terminal.status_model import Row
from rich.text import Text
from textual.binding import Binding
from textual.binding import BindingType
from textual.events import Click
from textual.geometry import Size
from textual.message import Message
from textual.scroll_view import ScrollView
from textual.strip import Strip

#: The keys that scroll a pane.
SCROLLING: list[BindingType] = [
    Binding(key, action, show=False)
    for key, action in (
        ('up', 'move(-1)'),
        ('down', 'move(1)'),
        ('pageup', 'page(-1)'),
        ('pagedown', 'page(1)'),
        ('home', 'begin'),
        ('end', 'end'),
    )
]


class PartList(ScrollView, can_focus=True):
    """Rows with a cursor, which stays with its process."""

    BINDINGS: ClassVar[list[BindingType]] = SCROLLING

    class Moved(Message):
        """The cursor is on another row."""

    def __init__(self) -> None:
        super().__init__(id='parts')
        self._rows: Sequence[Row] = ()
        self._filtering = Filtering()
        self._cursor = 0

    @property
    def label(self) -> str | None:
        """The process or component that the cursor is on."""
        if not self._rows:
            return None
        return self._rows[self._cursor].label

    def show(self, rows: Sequence[Row], filtering: Filtering) -> None:
        """Show rows, and which of them are muted or chosen."""
        if rows == self._rows and filtering == self._filtering:
            return
        label = self.label
        self._rows = rows
        self._filtering = filtering
        found = (n for n, row in enumerate(rows) if row.label == label)
        last = max(0, len(rows) - 1)
        self._cursor = min(self._cursor, last)
        if label is not None:
            self._cursor = next(found, self._cursor)
        elif all(row.label is None for row in rows[: self._cursor + 1]):
            # acts are for what has a label
            self._cursor = next(
                (n for n, row in enumerate(rows) if row.label is not None), 0
            )
        self.virtual_size = Size(0, len(rows))
        self._keep_in_sight()
        self.refresh()

    def go_to(self, label: str) -> bool:
        """Put the cursor on a process; tell whether it is there."""
        for number, row in enumerate(self._rows):
            if row.label == label:
                self._go(number)
                return True
        return False

    def find(self, name: str) -> bool:
        """Put the cursor on the first row with a part of a name."""
        for number, row in enumerate(self._rows):
            if row.label is not None and name.lower() in row.label.lower():
                self._go(number)
                return True
        return False

    def next_of(self, labels: Collection[str]) -> bool:
        """Put the cursor on the next row with one of some labels."""
        count = len(self._rows)
        for step in range(1, count + 1):
            number = (self._cursor + step) % count
            if self._rows[number].label in labels:
                self._go(number)
                return True
        return False

    def action_move(self, rows: int) -> None:
        """Go up or down."""
        self._go(self._cursor + rows)

    def action_page(self, pages: int) -> None:
        """Go a screen up or down."""
        self._go(self._cursor + pages * max(1, self.size.height - 1))

    def action_begin(self) -> None:
        """Go to the first row."""
        self._go(0)

    def action_end(self) -> None:
        """Go to the last row."""
        self._go(len(self._rows))

    def on_click(self, event: Click) -> None:
        """Go where the mouse is."""
        self._go(self.scroll_offset.y + event.y)

    def on_resize(self) -> None:
        """Keep the cursor in sight."""
        self._keep_in_sight()

    def render_line(self, y: int) -> Strip:
        """Draw a row."""
        number = self.scroll_offset.y + y
        width = self.size.width
        style = self.rich_style
        if number >= len(self._rows):
            return Strip.blank(width, style)
        text = self._text_of(self._rows[number], width)
        if number == self._cursor and self.has_focus:
            text.pad_right(width - text.cell_len)
            # reversed, each colour would be another background
            text.spans = []
            text.stylize('reverse')
        elif number == self._cursor:
            text.stylize('bold')
        strip = Strip(text.render(self.app.console), text.cell_len)
        return strip.crop_extend(0, width, style)

    def _go(self, number: int) -> None:
        cursor = max(0, min(number, len(self._rows) - 1))
        if cursor != self._cursor:
            self._cursor = cursor
            self._keep_in_sight()
            self.refresh()
            self.post_message(self.Moved())

    def _keep_in_sight(self) -> None:
        height = self.size.height
        top = self.scroll_offset.y
        if self._cursor < top:
            top = self._cursor
        elif height and self._cursor >= top + height:
            top = self._cursor - height + 1
        self.scroll_to(y=top, animate=False, force=True)

    def _text_of(self, row: Row, width: int) -> Text:
        text = Text(no_wrap=True, end='')
        text.append(f'{row.key or " "} ', 'bright_black')
        text.append('  ' * row.depth)
        text.append(f'{row.look.sign} ', row.style)
        filtering = self._filtering
        hidden = row.label is not None and not filtering.has(row.label)
        chosen = row.label in filtering.only
        style = (
            'bold underline'
            if chosen
            else row.style * (row.look == LOOKS['failed'])
        )
        text.append(row.title, style or ('dim' if hidden else ''))
        if row.label in filtering.muted:
            text.append(' (muted)', 'dim')
        # what is not known from the sign
        note = '' if row.note in ('running', 'loaded') else row.note
        room = width - text.cell_len - 1
        if note and room > 0:
            shown = Text(note, 'bright_black', no_wrap=True, end='')
            shown.truncate(max(0, room - 1), overflow='ellipsis')
            text.append(' ' * (room - shown.cell_len))
            text.append_text(shown)
        text.truncate(width, overflow='ellipsis')
        return text
