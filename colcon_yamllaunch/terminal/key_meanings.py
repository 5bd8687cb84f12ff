# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What keys do that are the same below the output and on the full screen.

Each of both has some more, and its own way to choose what they are for.
"""

from collections.abc import Iterable
from typing import Literal

from colcon_yamllaunch.common.frozen import dataclass

#: What is done with one process or component.
OneAction = Literal[
    'stop',
    'restart',
    'kill',
    'attach',
    'mute',
    'only',
    'debug',
    'log',
    'describe',
]


@dataclass(frozen=True, slots=True)
class Meaning:
    """
    What a key means.

    :param short: That in a word
    :param text: That in a sentence
    """

    key: str
    short: str
    text: str


#: For one process or component.
FOR_ONE: dict[OneAction, Meaning] = {
    'stop': Meaning('s', 'stop', 'stop it, or unload it; once more hurries'),
    'restart': Meaning('r', 'restart', 'start it, or load it, anew'),
    'kill': Meaning('k', 'kill', 'kill it with all that it started'),
    'attach': Meaning(
        'a',
        'attach',
        'type at it; it needs a terminal (emulate_tty, --tty)',
    ),
    'mute': Meaning('m', 'mute', 'mute it, or unmute it'),
    'only': Meaning('o', 'only', 'show its output alone, or that of all'),
    'debug': Meaning(
        'd', 'debug', 'start it anew under gdb, or pdb if it is in Python'
    ),
    'log': Meaning('l', 'log', 'show its log in $PAGER'),
    'describe': Meaning('i', 'info', 'show what it is, and all it was given'),
}
#: For all of them.
FOR_ALL: dict[str, Meaning] = {
    'search': Meaning(
        '/', 'search', 'show lines with a text only, as it is typed'
    ),
    'level': Meaning(
        'L', 'level', 'show INFO and worse only; then WARN, ERROR, FATAL, all'
    ),
    'times': Meaning('t', 'times', 'show the time of each line, or no more'),
    'mute_all': Meaning('M', 'mute', 'mute all, or unmute all'),
    'watch': Meaning('w', 'watch', 'switch --watch off, or on again'),
    'errors': Meaning(
        'E', 'errors', 'show the errors of the last build that failed'
    ),
    'help': Meaning('?', 'help', 'show what the keys do'),
}


def hint(meanings: Iterable[Meaning]) -> str:
    """Return keys with a word for each, in one line."""
    return '  '.join(f'{m.key} {m.short}' for m in meanings)


def only_its_container_writes(label: str) -> str:
    """Say why there is no output of a component to be shown or not."""
    return f'{label} is a component: its container writes'


def cannot_be_typed_at(label: str, *, is_process: bool, runs: bool) -> str:
    """Say why a process, or a component, takes no keys, and the way out."""
    if not is_process:
        return f'{label} is a component: it has no keyboard'
    if not runs:
        return f'{label} does not run'
    return f'{label} has no terminal; emulate_tty or --tty gives it one'
