# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The output of a launch, as users see it."""

from collections.abc import Callable, Iterable, Iterator, Mapping
import logging
import time
import warnings

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.lines import (
    colourless,
    legible,
    normalised,
    prefixed,
)
from colcon_yamllaunch.engine.writer import Writer
from colcon_yamllaunch.plan.plan import Process, SHOWN

#: The variable for the screen.
SCREEN_FORMAT = 'OVERRIDE_LAUNCH_SCREEN_FORMAT'
#: The variable for the log of the whole launch.
LOG_FORMAT = 'OVERRIDE_LAUNCH_LOG_FORMAT'

_ALIASES = {
    'default': None,
    'default_with_timestamp': (
        '{created:.7f} [{levelname}] [{name}]: {message}'
    ),
}

#: Lines that are held back at most to see how a traceback ends.
LONGEST = 500

#: Bytes of the last line of a traceback that are shown.
_WIDTH = 80
_START = b'Traceback (most recent call last):'
# in front of a traceback that follows from another one (Python, traceback)
_LINKS = (
    b'During handling of the above exception, another exception occurred:',
    b'The above exception was the direct cause of the following exception:',
)
# exceptions that end a node that was asked to stop; rclpy raises the second
_ENDS = (
    b'KeyboardInterrupt',
    b'rclpy.executors.ExternalShutdownException',
)


class InterruptFolding:
    """Shortens a traceback that only says that a process stops to one line."""

    def __init__(self) -> None:
        self._stopping: set[str] = set()
        self._streams: dict[tuple[str, events.Stream], _Stream] = {}

    def note(self, event: events.Event) -> None:
        """Note which process was asked to stop."""
        if isinstance(event, events.Signalled):
            self._stopping.add(event.process.label)
        elif isinstance(event, events.Started):
            self._stopping.discard(event.process.label)

    def fold(self, label: str, stream: events.Stream, data: bytes) -> bytes:
        """
        Return the lines to show: of `data`, and of lines held back before.

        :param data: Lines that end with a line feed, maybe but the last
        """
        if label not in self._stopping:
            return data
        key = (label, stream)
        lines = self._streams.setdefault(key, _Stream())
        return b''.join(
            shown
            for line in data.splitlines(keepends=True)
            for shown in lines.feed(line)
        )

    def rest(self, label: str) -> Iterator[tuple[events.Stream, bytes]]:
        """Return the lines held back of a process that has ended."""
        for key in [key for key in self._streams if key[0] == label]:
            held = self._streams.pop(key).held
            if held:
                yield key[1], b''.join(held)


class _Stream:
    def __init__(self) -> None:
        #: What may become one line.
        self.held: list[bytes] = []
        self._is_folded = False

    def feed(self, line: bytes) -> Iterator[bytes]:
        """Return the lines to show after one more line."""
        text = line.rstrip()
        is_start = text == _START
        if not self.held and not is_start and not self._is_folded:
            yield line
            return
        self.held.append(line)
        if is_start:
            self._is_folded = False
        elif self._is_folded:
            # what follows may be a traceback that follows from the first
            if text and text not in _LINKS:
                yield from self._release()
            return
        elif text.startswith(_ENDS):
            count = len(self.held) - 1
            self.held = []
            self._is_folded = True
            more = b' (after a traceback of %d lines)\n' % count
            yield text[:_WIDTH] + more
            return
        elif text and not text.startswith((b' ', *_LINKS)):
            yield from self._release()
            return
        if len(self.held) > LONGEST:
            yield from self._release()

    def _release(self) -> list[bytes]:
        held = self.held
        self.held = []
        self._is_folded = False
        return held


class Layout:
    """
    The form of the launcher's own lines, if the user sets one.

    The variables, their aliases and fields are those of ROS 2
    (`launch.logging.LaunchConfig`): a format of :class:`logging.Formatter` in
    `{` style, in which backslash escapes stand for characters. As in ROS 2,
    the output of processes has a form of its own.

    :param text: A format in `{` style
    :param now: Returns the time in seconds since the epoch
    :raises ValueError: when it is no such format, or has an unknown field
    """

    def __init__(
        self, text: str, now: Callable[[], float] = time.time
    ) -> None:
        self._formatter = logging.Formatter(text, style='{')
        self._now = now
        self(__name__, 'INFO', 'a first line shows whether it works')

    def __call__(self, name: str, level: str, text: str) -> str:
        """Return a line."""
        number = logging.getLevelName(level)
        record = logging.LogRecord(name, number, '', 0, text, None, None)
        record.created = self._now()
        record.msecs = record.created % 1 * 1000
        return self._formatter.format(record)


def layout_of(
    variable: str,
    environment: Mapping[str, str],
    warn: Callable[[str], None],
) -> Layout | None:
    """Return the format that a variable sets, or None for the default."""
    value = environment.get(variable)
    if not value:
        return None
    try:
        text = _ALIASES.get(value, value)
        return None if text is None else Layout(_unescaped(text))
    except (ValueError, TypeError, LookupError, AttributeError) as error:
        warn(
            f"{variable} is ignored, as '{value}' is no format: {error}; one "
            'is written as [{levelname}] [{name}]: {message}'
        )
        return None


def _unescaped(text: str) -> str:
    # what latin-1 does not have stays as it is
    data = text.encode('latin1', 'backslashreplace')
    with warnings.catch_warnings():
        # an unknown escape stays as it is written
        warnings.simplefilter('ignore', DeprecationWarning)
        return data.decode('unicode_escape')


_RESET = '\x1b[0m'
_DIM = '\x1b[2m'
_ALARM = '\x1b[1;31m'
# without red, which means failure, and black and white, which may be the
# background
_COLOURS = tuple(
    f'\x1b[{code}m' for code in (36, 33, 35, 32, 34, 96, 93, 95, 92, 94)
)
_LEVEL_COLOURS = {
    'WARNING': '\x1b[33m',
    'ERROR': '\x1b[31m',
    'CRITICAL': '\x1b[1;31m',
}


class Screen:
    """
    Shows the output of a launch, and the launcher's own lines.

    :param processes: The processes of the plan, in its order
    :param color: Whether to use colours
    :param terminal: Whether control characters could do harm
    :param colourless: Whether to remove the colours of processes
    :param layout: The format of the launcher's own lines, or None for the
      default
    """

    def __init__(
        self,
        writer: Writer,
        processes: Iterable[Process],
        *,
        color: bool,
        terminal: bool,
        colourless: bool = False,
        layout: Layout | None = None,
    ) -> None:
        self._writer = writer
        self._color = color
        self._terminal = terminal
        self._colourless = colourless
        self._layout = layout
        self._is_mid_line = False
        self._folding = InterruptFolding()
        # the characters of a prefix
        self._width = len(f'[{events.LAUNCHER}] ')
        self._names: dict[str, str] = {}
        self._prefixes: dict[str, bytes] = {}
        #: Returns the prefix of the output of processes, if it has one.
        self.stamp: Callable[[], bytes] | None = None
        self._expect(processes)

    def handle(self, event: events.Event) -> None:
        """Show an event of the launch."""
        self._folding.note(event)
        if isinstance(event, events.Exited):
            self.end_output(event.process)
        if isinstance(event, events.Output):
            process = event.process
            if event.stream in SHOWN[process.output]:
                data = normalised(event.data)
                data = self._folding.fold(process.label, event.stream, data)
                self._show_lines(process, event.stream, data)
        elif isinstance(event, events.MessageShown):
            self._show_message(event)
        else:
            if isinstance(event, events.ChangeReported) and event.details:
                self._show_text('', event.details)
            for line in event.lines():
                self._show_launcher_line(line, event.severity, event.label)
        if isinstance(event, events.Exited | events.Ended):
            self._writer.flush()

    def say(self, line: str) -> None:
        """Show a line of the launcher itself."""
        self._show_launcher_line(line, 'INFO')

    def show_table(self, lines: Iterable[str]) -> None:
        """Show lines below one another, the first as a heading."""
        for number, line in enumerate(map(one_line, lines)):
            dim = self._color and number == 0
            self._show_text('', f'{_DIM}{line}{_RESET}' if dim else line)

    def show_raw(self, key: object, data: bytes) -> None:
        """
        Show something as it is, which may end in the middle of a line.

        What :meth:`handle` shows next begins on a line of its own all the
        same.

        :param key: Where it comes from, see :class:`.writer.Writer`
        """
        self._writer.write_raw(key, data)
        self._is_mid_line = not data.endswith((b'\n', b'\r'))

    def end_line(self) -> None:
        """End the line that was shown in part, if there is one."""
        if self._is_mid_line:
            self._writer.write(None, b'\n')
            self._is_mid_line = False

    def end_output(self, process: Process) -> None:
        """Show the lines held back of a process that has ended."""
        for stream, data in self._folding.rest(process.label):
            self._show_lines(process, stream, data)

    def rendered(self, process: Process, data: bytes) -> bytes:
        """Return how lines of a process are shown."""
        data = legible(data, self._terminal)
        if self._colourless:
            data = colourless(data)
        if process.label not in self._prefixes:
            # the process was added while the launch ran
            self._expect((process,))
        prefix = self._prefixes[process.label]
        if self.stamp is not None:
            prefix = self.stamp() + prefix
        return prefixed(data, prefix, reset=self._color or self._terminal)

    def _show_lines(
        self, process: Process, stream: events.Stream, data: bytes
    ) -> None:
        data = self.rendered(process, data)
        self._write((process.label, stream), data)

    def _show_message(self, event: events.MessageShown) -> None:
        if event.level == 'DEBUG':
            return
        if self._layout is not None:
            text = self._layout(events.MESSENGER, event.level, event.text)
            self._show_text('', text)
            return
        colour = _LEVEL_COLOURS.get(event.level, '')
        tag = f'[{event.level}]'
        if self._color and colour:
            tag = f'{colour}{tag}{_RESET}'
        prefix = f'{tag} [{events.MESSENGER}]: '
        self._show_text(prefix, event.text, is_foreign=True)

    def _expect(self, processes: Iterable[Process]) -> None:
        """Make room for the names of processes; others keep their colour."""
        for process in processes:
            # a user who sets a format of ROS 2 expects its names
            is_own = self._layout is None
            name = process.label if is_own else process.ros_name
            self._names[process.label] = f'[{one_line(name)}]'
        longest = max(map(len, self._names.values()), default=0)
        most = len('[] ') + limits.LABEL_CHARACTERS
        self._width = max(self._width, min(longest + 1, most))
        for index, (label, name) in enumerate(self._names.items()):
            padding = ' ' * (self._width - len(name)) or ' '
            if self._color:
                colour = _COLOURS[index % len(_COLOURS)]
                name = f'{colour}{name}{_RESET}'
            prefix = (name + padding).encode(errors='replace')
            self._prefixes[label] = prefix

    def _show_launcher_line(
        self, line: str, severity: str, name: str = events.LAUNCHER
    ) -> None:
        # overwrite the ^C that the terminal shows at the start of the line
        start = '\r' if self._terminal else ''
        line = one_line(line)
        label = f'[{name}]'.ljust(self._width)
        if self._layout is not None:
            label = ''
            line = self._layout(name, severity, line)
        if self._color:
            colour = _DIM if severity == 'INFO' else _ALARM
            line = f'{colour}{label}{line}{_RESET}'
            label = ''
        self._show_text(start + label, line)

    def _show_text(
        self, prefix: str, text: str, *, is_foreign: bool = False
    ) -> None:
        """
        Show lines.

        :param is_foreign: Whether a launch file wrote them, with its colours
        """
        data = text.encode(errors='replace')
        data = legible(normalised(data), self._terminal)
        if is_foreign and self._colourless:
            data = colourless(data)
        self._write(None, prefixed(data, prefix.encode(), reset=is_foreign))

    def _write(self, key: object, data: bytes) -> None:
        if data:
            self.end_line()
        self._writer.write(key, data)
