# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which severity a line of output has, as the loggers of ROS 2 write it."""

import re

#: The severities of ROS 2 (rcl_interfaces/Log), the least one first.
LEVELS = ('DEBUG', 'INFO', 'WARN', 'ERROR', 'FATAL')
DEBUG, INFO, WARN, ERROR, FATAL = range(len(LEVELS))

_COLOURS = re.compile(r'\x1b\[[0-9;:]*m')
# in brackets wherever a format of RCUTILS_CONSOLE_OUTPUT_FORMAT has it, or at
# the start, as by Python's logging
_LEVEL = re.compile(
    r'.{0,80}?\[ *(DEBUG|INFO|WARN|WARNING|ERROR|FATAL|CRITICAL) *\]'
    r'|(DEBUG|INFO|WARN|WARNING|ERROR|FATAL|CRITICAL)\b[ :]'
)
_NUMBERS = {
    'DEBUG': DEBUG,
    'INFO': INFO,
    'WARN': WARN,
    'WARNING': WARN,
    'ERROR': ERROR,
    'FATAL': FATAL,
    'CRITICAL': FATAL,
}


def plain(text: str) -> str:
    """Return a line without colours."""
    return _COLOURS.sub('', text) if '\x1b' in text else text


def level_of(text: str) -> int | None:
    """Return the severity of a line, None where it does not say one."""
    match = _LEVEL.match(plain(text))
    return None if match is None else _NUMBERS[match[1] or match[2]]


def level_named(name: str) -> int:
    """Return the severity that an event has by name."""
    return _NUMBERS.get(name, INFO)
