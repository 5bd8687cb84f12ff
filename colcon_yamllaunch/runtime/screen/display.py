# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The stream that a launch is shown on: its kind, colours and writer."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
from typing import TextIO

from colcon_yamllaunch.language.plan.plan import Process
from colcon_yamllaunch.runtime.screen.line_formats import layout_of
from colcon_yamllaunch.runtime.screen.line_formats import SCREEN_FORMAT
from colcon_yamllaunch.runtime.screen.screen import Screen
from colcon_yamllaunch.runtime.streams.writer import TextWriter
from colcon_yamllaunch.runtime.streams.writer import Writer

# whether the nodes of ROS 2 use colours; unset, they do on a terminal
_NODES_COLOUR = 'RCUTILS_COLORIZED_OUTPUT'


class Display:
    """
    Where a launch is shown.

    :param color: Whether it is coloured; by default on a terminal, unless
      `NO_COLOR` is set or `TERM` is dumb
    :param environment: The environment for all processes
    """

    def __init__(
        self,
        stream: TextIO,
        color: bool | None,
        environment: Mapping[str, str],
    ) -> None:
        #: Whether it is a terminal.
        self.terminal = stream.isatty()
        #: The descriptor of the stream, or -1.
        self.descriptor = _descriptor(stream)
        is_plain = color is False
        if color is None:
            color = self.terminal and _wants_color(environment)
        self._color = color
        self._is_plain = is_plain
        #: The environment, and what makes output show at once and in colour.
        self.environment = self.environment_for(environment)
        #: Writes to the stream.
        self.writer = _writer(stream, self.descriptor)

    def environment_for(
        self, environment: Mapping[str, str]
    ) -> dict[str, str]:
        """Add to an environment what makes output show as the user likes."""
        return _process_environment(environment, self._color, self._is_plain)

    def screen(
        self, processes: Iterable[Process], warn: Callable[[str], None]
    ) -> Screen:
        """
        Return what shows a launch.

        :param processes: All that may be started, in the order of the plan
        :param warn: Is told of a format that makes no sense
        """
        nodes_colour = self.environment.get(_NODES_COLOUR) == '1'
        return Screen(
            self.writer,
            processes,
            color=self._color,
            terminal=self.terminal,
            colourless=not self._color and not nodes_colour,
            layout=layout_of(SCREEN_FORMAT, self.environment, warn),
        )


def _wants_color(environment: Mapping[str, str]) -> bool:
    # https://no-color.org: any value but the empty one
    return (
        not environment.get('NO_COLOR') and environment.get('TERM') != 'dumb'
    )


def _process_environment(
    environment: Mapping[str, str], color: bool, plain: bool
) -> dict[str, str]:
    """
    Add what makes output show at once, and in colour or not.

    :param color: Whether colours are welcome
    :param plain: Whether the user has said that they are not
    """
    result = {'PYTHONUNBUFFERED': '1', 'RCUTILS_LOGGING_BUFFERED_STREAM': '1'}
    if color:
        result[_NODES_COLOUR] = '1'
    result.update(environment)
    if plain:
        result['NO_COLOR'] = '1'
        result.pop(_NODES_COLOUR, None)
    return result


def _writer(stream: TextIO, descriptor: int) -> Writer:
    if descriptor == -1:
        return TextWriter(stream)
    writer = Writer(descriptor)
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
