# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is measured of a run: found in the output of its processes."""

from collections.abc import Iterable
from contextlib import suppress
import re

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.output.line_pattern import LinePattern
from colcon_yamllaunch.engine.output.line_pattern import SearchTimeError
from colcon_yamllaunch.engine.output.lines import bare

#: Characters of a value that are kept.
_LONGEST_VALUE = 200
_NAME = re.compile(r'[^\W\d][\w ./%()-]*')


@dataclass(frozen=True, slots=True)
class Metric:
    """
    A metric.

    :param name: What it is called
    :param pattern: Its first group is the value
    """

    name: str
    pattern: LinePattern


def read_metric(option: str, text: str) -> Metric:
    """
    Read what the user wrote, `name=regex`.

    :param option: The option that has it
    :raises UserError: when it is none
    """
    name, is_given, expression = text.partition('=')
    name = name.strip()
    if not is_given or not expression:
        raise UserError(
            f"{option} is written name=REGEX, not '{text}'",
            r"such as 'distance=drove ([\d.]+) m'",
        )
    if not _NAME.fullmatch(name):
        raise UserError(
            f"{option}: '{name}' is no name of a metric",
            'it begins with a letter',
        )
    try:
        pattern = LinePattern(expression)
    except (re.error, OverflowError, RecursionError) as e:
        raise UserError(
            f"{option}: '{expression}' is no regular expression: {e}"
        ) from e
    if not pattern.groups:
        raise UserError(
            f"{option}: '{expression}' has no group, so nothing says which "
            'part of the line is the value',
            r"put that in brackets, as in 'drove ([\d.]+) m'",
        )
    return Metric(name, pattern)


class MetricSearch:
    """
    Listens to a launch for its metrics; the last line that matches counts.

    :param metrics: What is searched for
    """

    def __init__(self, metrics: Iterable[Metric]) -> None:
        self._metrics = tuple(metrics)
        #: The values that were found, by the names of their metrics.
        self.found: dict[str, str] = {}

    def handle(self, event: events.Event) -> None:
        """Listen to an event."""
        if not self._metrics or not isinstance(event, events.Output):
            return
        lines = bare(event.data)
        for metric in self._metrics:
            # a line that takes too long has no value
            with suppress(SearchTimeError):
                value = metric.pattern.last_group(lines)
                if value is not None:
                    self.found[metric.name] = value[:_LONGEST_VALUE]
