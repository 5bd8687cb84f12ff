# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The keymap of both views: the status block and the full screen.

A row has a key, its help, and its effect: the command that it sends, or the
change of the filter. Both views execute these, so a key for one process is one
row. A letter for all must not be one of `status_model.KEYS`, which choose
processes.

A new command is a class in `engine/commands` and a handler in
`Dispatcher.__init__`, and needs nothing else to be sent or encoded. On the
full screen the keys for one, for all and for the screen share one keyboard.

A row without either calls the method `key_NAME` of the view: of the status
block with a label or None, of the full screen with the member or the key. A
view may show the response to a command in its own way, by a method
`after_NAME`.
"""

from collections.abc import Callable
from typing import Any

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine import commands
from colcon_yamllaunch.engine.commands import Command
from colcon_yamllaunch.engine.state import (
    ComponentState,
    LaunchState,
    MemberState,
    ProcessState,
)
from colcon_yamllaunch.terminal.keyboard import ESCAPE_NAME
from colcon_yamllaunch.terminal.line_filter import Filtering


@dataclass(frozen=True, slots=True)
class Key:
    """
    A key.

    :param key: The key as the help has it
    :param name: The name of its effect
    :param text: Its effect in a sentence, for the help
    :param short: Its effect in a word, for the line of keys: by default its
      name; empty for a key that stands in the help only
    :param command: Returns the command that it sends: from the label that it
      is for, or from the state of the launch if it is for all
    :param filter: Returns the filter that it makes of another one, likewise
    :param hint_place: Its place in the hint of the status block while no
      process is chosen, from 1; 0 if the hint lacks it
    :param for_components: Whether it has an effect on components
    :param names: What the library of the full screen calls it, separated by
      commas, if that is something else
    """

    key: str
    name: str
    text: str
    short: str | None = None
    command: Callable[[Any], Command[Any]] | None = None
    filter: Callable[[Filtering, Any], Filtering] | None = None
    hint_place: int = 0
    for_components: bool = True
    names: str = ''

    @property
    def word(self) -> str:
        """Its effect in a word, empty if it stands in the help only."""
        return self.name if self.short is None else self.short


#: For one process or component.
FOR_ONE = (
    Key(
        's',
        'stop',
        'stop it, or unload it; again to force',
        command=commands.Stop,
    ),
    Key(
        'r', 'restart', 'start it, or load it, anew', command=commands.Restart
    ),
    Key(
        'k',
        'kill',
        'kill it with all that it started',
        command=commands.Kill,
        for_components=False,
    ),
    Key(
        'a',
        'attach',
        'type at it; it needs a terminal (emulate_tty, --tty)',
        for_components=False,
    ),
    Key(
        'm',
        'mute',
        'mute it, or unmute it',
        filter=Filtering.mute,
        for_components=False,
    ),
    Key(
        'o',
        'only',
        'show its output alone, or that of all',
        filter=Filtering.show_alone,
        for_components=False,
        names='o,enter',
    ),
    Key(
        'd',
        'debug',
        'start it anew under gdb, or pdb if it is in Python',
        command=commands.Debug,
        for_components=False,
    ),
    Key('l', 'log', 'show its log in $PAGER'),
    Key(
        'i',
        'describe',
        'show what it is, and all it was given',
        short='info',
        command=commands.Describe,
    ),
)


def _switched(state: LaunchState) -> Command[Any]:
    return commands.Watch('resume' if state.watch_paused else 'pause')


#: For all of them.
FOR_ALL = (
    Key(
        '/',
        'search',
        'show lines with a text only, as it is typed',
        hint_place=2,
    ),
    Key(
        'L',
        'level',
        'show INFO and worse only; then WARN, ERROR, FATAL, all',
        filter=lambda filtering, _: filtering.next_level(),
        hint_place=3,
    ),
    Key(
        't',
        'times',
        'show the time of each line, or no more',
        filter=lambda filtering, _: filtering.switch_times(),
        hint_place=4,
    ),
    Key(
        'M',
        'mute_all',
        'mute all, or unmute all',
        short='mute',
        filter=lambda filtering, state: filtering.mute_all(
            process.label for process in state.processes
        ),
        hint_place=5,
    ),
    Key(
        'w',
        'watch',
        'switch --watch off, or on again',
        command=_switched,
        hint_place=7,
    ),
    Key(
        'E',
        'errors',
        'show the errors of the last build that failed',
        hint_place=6,
    ),
    Key('?', 'help', 'show what the keys do', hint_place=1),
)

#: Further keys of the full screen, for what the cursor is on.
SCREEN_ONE = (
    Key(
        'space',
        'choose',
        'show its output beside others',
        short='',
        filter=Filtering.show_beside,
        for_components=False,
    ),
)
#: Further keys of the full screen, for all.
SCREEN_ALL = (
    Key('p', 'plan', 'show the plan as a tree, or the list'),
    Key(':', 'find', 'go to a process by a part of its name', short=''),
    Key(
        '1…9 0',
        'go',
        'go to one of the first ten',
        short='',
        names='1,2,3,4,5,6,7,8,9,0',
    ),
    Key('f', 'failed', 'go to the next that failed', short=''),
    Key('Tab', 'switch', 'go to the other pane', names='tab'),
    Key('Esc', 'clear', 'show all again', short='', names='escape'),
    Key('q', 'leave', 'leave'),
)
#: All keys of the full screen.
ON_ONE, ON_ALL = (*FOR_ONE, *SCREEN_ONE), (*FOR_ALL, *SCREEN_ALL)

#: A further key of the status block.
QUIT = Key(
    'q',
    'quit',
    'stop the launch, as Ctrl-C does; again to force',
    short='stop',
    hint_place=8,
)
#: The keys of the status block, with what they do.
BLOCK_HELP = (
    ('1 … Z', 'choose the process with this key'),
    (':', 'choose one by a part of its name; Tab completes it'),
    *((key.key, f'then {key.text}') for key in FOR_ONE),
    ('Esc', 'choose none; without one chosen, show all again'),
    *((key.key, key.text) for key in FOR_ALL),
    ('Enter', 'print an empty line, to separate what comes from what was'),
    (QUIT.key, QUIT.text),
    (ESCAPE_NAME, 'go back from the process that is typed at'),
)


def without_effect(state: LaunchState, member: MemberState | None) -> set[str]:
    """Return the names of keys that can do nothing now."""
    found = set()
    if state.watch is None:
        found.add('watch')
    if not state.errors:
        found.add('errors')
    if isinstance(member, ComponentState):
        found |= {key.name for key in ON_ONE if not key.for_components}
    elif member is not None and not member.terminal:
        found.add('attach')
    return found


def only_its_container_writes(label: str) -> str:
    """Return why the output of a component is neither shown nor hidden."""
    return f'{label} is a component: its container writes'


def cannot_be_typed_at(member: MemberState) -> str:
    """Return why a process or component takes no keys, and the way out."""
    if not isinstance(member, ProcessState):
        return f'{member.label} is a component: it has no keyboard'
    if member.pid is None:
        return f'{member.label} does not run'
    return f'{member.label} has no terminal; emulate_tty or --tty gives it one'
