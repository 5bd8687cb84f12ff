# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The widgets of the full screen: list, output, dialogs and prompt."""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from typing import ClassVar, Literal

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.observers.log_levels import Level
from colcon_yamllaunch.terminal.full_screen.output_store import (
    Line,
    OutputView,
    plain,
)
from colcon_yamllaunch.terminal.line_filter import Filtering, time_stamp
from colcon_yamllaunch.terminal.status_model import LOOKS, StatusRow
from rich.cells import cell_len
from rich.style import Style
from rich.table import Table
from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.events import Click
from textual.geometry import Size
from textual.message import Message
from textual.screen import ModalScreen
from textual.scroll_view import ScrollView
from textual.strip import Strip
from textual.widget import Widget
from textual.widgets import Input, Static


class Pane(ScrollView, can_focus=True):
    """A pane that the keyboard scrolls."""

    BINDINGS: ClassVar[list[BindingType]] = [
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

    def action_move(self, rows: int) -> None:
        """Go some rows up or down."""
        self._go(self._place + rows)

    def action_page(self, pages: int) -> None:
        """Go a screen up or down."""
        self.action_move(pages * max(1, self.size.height - 1))

    def action_begin(self) -> None:
        """Go to the first row."""
        self._go(0)

    def action_end(self) -> None:
        """Go to the last row."""
        self._go(int(self.virtual_size.height))

    @property
    def _place(self) -> int:
        """The row that the keys move."""
        raise NotImplementedError

    def _go(self, row: int) -> None:
        """Go to a row, or to the nearest that there is."""
        raise NotImplementedError


class MemberList(Pane):
    """Rows with a cursor, which stays with its process."""

    class Moved(Message):
        """The cursor is on another row."""

    def __init__(self) -> None:
        super().__init__(id='members')
        self._rows: Sequence[StatusRow] = ()
        self._filtering = Filtering()
        self._cursor = 0

    @property
    def label(self) -> str | None:
        """The process or component that the cursor is on."""
        if not self._rows:
            return None
        return self._rows[self._cursor].label

    def show(self, rows: Sequence[StatusRow], filtering: Filtering) -> None:
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
            # keys act on rows with a label
            self._cursor = next(
                (n for n, row in enumerate(rows) if row.label is not None), 0
            )
        self.virtual_size = Size(0, len(rows))
        self._keep_in_sight()
        self.refresh()

    def go_to(
        self, fits: Callable[[StatusRow], bool], *, after: bool = False
    ) -> bool:
        """
        Put the cursor on the first row that fits; return whether one does.

        :param after: Whether to begin after the row that it is on
        """
        start = self._cursor + 1 if after else 0
        rows = [*self._rows[start:], *self._rows[:start]]
        found = next((n for n, row in enumerate(rows) if fits(row)), None)
        if found is not None:
            self._go((start + found) % len(rows))
        return found is not None

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
            # reversed, colours would become different backgrounds
            text.spans = []
            text.stylize('reverse')
        elif number == self._cursor:
            text.stylize('bold')
        strip = Strip(text.render(self.app.console), text.cell_len)
        return strip.crop_extend(0, width, style)

    @property
    def _place(self) -> int:
        return self._cursor

    def _go(self, row: int) -> None:
        cursor = max(0, min(row, len(self._rows) - 1))
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

    def _text_of(self, row: StatusRow, width: int) -> Text:
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
        # the sign shows these states already
        note = '' if row.note in ('running', 'loaded') else row.note
        room = width - text.cell_len - 1
        if note and room > 0:
            shown = Text(note, 'bright_black', no_wrap=True, end='')
            shown.truncate(max(0, room - 1), overflow='ellipsis')
            text.append(' ' * (room - shown.cell_len))
            text.append_text(shown)
        text.truncate(width, overflow='ellipsis')
        return text


_LABEL_STYLES = (
    *('cyan', 'green', 'magenta', 'blue', 'yellow'),
    *('bright_cyan', 'bright_green', 'bright_magenta', 'bright_blue'),
)
_FOUND = Style(reverse=True, bold=True)
_TABS = 8


class OutputPane(Pane):
    """
    The output, of which only the visible lines are drawn.

    A long line takes several rows, as on any terminal. The pane follows the
    end until the user scrolls up; then it stays where the user looks.
    """

    class Followed(Message):
        """The end of the output came into sight or left it."""

    def __init__(self, view: OutputView) -> None:
        super().__init__(id='output')
        self._view = view
        self._styles: dict[str, str] = {}
        self._index = RowIndex()
        self._dropped = 0
        # the version of the view and the width that the index is for
        self._layout: tuple[object, ...] = ()
        # the line that was rendered last, with the key of the cache
        self._rendered: tuple[tuple[object, ...], Strip] | None = None
        # the line in the first row
        self._top: Line | None = None
        #: Whether the end is in sight, and stays so.
        self.follows = True

    def changed(self) -> None:
        """Show what is new."""
        view = self._view
        width = self._columns
        layout = view.version, width
        gone = 0
        altered = view.pop_altered()
        if layout != self._layout:
            self._layout = layout
            self._index = RowIndex()
            self._dropped = view.dropped
        else:
            gone = self._index.drop(view.dropped - self._dropped)
            self._dropped = view.dropped
            for place in altered:
                if place < len(self._index):
                    rows = self._rows_of(view.lines[place], width)
                    self._index.alter(place, rows)
        is_anew = not len(self._index)
        for line in view.lines[len(self._index) :]:
            self._index.add(self._rows_of(line, width))
        self.virtual_size = Size(width, self._index.rows)
        if not self.max_scroll_y:
            self.follows = True
        if self.follows:
            self._go(self.max_scroll_y)
        elif is_anew and self._top is not None:
            place = view.place_of(self._top.order)
            self._go(self._index.first_row(min(place, len(self._index))))
        elif gone:
            self._go(max(0, self.scroll_offset.y - gone))
        self.refresh()

    def on_resize(self) -> None:
        """Wrap lines anew."""
        if self._layout and self._columns != self._layout[1]:
            self.changed()

    def watch_scroll_y(self, old_value: float, new_value: float) -> None:
        """See whether the end is in sight."""
        super().watch_scroll_y(old_value, new_value)
        follows = new_value >= self.max_scroll_y
        if new_value != old_value and follows != self.follows:
            self.follows = follows
            self.post_message(self.Followed())

    def render_line(self, y: int) -> Strip:
        """Draw a row of the screen."""
        width = self._columns
        row = self.scroll_offset.y + y
        lines = self._view.lines
        number, piece = self._index.at(row)
        if number >= min(len(lines), len(self._index)):
            return Strip.blank(self.size.width, self.rich_style)
        if not y:
            self._top = lines[number]
        strip = self._strip_of(lines[number])
        begin = piece * width
        return strip.crop_extend(begin, begin + width, self.rich_style)

    @property
    def _columns(self) -> int:
        """The cells of a row."""
        return max(1, self.scrollable_content_region.width)

    @property
    def _place(self) -> int:
        return self.scroll_offset.y

    def _go(self, row: int) -> None:
        self.scroll_to(y=row, animate=False, force=True)

    def _rows_of(self, line: Line, width: int) -> int:
        cells = cell_len(plain(line.text).expandtabs(_TABS))
        cells += sum(map(cell_len, self._prefix_of(line)))
        return max(1, -(-cells // width))

    def _prefix_of(self, line: Line) -> tuple[str, str, str]:
        """Return the time, the label and the count in front of a line."""
        stamp = label = count = ''
        if self._view.filtering.times and line.time:
            stamp = time_stamp(line.time)
        is_alone = len(self._view.filtering.only) == 1
        if line.label is not None and not is_alone:
            label = f'[{one_line(line.label)}] '
        if line.count > 1:
            # in front, as it would be hidden behind a long line
            count = f'×{line.count} '
        return stamp, label, count

    def _strip_of(self, line: Line) -> Strip:
        key = (line, line.text, line.count, self._layout)
        if self._rendered is not None and self._rendered[0] == key:
            return self._rendered[1]
        text = self._text_of(line)
        strip = Strip(text.render(self.app.console), text.cell_len)
        self._rendered = key, strip
        return strip

    def _text_of(self, line: Line) -> Text:
        text = Text(no_wrap=True, end='')
        stamp, label, count = self._prefix_of(line)
        text.append(stamp, 'dim')
        if line.label is not None:
            number = len(self._styles) % len(_LABEL_STYLES)
            style = self._styles.setdefault(line.label, _LABEL_STYLES[number])
            text.append(label, style)
        text.append(count, 'bold')
        is_bad = line.level >= Level.WARN
        colour = 'yellow' if line.level < Level.ERROR else 'red'
        if line.is_note:
            style = f'bold {colour}' if is_bad else 'italic bright_black'
            text.append(line.text, style)
        else:
            body = Text.from_ansi(line.text, end='')
            body.expand_tabs(_TABS)
            if is_bad and line.is_leveled and '\x1b' not in line.text:
                body.stylize(colour)
            for start, end in self._view.filtering.places(body.plain):
                body.stylize(_FOUND, start, end)
            text.append_text(body)
        return text


class RowIndex:
    """The rows of lines, where a long line takes several."""

    def __init__(self) -> None:
        # for each line the rows up to its end
        self._ends: list[int] = []

    def __len__(self) -> int:
        return len(self._ends)

    @property
    def rows(self) -> int:
        """The rows of all lines."""
        return self.first_row(len(self._ends))

    def add(self, rows: int) -> None:
        """Add the rows of the next line."""
        self._ends.append(self.rows + rows)

    def alter(self, line: int, rows: int) -> None:
        """Change how many rows a line has."""
        more = self.first_row(line) + rows - self._ends[line]
        if more:
            for number in range(line, len(self._ends)):
                self._ends[number] += more

    def drop(self, lines: int) -> int:
        """Remove the first lines, and return how many rows they had."""
        gone = self.first_row(min(lines, len(self._ends)))
        self._ends = [end - gone for end in self._ends[lines:]]
        return gone

    def first_row(self, line: int) -> int:
        """Return the number of the first row that a line is shown in."""
        return self._ends[line - 1] if line else 0

    def at(self, row: int) -> tuple[int, int]:
        """Return the line of a row, and which of its rows that is."""
        line = bisect_right(self._ends, row)
        return line, row - self.first_row(line)


#: The answers to the question whether to leave: stop the launch, leave it
#: running, or stay.
Leaving = Literal['stop', 'leave', 'stay']

#: What is asked for: a text that lines have, or the name of a process.
Asked = Literal['search', 'find']

_PLACEHOLDERS: dict[Asked, str] = {
    'search': '/ a text that lines have',
    'find': ': a part of a name',
}


class TextScreen(ModalScreen[None]):
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
        Binding('s', 'dismiss("stop")', show=False),
        Binding('l', 'dismiss("leave")', show=False),
        Binding('escape,q', 'dismiss("stay")', show=False),
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


class FixedText(Widget):
    """A text in a place whose size does not depend on it."""

    DEFAULT_CSS = 'FixedText { height: auto; }'

    def __init__(self, name: str) -> None:
        super().__init__(id=name)
        self._text = Text()

    def render(self) -> Text:
        """Return the text, for textual."""
        return self._text

    def show(self, text: Text) -> None:
        """Show another text, without computing the layout again."""
        self._text = text
        self.refresh()


class Prompt(Input):
    """
    The line that a text or a name is typed in; hidden otherwise.

    :param changed: Is called with what is typed, as it is typed
    :param submitted: Is called when it is entered
    """

    def __init__(
        self,
        changed: Callable[[Asked, str], None],
        submitted: Callable[[], None],
    ) -> None:
        super().__init__(id='prompt')
        self.display = False
        #: What is asked for, None for nothing.
        self.asked: Asked | None = None
        self._use_text = changed
        self._finish = submitted

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
        # at once, so that the next key reaches it
        self.screen.set_focus(self)

    def close_prompt(self) -> None:
        """Hide; the caller sets the focus."""
        self.asked = None
        self.display = False

    def on_input_changed(self, event: Input.Changed) -> None:
        """Pass on what is typed."""
        event.stop()
        self._report(event.value)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Pass on what was entered."""
        event.stop()
        self._report(event.value)
        self._finish()

    def _report(self, text: str) -> None:
        if self.asked is not None:
            self._use_text(self.asked, text)
