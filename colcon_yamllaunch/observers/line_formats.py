# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The format of the launcher's own lines, if the user sets one.

The variables, their aliases and fields are those of ROS 2
(`launch.logging.LaunchConfig`): a format of :class:`logging.Formatter` in
`{` style, in which backslash escapes stand for characters. As in ROS 2, the
output of processes has a form of its own.
"""

from collections.abc import Callable
from collections.abc import Mapping
import logging
import time
import warnings

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


class Layout:
    """
    The form of a line.

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
