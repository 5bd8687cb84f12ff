# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The level of a line of output, as the loggers of ROS 2 print it.

rclcpp and rclpy print by rcutils, whose lines begin with `[INFO] [TIME]
[NODE]: ` unless RCUTILS_CONSOLE_OUTPUT_FORMAT is set (rcutils, logging.h).
"""

from enum import IntEnum
from functools import cache, lru_cache
import re

from colcon_yamllaunch.common.printable import COLOUR

#: The variable with the form of all lines of a node.
FORMAT = 'RCUTILS_CONSOLE_OUTPUT_FORMAT'

_COLOURS = rb'(?:%b)*' % COLOUR.encode()
_WORDS = rb'(?P<level>DEBUG|INFO|WARN(?:ING)?|ERROR|FATAL|CRITICAL)'
_FIELD = re.compile(r'\{(\w+)\}')


class Level(IntEnum):
    """
    The severity of a line, with the numbers of rcutils.

    Python's logging has two other names.
    """

    DEBUG = 10
    INFO = 20
    WARN = WARNING = 30
    ERROR = 40
    FATAL = CRITICAL = 50


#: Bytes at the start of a line that its level is in.
LEVEL_WITHIN = 4096
# words in a line with a level of WARN or more, by their rarest letter: finding
# no such letter takes a fortieth of the time
_LOUD_WORDS = {
    b'W': b'WARN',
    b'R': b'ERROR',
    b'T': b'FATAL',
    b'C': b'CRITICAL',
}


def may_be_loud(data: bytes) -> bool:
    """Return whether a line may have a level of WARN or more."""
    return any(
        letter in data and word in data for letter, word in _LOUD_WORDS.items()
    )


def level_of(line: bytes, form: str | None = None) -> Level | None:
    """
    Return the level of a line, None if it has none of its own.

    :param line: As it was written, colours included
    :param form: The value of :data:`FORMAT`, if it is set
    """
    match = None
    line = line[:LEVEL_WITHIN]
    if form:
        pattern = _pattern(form)
        match = None if pattern is None else pattern.match(line)
    if match is not None:
        return Level[match['level'].decode()]
    match = _usual().match(line)
    if match is None:
        return None
    if match['end']:
        return Level.ERROR
    return Level[(match['level'] or match['first']).decode()]


@cache
def _usual() -> re.Pattern[bytes]:
    """
    Return what lines match up to their level.

    It is in brackets near the start, or first of all; or what ends a node.
    Few launches need it.
    """
    return re.compile(
        rb'[^\n]{0,80}?\[' + _COLOURS + _WORDS + _COLOURS + rb'\s*\]'
        rb'|\s*'
        + _COLOURS
        + _WORDS.replace(b'level', b'first')
        + rb'(?=[\s:])'
        rb'|(?P<end>Traceback \(most recent call last\):'
        rb'|terminate called |\S+: symbol lookup error:)'
    )


@lru_cache(maxsize=16)
def _pattern(form: str) -> re.Pattern[bytes] | None:
    """Return what lines of a form match up to their level."""
    before, field, _ = form.partition('{severity}')
    if not field:
        return None
    # texts, and the names of fields between them
    first, *texts = (
        re.escape(part.encode()) for part in _FIELD.split(before)[::2]
    )
    # a field ends where the text after it is first, whatever comes then, as
    # to try all places of all of them takes for ever; but for the last one,
    # which may be followed by a word that is none
    fields = [b'(?:(?!%b).)*%b' % (text, text) for text in texts[:-1]]
    fields += [b'.*?' + text for text in texts[-1:]]
    return re.compile(_COLOURS + first + b''.join(fields) + _COLOURS + _WORDS)
