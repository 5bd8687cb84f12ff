# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What processes are called."""

from collections.abc import Iterator
from fnmatch import fnmatchcase
import os
import re

_SCRIPTS = ('.py', '.sh')
_NUMBER = re.compile(r'-\d+$')


def names_of(label: str, executable: str, node: str | None) -> Iterator[str]:
    """
    Return the names that a process goes by.

    :param label: Its label, as `counter.py-1`; it counts without the number,
      and that of a script without the suffix, too
    :param executable: The name of its program
    :param node: The full name of its ROS node, as `/demo/counter`; the last
      part of it and each namespace around it count, too
    """
    yield label
    name = _NUMBER.sub('', label)
    yield name
    stem, suffix = os.path.splitext(name)
    if suffix in _SCRIPTS:
        yield stem
    yield executable
    if node is not None:
        yield node
        namespace, _, name = node.rpartition('/')
        yield name
        while namespace:
            yield namespace
            namespace = namespace.rpartition('/')[0]


def matches_process(
    pattern: str, label: str, executable: str, node: str | None
) -> bool:
    """
    Tell whether a name or a glob means a process.

    :param pattern: A name, or a pattern with `*`, `?` and `[…]`
    """
    return any(
        name == pattern or fnmatchcase(name, pattern)
        for name in names_of(label, executable, node)
    )
