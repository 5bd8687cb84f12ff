# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The stream that a launch is shown on: its kind, colours and writer."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
import os
from typing import TextIO

from colcon_yamllaunch.engine.writer import TextWriter
from colcon_yamllaunch.engine.writer import Writer
from colcon_yamllaunch.observers.line_formats import layout_of
from colcon_yamllaunch.observers.line_formats import SCREEN_FORMAT
from colcon_yamllaunch.observers.screen import Screen
from colcon_yamllaunch.plan.plan import Process

# the values of TERM of terminals that do no more than print
_ONLY_PRINT = frozenset((None, '', 'dumb', 'emacs', 'unknown'))
# those of terminals that have hardly more than ASCII, as a rule
_ASCII = ('linux', *(f'vt{digit}' for digit in '12345'))
# whether the nodes of ROS 2 use colours; unset, they do on a terminal
_NODES_COLOUR = 'RCUTILS_COLORIZED_OUTPUT'


class Display:
    """
    Where a launch is shown.

    :param color: Whether it is coloured; by default on a terminal, unless
      `NO_COLOR` is set or `TERM` is dumb
    :param environment: The environment for all processes
    :param open_writer: Returns what writes to the descriptor of the stream
    """

    def __init__(
        self,
        stream: TextIO,
        color: bool | None,
        environment: Mapping[str, str],
        open_writer: Callable[[int], Writer] = Writer,
    ) -> None:
        #: Whether it is a terminal.
        self.terminal = stream.isatty()
        #: The descriptor of the stream, or -1.
        self.descriptor = _descriptor(stream)
        is_plain = color is False
        if color is None:
            color = self.terminal and _wants_color(environment)
        #: Whether it is coloured.
        self.color = color
        self._is_plain = is_plain
        #: The environment, with variables for unbuffered, coloured output.
        self.environment = self.environment_for(environment)
        #: Whether it shows ASCII only.
        self.is_ascii = _is_ascii(stream, environment)
        #: Writes to the stream.
        self.writer = _writer(stream, self.descriptor, open_writer)

    def environment_for(
        self, environment: Mapping[str, str]
    ) -> dict[str, str]:
        """Return `environment` with variables for unbuffered output."""
        return _process_environment(environment, self.color, self._is_plain)

    def screen(
        self, processes: Iterable[Process], warn: Callable[[str], None]
    ) -> Screen:
        """
        Return the screen that shows a launch here.

        :param processes: Its processes, in the order of the plan
        :param warn: Is called with a warning about an invalid format
        """
        nodes_colour = self.environment.get(_NODES_COLOUR) == '1'
        return Screen(
            self.writer,
            processes,
            color=self.color,
            terminal=self.terminal,
            colourless=not self.color and not nodes_colour,
            layout=layout_of(SCREEN_FORMAT, self.environment, warn),
        )


def can_have_status(stream: TextIO, environment: Mapping[str, str]) -> bool:
    """
    Return whether a stream is a terminal that can show a status block.

    A service for continuous integration shows a terminal as a log, which
    keeps everything that was drawn.
    """
    return (
        stream.isatty()
        and _descriptor(stream) != -1
        and not only_prints(environment)
        and not environment.get('CI')
    )


def only_prints(environment: Mapping[str, str]) -> bool:
    """Return whether the terminal can only print."""
    return environment.get('TERM') in _ONLY_PRINT


def is_same_terminal(stream: TextIO | None, descriptor: int) -> bool:
    """Return whether `stream` is the terminal that `descriptor` is."""
    try:
        if stream is None or not stream.isatty():
            return False
        return os.ttyname(stream.fileno()) == os.ttyname(descriptor)
    except (OSError, ValueError):
        return False


def _is_ascii(stream: TextIO, environment: Mapping[str, str]) -> bool:
    encoding = (getattr(stream, 'encoding', None) or '').lower()
    return not encoding.startswith('utf') or environment.get(
        'TERM', ''
    ).startswith(_ASCII)


def _wants_color(environment: Mapping[str, str]) -> bool:
    # https://no-color.org: any value but the empty one
    return (
        not environment.get('NO_COLOR') and environment.get('TERM') != 'dumb'
    )


def _process_environment(
    environment: Mapping[str, str], color: bool, plain: bool
) -> dict[str, str]:
    """
    Return `environment` with variables for unbuffered output.

    :param color: Whether processes should use colours
    :param plain: Whether the user wants none
    """
    result = {'PYTHONUNBUFFERED': '1', 'RCUTILS_LOGGING_BUFFERED_STREAM': '1'}
    if color:
        result[_NODES_COLOUR] = '1'
    result.update(environment)
    if plain:
        result['NO_COLOR'] = '1'
        result.pop(_NODES_COLOUR, None)
    return result


def _writer(
    stream: TextIO, descriptor: int, open_writer: Callable[[int], Writer]
) -> Writer:
    if descriptor == -1:
        return TextWriter(stream)
    writer = open_writer(descriptor)
    try:
        stream.flush()
    except BrokenPipeError:
        writer.broken = True
    except OSError as error:
        # what was shown before, by the build for instance
        writer.error = error
    return writer


def _descriptor(stream: TextIO) -> int:
    try:
        return stream.fileno()
    except (OSError, ValueError):
        return -1
