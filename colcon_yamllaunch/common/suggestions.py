# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Hints: the name that was meant, and how to install what is missing."""

from collections.abc import Iterable, Mapping
import os
import re

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
_PACKAGE_NAME = re.compile('[a-zA-Z][a-zA-Z0-9_-]*')


def nearest(word: str, names: Iterable[str]) -> str | None:
    """Return the name that is most like the word, if any is near."""
    # most launches make no mistake
    import difflib

    by_key = {_key(name): name for name in sorted(names, reverse=True)}
    found = difflib.get_close_matches(_key(word), by_key, 1, CUTOFF)
    return by_key[found[0]] if found else None


def nearest_first(word: str, names: Iterable[str]) -> list[str]:
    """Order names, those most like the word first."""
    # most launches make no mistake
    import difflib

    def distance(name: str) -> tuple[float, str]:
        matcher = difflib.SequenceMatcher(None, _key(word), _key(name))
        return -matcher.ratio(), name

    return sorted(set(names), key=distance)


def is_slip(word: str, names: Iterable[str]) -> bool:
    """Return whether a word is one of the names, but for a slip of the pen."""
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
    return question(nearest(word, names))


def question(*names: str | None) -> str | None:
    """Return the question whether one of `names` is meant, None for none."""
    known = [f"'{name}'" for name in names if name is not None]
    return f'did you mean {" or ".join(known)}?' if known else None


def on_debian(*packages: str) -> str:
    """Return the command that installs packages, and where it works."""
    return f'on Debian and Ubuntu: sudo apt install {" ".join(packages)}'


def no_package(
    name: str,
    names: Iterable[str],
    environment: Mapping[str, str],
    otherwise: str = 'source the setup.bash of the workspace that has it',
) -> tuple[str, str | None]:
    """
    Return what to say of a package that does not exist, and how to get it.

    :param names: Those of the packages that exist
    :param environment: The variables that tell the sourced ROS 2
    :param otherwise: What to do where another workspace has the package
    """
    problem = (
        f"there is no package '{name}' in the workspace or the sourced "
        'environment'
    )
    names = tuple(names)
    meant = did_you_mean(name, names)
    # what the command would be made of is written by anybody
    if not _PACKAGE_NAME.fullmatch(name) or is_slip(name, names):
        return problem, meant
    distribution = environment.get('ROS_DISTRO', '<distro>')
    debian = f'ros-{distribution}-{name.lower().replace("_", "-")}'
    ways = [f'install it ({on_debian(debian)})']
    if 'ROS_DISTRO' not in environment:
        ways.insert(0, 'source /opt/ros/<distro>/setup.bash first')
    way = '; or '.join([*ways, otherwise])
    return problem, way if meant is None else f'{meant} Or {way}'


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
        return f'install it ({on_debian(package)}), or correct the name'
    path = os.path.normpath(os.path.join(cwd, name))
    if os.path.isfile(path):
        return f'make it executable: chmod +x {path}'
    return f'create the program {path}, or correct the path'


def listing(names: Iterable[str]) -> str:
    """Return the names in order, for a sentence."""
    return ', '.join(sorted(names))


def enumeration(items: Iterable[str]) -> str:
    """Return items as a sentence has them; there is at least one."""
    *first, last = items
    return f'{", ".join(first)} and {last}' if first else last


def _key(name: str) -> str:
    # a dash for an underscore is the most common slip of all
    return name.lower().replace('-', '_')
