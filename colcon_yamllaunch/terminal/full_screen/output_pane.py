# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The pane with the output."""

from bisect import bisect_right
import time
from typing import ClassVar

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.observers.log_levels import Level
from colcon_yamllaunch.terminal.full_screen.output_store import Line
from colcon_yamllaunch.terminal.full_screen.output_store import OutputView
from colcon_yamllaunch.terminal.full_screen.output_store import plain
from colcon_yamllaunch.terminal.full_screen.part_list import SCROLLING
from rich.cells import cell_len
from rich.style import Style
from rich.text import Text
from textual.binding import BindingType
from textual.geometry import Size
from textual.message import Message
from textual.scroll_view import ScrollView
from textual.strip import Strip

_LABEL_STYLES = (
    *('cyan', 'green', 'magenta', 'blue', 'yellow'),
    *('bright_cyan', 'bright_green', 'bright_magenta', 'bright_blue'),
)
_FOUND = Style(reverse=True, bold=True)
_TABS = 8


class OutputPane(ScrollView, can_focus=True):
    """
    The output, of which only the visible lines are drawn.

    A long line takes several rows, as on any terminal. The pane follows the
    end until the user scrolls up; then it stays where the user looks.
    """

    BINDINGS: ClassVar[list[BindingType]] = SCROLLING

    class Followed(Message):
        """The end of the output came into sight or left it."""

    def __init__(self, view: OutputView) -> None:
        super().__init__(id='output')
        self._view = view
        self._styles: dict[str, str] = {}
        self._index = RowIndex()
        self._dropped = 0
        # what the rows of lines depend on
        self._layout: tuple[object, ...] = ()
        # the line that was rendered last, as it was then
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

    def action_move(self, rows: int) -> None:
        """Go a bit."""
        self.scroll_to(y=self.scroll_offset.y + rows, animate=False)

    def action_page(self, pages: int) -> None:
        """Go a screen up or down."""
        rows = pages * max(1, self.size.height - 1)
        self.scroll_to(y=self.scroll_offset.y + rows, animate=False)

    def action_begin(self) -> None:
        """Go to the first line."""
        self.scroll_to(y=0, animate=False)

    def action_end(self) -> None:
        """Go to the last line, and stay there."""
        self._go(self.max_scroll_y)

    def render_line(self, y: int) -> Strip:
        """Draw a row of the screen."""
        width = self._columns
        row = self.scroll_offset.y + y
        lines = self._view.lines
        number, part = self._index.at(row)
        if number >= min(len(lines), len(self._index)):
            return Strip.blank(self.size.width, self.rich_style)
        if not y:
            self._top = lines[number]
        strip = self._strip_of(lines[number])
        begin = part * width
        return strip.crop_extend(begin, begin + width, self.rich_style)

    @property
    def _columns(self) -> int:
        """The cells of a row."""
        return max(1, self.scrollable_content_region.width)

    @property
    def _names(self) -> bool:
        """Whether lines say whose they are."""
        return len(self._view.filtering.only) != 1

    def _go(self, row: int) -> None:
        self.scroll_to(y=row, animate=False, force=True)

    def _rows_of(self, line: Line, width: int) -> int:
        cells = cell_len(plain(line.text).expandtabs(_TABS))
        cells += sum(map(cell_len, self._prefix_of(line)))
        return max(1, -(-cells // width))

    def _prefix_of(self, line: Line) -> tuple[str, str, str]:
        """Return the time, the label and the count in front of a line."""
        moment = label = count = ''
        if self._view.filtering.times and line.time:
            clock = time.strftime('%H:%M:%S', time.localtime(line.time))
            moment = f'{clock}.{int(line.time % 1 * 1000):03} '
        if line.label is not None and self._names:
            label = f'[{one_line(line.label)}] '
        if line.count > 1:
            # in front, as it would not be seen behind a long line
            count = f'×{line.count} '
        return moment, label, count

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
        moment, label, count = self._prefix_of(line)
        text.append(moment, 'dim')
        if line.label is not None:
            text.append(label, self._style_of(line.label))
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

    def _style_of(self, label: str) -> str:
        style = self._styles.get(label)
        if style is None:
            style = _LABEL_STYLES[len(self._styles) % len(_LABEL_STYLES)]
            self._styles[label] = style
        return style


class RowIndex:
    """The rows of lines, where a long line takes several."""

    def __init__(self) -> None:
        # for each line the rows up to it, with those of lines that are gone
        self._ends: list[int] = []
        self._gone = 0

    def __len__(self) -> int:
        return len(self._ends)

    @property
    def rows(self) -> int:
        """The rows of all lines."""
        return self._ends[-1] - self._gone if self._ends else 0

    def add(self, rows: int) -> None:
        """Add the rows of the next line."""
        self._ends.append(self._gone + self.rows + rows)

    def alter(self, line: int, rows: int) -> None:
        """Change how many rows a line has."""
        more = rows - (self._ends[line] - self._gone - self.first_row(line))
        if more:
            for number in range(line, len(self._ends)):
                self._ends[number] += more

    def drop(self, lines: int) -> int:
        """Remove the first lines, and return how many rows they had."""
        if not lines or not self._ends:
            return 0
        before = self._gone
        self._gone = self._ends[min(lines, len(self._ends)) - 1]
        del self._ends[:lines]
        return self._gone - before

    def first_row(self, line: int) -> int:
        """Return the number of the first row that a line is shown in."""
        return (self._ends[line - 1] if line else self._gone) - self._gone

    def at(self, row: int) -> tuple[int, int]:
        """Return the line of a row, and which of its rows that is."""
        line = bisect_right(self._ends, row + self._gone)
        return line, row - self.first_row(line)
