# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The keymap of both views: the status block and the full screen.

Each key stands here once, with its name, its help, and the text for the line
of keys. `keys.Keys` and `key_acts.KeyActs` execute the keys of the status
block; the full screen executes a key by its method `action_NAME`.
"""

from collections.abc import Iterable
from typing import Literal

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.terminal.keyboard import ESCAPE_NAME

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
    A key and its help.

    :param short: Its effect in a word, for the line of keys
    :param text: Its effect in a sentence
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

# what the library calls keys that are no letters, and others that do the same
_NAMES = {'/': 'slash', '?': 'question_mark', 'o': 'o,enter'}


@dataclass(frozen=True, slots=True)
class Key:
    """
    A key of the full screen.

    :param keys: The library's name for it; several with commas
    :param action: The name of its method, see the module; empty for keys that
      share one
    :param meaning: Its text; without `short`, it is in the help only
    """

    keys: str
    action: str
    meaning: Meaning


def _shared(action: str, meaning: Meaning) -> Key:
    return Key(_NAMES.get(meaning.key, meaning.key), action, meaning)


def _own(keys: str, action: str, key: str, short: str, text: str) -> Key:
    return Key(keys, action, Meaning(key, short, text))


#: For the process or component that the cursor is on.
ON_ONE = (
    *(_shared(action, meaning) for action, meaning in FOR_ONE.items()),
    _own('space', 'choose', 'space', '', 'show its output beside others'),
)
#: For all of them.
ON_ALL = (
    *(_shared(action, meaning) for action, meaning in FOR_ALL.items()),
    _own('p', 'plan', 'p', 'plan', 'show the plan as a tree, or the list'),
    _own('colon', 'find', ':', '', 'go to a process by a part of its name'),
    _own('1,2,3,4,5,6,7,8,9,0', '', '1…9 0', '', 'go to one of the first ten'),
    _own('f', 'failed', 'f', '', 'go to the next that failed'),
    _own('tab', 'switch', 'Tab', 'switch', 'go to the other pane'),
    _own('escape', 'clear', 'Esc', '', 'show all again'),
    _own('q', 'leave', 'q', 'leave', 'leave'),
)

#: The keys of the status block, and their help.
BLOCK_HELP = (
    ('1 … Z', 'choose the process with this key'),
    (':', 'choose one by a part of its name; Tab completes it'),
    *((m.key, f'then {m.text}') for m in FOR_ONE.values()),
    ('Esc', 'choose none; without one chosen, show all again'),
    *((m.key, m.text) for m in FOR_ALL.values()),
    ('Enter', 'end a line, to tell what comes from what was'),
    ('q', 'stop the launch, as Ctrl-C does; once more hurries'),
    (ESCAPE_NAME, 'go back from the process that is typed at'),
)


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
