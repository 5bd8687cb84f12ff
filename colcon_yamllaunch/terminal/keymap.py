# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The keymap of both views: the status block and the full screen.

A row has a key, its help, and its effect: the command that it sends, or the
change of the filter. Both views execute these; so a new key is a row, and no
more. A row without either is for a method `key_NAME` of the view, which gets
the label that the key is for. A view may show the response to a command in
its own way, by a method `after_NAME`, which gets both.
"""

from collections.abc import Callable
from collections.abc import Iterable
from typing import Any

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine import commands
from colcon_yamllaunch.engine.commands import Command
from colcon_yamllaunch.engine.state import ComponentState
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.engine.state import Part
from colcon_yamllaunch.engine.state import ProcessState
from colcon_yamllaunch.terminal.keyboard import ESCAPE_NAME
from colcon_yamllaunch.terminal.line_filter import Filtering


@dataclass(frozen=True, slots=True)
class Key:
    """
    A key.

    :param key: The key as the help has it
    :param name: The name of its effect
    :param short: Its effect in a word, for the line of keys; empty for a key
      that stands in the help only
    :param text: Its effect in a sentence, for the help
    :param command: Returns the command that it sends: from the label that it
      is for, or from the state of the launch if it is for all
    :param filter: Returns the filter that it makes of another one, likewise
    :param for_components: Whether it has an effect on components
    :param names: What the library of the full screen calls it, separated by
      commas, if that is something else
    """

    key: str
    name: str
    short: str
    text: str
    command: Callable[[Any], Command[Any]] | None = None
    filter: Callable[[Filtering, Any], Filtering] | None = None
    for_components: bool = True
    names: str = ''


#: For one process or component.
FOR_ONE = (
    Key(
        's',
        'stop',
        'stop',
        'stop it, or unload it; once more hurries',
        command=commands.Stop,
    ),
    Key(
        'r',
        'restart',
        'restart',
        'start it, or load it, anew',
        command=commands.Restart,
    ),
    Key(
        'k',
        'kill',
        'kill',
        'kill it with all that it started',
        command=commands.Kill,
        for_components=False,
    ),
    Key(
        'a',
        'attach',
        'attach',
        'type at it; it needs a terminal (emulate_tty, --tty)',
        for_components=False,
    ),
    Key(
        'm',
        'mute',
        'mute',
        'mute it, or unmute it',
        filter=Filtering.mute,
        for_components=False,
    ),
    Key(
        'o',
        'only',
        'only',
        'show its output alone, or that of all',
        filter=Filtering.show_alone,
        for_components=False,
        names='o,enter',
    ),
    Key(
        'd',
        'debug',
        'debug',
        'start it anew under gdb, or pdb if it is in Python',
        command=commands.Debug,
        for_components=False,
    ),
    Key('l', 'log', 'log', 'show its log in $PAGER'),
    Key(
        'i',
        'describe',
        'info',
        'show what it is, and all it was given',
        command=commands.Describe,
    ),
)


def _labels(state: LaunchState) -> Iterable[str]:
    return (process.label for process in state.processes)


def _switched(state: LaunchState) -> Command[Any]:
    return commands.Watch('resume' if state.watch_paused else 'pause')


#: For all of them.
FOR_ALL = (
    Key(
        '/',
        'search',
        'search',
        'show lines with a text only, as it is typed',
        names='slash',
    ),
    Key(
        'L',
        'level',
        'level',
        'show INFO and worse only; then WARN, ERROR, FATAL, all',
        filter=lambda filtering, _: filtering.next_level(),
    ),
    Key(
        't',
        'times',
        'times',
        'show the time of each line, or no more',
        filter=lambda filtering, _: filtering.switch_times(),
    ),
    Key(
        'M',
        'mute_all',
        'mute',
        'mute all, or unmute all',
        filter=lambda filtering, state: filtering.mute_all(_labels(state)),
    ),
    Key(
        'w',
        'watch',
        'watch',
        'switch --watch off, or on again',
        command=_switched,
    ),
    Key(
        'E',
        'errors',
        'errors',
        'show the errors of the last build that failed',
    ),
    Key('?', 'help', 'help', 'show what the keys do', names='question_mark'),
)

#: Further keys of the full screen, for what the cursor is on.
SCREEN_ONE = (
    Key(
        'space',
        'choose',
        '',
        'show its output beside others',
        filter=Filtering.show_beside,
        for_components=False,
    ),
)
#: Further keys of the full screen, for all.
SCREEN_ALL = (
    Key('p', 'plan', 'plan', 'show the plan as a tree, or the list'),
    Key(
        ':',
        'find',
        '',
        'go to a process by a part of its name',
        names='colon',
    ),
    Key(
        '1…9 0',
        'go',
        '',
        'go to one of the first ten',
        names='1,2,3,4,5,6,7,8,9,0',
    ),
    Key('f', 'failed', '', 'go to the next that failed'),
    Key('Tab', 'switch', 'switch', 'go to the other pane', names='tab'),
    Key('Esc', 'clear', '', 'show all again', names='escape'),
    Key('q', 'leave', 'leave', 'leave'),
)
#: All keys of the full screen.
ON_ONE, ON_ALL = (*FOR_ONE, *SCREEN_ONE), (*FOR_ALL, *SCREEN_ALL)

#: Further keys of the status block.
_CHOOSE = (
    Key('1 … Z', 'choose', '', 'choose the process with this key'),
    Key(':', 'find', '', 'choose one by a part of its name; Tab completes it'),
)
_CLEAR = Key(
    'Esc', 'clear', '', 'choose none; without one chosen, show all again'
)
_GENERAL = (
    Key('Enter', 'break', '', 'end a line, to tell what comes from what was'),
    Key(
        'q',
        'quit',
        'stop',
        'stop the launch, as Ctrl-C does; once more hurries',
    ),
    Key(
        ESCAPE_NAME,
        'detach',
        '',
        'go back from the process that is typed at',
    ),
)
#: The keys of the status block without one chosen, by name.
BLOCK_ALL = {key.name: key for key in (*FOR_ALL, *_GENERAL)}
#: The help of the status block.
BLOCK_HELP = (
    *((key.key, key.text) for key in _CHOOSE),
    *((key.key, f'then {key.text}') for key in FOR_ONE),
    *((key.key, key.text) for key in (_CLEAR, *FOR_ALL, *_GENERAL)),
)


def without_effect(state: LaunchState, part: Part | None) -> set[str]:
    """Return the names of keys that can do nothing now."""
    found = set()
    if state.watch is None:
        found.add('watch')
    if not state.errors:
        found.add('errors')
    if isinstance(part, ComponentState):
        found |= {key.name for key in ON_ONE if not key.for_components}
    elif part is not None and not part.terminal:
        found.add('attach')
    return found


def only_its_container_writes(label: str) -> str:
    """Return why the output of a component is neither shown nor hidden."""
    return f'{label} is a component: its container writes'


def cannot_be_typed_at(part: Part) -> str:
    """Return why a process or component takes no keys, and the way out."""
    if not isinstance(part, ProcessState):
        return f'{part.label} is a component: it has no keyboard'
    if part.pid is None:
        return f'{part.label} does not run'
    return f'{part.label} has no terminal; emulate_tty or --tty gives it one'
