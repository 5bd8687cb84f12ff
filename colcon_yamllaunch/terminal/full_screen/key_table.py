# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The keys of the full screen: those of the block below the output, and others.

A key means the action `action_NAME` of the screen, and stands in the help.
"""

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.terminal.key_meanings import FOR_ALL
from colcon_yamllaunch.terminal.key_meanings import FOR_ONE
from colcon_yamllaunch.terminal.key_meanings import Meaning

# what the library calls keys that are no letters, and others that do the same
_NAMES = {'/': 'slash', '?': 'question_mark', 'o': 'o,enter'}


@dataclass(frozen=True, slots=True)
class Key:
    """
    A key.

    :param keys: What the library calls it; several with commas
    :param action: What it does, see the module; empty for many that are alike
    :param meaning: The same as users know it; without a word for it, it is
      in the help only
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
