# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The arguments of `colcon build` on another machine, which build as here."""

from collections.abc import Collection
from collections.abc import Mapping
from collections.abc import Sequence
import json
import os
from pathlib import Path

#: What names files of the user here, and is in the settings.
_LEFT_OUT = frozenset({'--mixin', '--mixin-files'})
#: What launches build with, and what the workspace here shows.
_ANYWAY = ('symlink_install', 'merge_install')
_FOLDERS = {'build_base': 'build', 'install_base': 'install'}


def build_words(
    given: Sequence[str], settings: Mapping[str, str], *, merge_install: bool
) -> list[str]:
    """
    Return the arguments for the colcon there.

    Defaults and mixins are the user's, and may be others there; what they
    came to here goes along in their place.

    :param given: The arguments that the user has given
    :param settings: What came of them with the defaults and mixins here
    :param merge_install: Whether all packages are installed into one prefix
    """
    values = {
        f'--{name.replace("_", "-")}': (name, json.loads(text))
        for name, text in sorted(settings.items())
    }
    lists = {o for o, (_, value) in values.items() if isinstance(value, list)}
    words = _without(given, _LEFT_OUT | lists)
    for option, (name, value) in values.items():
        if isinstance(value, list) and value:
            # colcon takes a word that begins so for an option of its own
            words += [
                option,
                *(f' {w}' if w[:1] == '-' else w for w in map(str, value)),
            ]
        elif value is True and name not in _ANYWAY and option not in words:
            words.append(option)
        elif name in _FOLDERS and value not in (None, _FOLDERS[name]):
            words = [*_without(words, {option}), option, str(value)]
    if merge_install and '--merge-install' not in words:
        words.append('--merge-install')
    return words


def path_there(path: Path, root: Path) -> str:
    """Return a folder of the workspace, relative to that if it is in it."""
    if path.is_relative_to(root):
        return os.path.relpath(path, root)
    return str(path)


def _without(words: Sequence[str], options: Collection[str]) -> list[str]:
    """Leave options out, with their values."""
    kept = []
    is_left_out = False
    for word in words:
        if word.startswith('--'):
            is_left_out = word.partition('=')[0] in options
        if not is_left_out:
            kept.append(word)
    return kept
