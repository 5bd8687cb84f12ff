# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The arguments of `colcon build` on another machine, which build as here."""

from collections.abc import Mapping
from collections.abc import Sequence
import json
import os
from pathlib import Path


def build_words(
    given: Sequence[str], settings: Mapping[str, str], merge_install: bool
) -> list[str]:
    """
    Return the arguments for the colcon there.

    :param given: Those that the user has given
    :param settings: What came of them with the defaults and mixins here
    :param merge_install: Whether all packages are installed into one prefix
    """
    words = list(given)
    for name, text in sorted(settings.items()):
        option = f'--{name.replace("_", "-")}'
        if not name.endswith('_args') or option in given:
            continue
        value = json.loads(text)
        if isinstance(value, list) and value:
            # of the defaults and mixins here
            words += [option, *map(_protected, value)]
    if merge_install and '--merge-install' not in given:
        words.append('--merge-install')
    return words


def path_there(path: Path, root: Path) -> str:
    """Return a folder of the workspace, relative to that if it is in it."""
    return (
        os.path.relpath(path, root) if path.is_relative_to(root) else str(path)
    )


def _protected(word: object) -> str:
    # colcon takes the next word that begins so for an option of its own
    text = str(word)
    return f' {text}' if text.startswith('--') else text
