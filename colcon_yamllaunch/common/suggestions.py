# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The nearest name to one that does not exist."""

from collections.abc import Iterable
import os

#: How alike two names must be to suggest one for the other, from 0 to 1.
CUTOFF = 0.6
#: In how many characters a name may differ from what is a slip of it, those of
#: both together: two are exchanged or one is another, and one is missing.
SLIP = 3
# the Debian packages of programs of other names that launch files start
_DEBIAN_PACKAGES = {
    'gzclient': 'gazebo',
    'gzserver': 'gazebo',
    'ifconfig': 'net-tools',
    'ping': 'iputils-ping',
    'pip': 'python3-pip',
    'x-terminal-emulator': 'xterm',
}


def nearest(word: str, names: Iterable[str]) -> str | None:
    """Return the name that is most like the word, if any is near."""
    # most launches make no mistake
    import difflib

    by_key = {_key(name): name for name in sorted(names, reverse=True)}
    found = difflib.get_close_matches(_key(word), by_key, 1, CUTOFF)
    return by_key[found[0]] if found else None


def is_slip(word: str, names: Iterable[str]) -> bool:
    """Say whether a word is one of the names, but for a slip of the pen."""
    name = nearest(word, names)
    if name is None:
        return False
    import difflib

    pair = _key(word), _key(name)
    matcher = difflib.SequenceMatcher(None, *pair)
    same = sum(block.size for block in matcher.get_matching_blocks())
    return sum(map(len, pair)) - 2 * same <= SLIP


def did_you_mean(word: str, names: Iterable[str]) -> str | None:
    """Return the nearest name as a question, if any is near."""
    name = nearest(word, names)
    return None if name is None else f"did you mean '{name}'?"


def one_of(word: str, names: Iterable[str]) -> str:
    """Return the way out when a word is none of the names."""
    return did_you_mean(word, names) or f'it is one of {", ".join(names)}'


def way_to_program(name: str, cwd: str) -> str:
    """
    Return the fix for a program that this machine lacks.

    :param name: Its name, or a path, which may be relative to `cwd`
    """
    if '/' not in name:
        package = _DEBIAN_PACKAGES.get(name, name)
        return f'install it (sudo apt install {package}), or correct the name'
    path = os.path.normpath(os.path.join(cwd, name))
    if os.path.isfile(path):
        return f'make it executable: chmod +x {path}'
    return f'let there be a program {path}, or correct the path'


def listing(names: Iterable[str]) -> str:
    """Return the names in order, for a sentence."""
    return ', '.join(sorted(names))


def _key(name: str) -> str:
    # a dash for an underscore is the most common slip of all
    return name.lower().replace('-', '_')
