# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The keys, as the launching terminal has them, and those for the panes.

A key means the action `action_NAME` of the app, and stands in the help.
"""

from colcon_yamllaunch.common.frozen import dataclass


@dataclass(frozen=True, slots=True)
class Key:
    """
    A key.

    :param keys: What the terminal calls it; several with commas
    :param shown: How users know it
    :param action: What it does, see the module
    :param short: That in a word, for the last line; empty to leave it out
    :param text: That in a sentence, for the help
    """

    keys: str
    shown: str
    action: str
    short: str
    text: str


#: For the process or component that the cursor is on.
ON_ONE = (
    Key('s', 's', 'stop', 'stop', 'stop it, or unload it; once more: hurry'),
    Key('r', 'r', 'restart', 'restart', 'start it, or load it, anew'),
    Key('k', 'k', 'kill', 'kill', 'kill it with all that it started'),
    Key('a', 'a', 'attach', 'attach', 'type at it; Ctrl-] comes back'),
    Key('m', 'm', 'mute', 'mute', 'mute it, or not'),
    Key('o,enter', 'o', 'only', 'only', 'show only its output, or all again'),
    Key('space', 'space', 'choose', '', 'show its output beside others'),
    Key('d', 'd', 'debug', 'debug', 'start it anew under a debugger'),
    Key('l', 'l', 'log', 'log', 'show its log in $PAGER'),
    Key('i', 'i', 'inspect', 'info', 'show what it is, and what it uses'),
)
#: For all of them.
ON_ALL = (
    Key('slash', '/', 'search', 'search', 'show lines that have a text'),
    Key('L', 'L', 'level', 'level', 'show lines of a severity or above'),
    Key('t', 't', 'timestamps', '', 'show when each line came, or not'),
    Key('M', 'M', 'mute_all', '', 'mute all of them, or none'),
    Key('p', 'p', 'plan', 'plan', 'show the plan as a tree, or the processes'),
    Key('colon', ':', 'find', '', 'go to a process by a part of its name'),
    Key('1,2,3,4,5,6,7,8,9,0', '1…9 0', '', '', 'go to one of the first ten'),
    Key('f', 'f', 'failed', '', 'go to the next that failed'),
    Key('tab', 'Tab', 'switch', 'switch', 'go to the other pane'),
    Key('escape', 'Esc', 'clear', '', 'show all again'),
    Key('question_mark', '?', 'help', 'help', 'show this'),
    Key('q', 'q', 'leave', 'leave', 'leave'),
)
