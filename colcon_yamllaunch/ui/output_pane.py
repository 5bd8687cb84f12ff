# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The pane with the output."""

import time
from typing import ClassVar

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.ui.line_levels import ERROR
from colcon_yamllaunch.ui.line_levels import WARN
from colcon_yamllaunch.ui.output_store import Line
from colcon_yamllaunch.ui.output_view import OutputView
from rich.cells import cell_len
from rich.style import Style
from rich.text import Text
from textual.binding import Binding
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
#: How far a key goes to the side.
_SIDE = 8
_TABS = 8


class OutputPane(ScrollView, can_focus=True):
    """
    Lines, of which only those are drawn that are seen.

    It stays at the end until somebody scrolls up, and with what he looks at
    from then on.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding('up', 'move(0, -1)', show=False),
        Binding('down', 'move(0, 1)', show=False),
        Binding('left', f'move(-{_SIDE}, 0)', show=False),
        Binding('right', f'move({_SIDE}, 0)', show=False),
        Binding('pageup', 'page(-1)', show=False),
        Binding('pagedown', 'page(1)', show=False),
        Binding('home', 'begin', show=False),
        Binding('end', 'end', show=False),
    ]

    class Followed(Message):
        """The end is in sight, or is no more."""

    def __init__(self, view: OutputView) -> None:
        super().__init__(id='output')
        self._view = view
        self._styles: dict[str, str] = {}
        self._version = self._dropped = 0
        self._seen = 0
        self._width = 0
        #: Whether the end is in sight, and stays so.
        self.follows = True
        #: Whether to show when each line came.
        self.timestamps = False

    def changed(self) -> None:
        """Show what is new."""
        view = self._view
        if view.version != self._version:
            self._version = view.version
            self._dropped = self._width = self._seen = 0
            self.follows = True
        gone = view.dropped - self._dropped
        self._dropped = view.dropped
        self._seen = max(0, self._seen - gone)
        for line in view.lines[self._seen :]:
            self._width = max(self._width, cell_len(line.text))
        self._seen = len(view.lines)
        prefix = self._prefix_width()
        self.virtual_size = Size(self._width + prefix, len(view.lines))
        if self.follows:
            self.scroll_to(y=self.max_scroll_y, animate=False, force=True)
        elif gone:
            y = max(0, self.scroll_offset.y - gone)
            self.scroll_to(y=y, animate=False, force=True)
        self.refresh()

    def watch_scroll_y(self, old_value: float, new_value: float) -> None:
        """See whether the end is in sight."""
        super().watch_scroll_y(old_value, new_value)
        follows = new_value >= self.max_scroll_y
        if new_value != old_value and follows != self.follows:
            self.follows = follows
            self.post_message(self.Followed())

    def action_move(self, x: int, y: int) -> None:
        """Go a bit."""
        place = self.scroll_offset
        self.scroll_to(place.x + x, place.y + y, animate=False)

    def action_page(self, pages: int) -> None:
        """Go a screen up or down."""
        rows = pages * max(1, self.size.height - 1)
        self.scroll_to(y=self.scroll_offset.y + rows, animate=False)

    def action_begin(self) -> None:
        """Go to the first line."""
        self.scroll_to(0, 0, animate=False)

    def action_end(self) -> None:
        """Go to the last line, and stay there."""
        self.scroll_to(y=self.max_scroll_y, animate=False, force=True)

    def render_line(self, y: int) -> Strip:
        """Draw a line of the screen."""
        left, top = self.scroll_offset
        width = self.size.width
        lines = self._view.lines
        if top + y >= len(lines):
            return Strip.blank(width, self.rich_style)
        text = self._text_of(lines[top + y])
        strip = Strip(text.render(self.app.console), text.cell_len)
        return strip.crop_extend(left, left + width, self.rich_style)

    @property
    def _names(self) -> bool:
        """Whether lines say whose they are."""
        return len(self._view.choice.chosen) != 1

    def _prefix_width(self) -> int:
        longest = max(map(len, self._styles), default=0) + 3
        return longest * self._names + 13 * self.timestamps

    def _text_of(self, line: Line) -> Text:
        text = Text(no_wrap=True, end='')
        if self.timestamps and line.time:
            moment = time.strftime('%H:%M:%S', time.localtime(line.time))
            text.append(f'{moment}.{int(line.time % 1 * 1000):03} ', 'dim')
        if line.label is not None and self._names:
            name = one_line(line.label)
            text.append(f'[{name}] ', self._style_of(line.label))
        if line.count > 1:
            # in front, as it would not be seen behind a long line
            text.append(f'×{line.count} ', 'bold')
        if line.is_told:
            style = 'italic bright_black'
            if line.level >= WARN:
                style = 'bold yellow' if line.level < ERROR else 'bold red'
            text.append(line.text, style)
        else:
            body = Text.from_ansi(line.text.expandtabs(_TABS), end='')
            if '\x1b' not in line.text and line.level >= WARN:
                body.stylize('yellow' if line.level < ERROR else 'red')
            for start, end in self._view.choice.places(body.plain):
                body.stylize(_FOUND, start, end)
            text.append_text(body)
        return text

    def _style_of(self, label: str) -> str:
        style = self._styles.get(label)
        if style is None:
            style = _LABEL_STYLES[len(self._styles) % len(_LABEL_STYLES)]
            self._styles[label] = style
        return style
