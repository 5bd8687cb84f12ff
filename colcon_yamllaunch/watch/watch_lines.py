# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is said of changes: why something follows, and what came of them."""

from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.plan.position import shown_path
from colcon_yamllaunch.watch.changes import Change
from colcon_yamllaunch.watch.consequences import Consequence

#: Files that a line names before it only counts.
_FILES_SHOWN = 3
_HAPPENED = {
    'new': 'is new',
    'changed': 'changed',
    'deleted': 'was deleted',
    'mode': 'can be run now, or no more',
    'again': 'is as before, but was not for a moment',
}
_HAPPENED_IN_SHORT = {
    'new': 'added',
    'deleted': 'deleted',
    'again': 'saved again',
}
_WHAT_FAILED = {
    'build': 'the build failed',
    'plan': 'it cannot be launched so',
    'job': 'what prepares it was killed',
}


def why_lines(found: Iterable[Consequence], cwd: str = '') -> Iterator[str]:
    """
    Iterate over lines that tell what follows from changes, and why.

    :param cwd: The folder that paths are shown from
    """
    by_change: dict[Change, list[Consequence]] = {}
    for one in found:
        by_change.setdefault(one.change, []).append(one)
    for change, all_of_it in by_change.items():
        path = one_line(shown_path(change.path, cwd))
        what = '; '.join(_described(one) for one in all_of_it)
        yield f'{path} {_HAPPENED[change.kind]}: {what}'


def happened(files: Mapping[str, str]) -> str:
    """
    Say which files were changed.

    :param files: Their names, with what happened to them
    """
    names = list(files)
    kinds = {
        _HAPPENED_IN_SHORT.get(kind, 'changed') for kind in files.values()
    }
    what = kinds.pop() if len(kinds) == 1 else 'changed'
    if len(names) <= _FILES_SHOWN:
        return f'{", ".join(names)} {what}'
    first = ', '.join(names[: _FILES_SHOWN - 1])
    return f'{first} and {len(names) - _FILES_SHOWN + 1} more {what}'


def came_of(
    outcome: Mapping[str, Sequence[str]], *, is_lost: bool = False
) -> str:
    """
    Say what came of a change.

    :param outcome: What was done, such as `built`, and to what
    :param is_lost: Whether it takes a build or evaluation, and what does that
      is gone
    """
    parts = [
        f'{what} {_listed(names)}' for what, names in outcome.items() if names
    ]
    if is_lost:
        parts.append('what builds for --watch is gone')
    return ', '.join(parts) or 'nothing that runs differs'


def failed_by(what: str) -> str:
    """
    Say that nothing comes of a change for now.

    :param what: See :class:`.Failed`
    """
    return f'{_WHAT_FAILED[what]}, everything runs on as before'


def _listed(names: Sequence[str]) -> str:
    shown = ', '.join(names[: limits.NAMES_SHOWN])
    more = len(names) - limits.NAMES_SHOWN
    return f'{shown} and {more} more' if more > 0 else shown


def _described(one: Consequence) -> str:
    names = ', '.join(one.names)
    match one.action:
        case 'ignore':
            return f'nothing to do, as {one.reason}'
        case 'build':
            return f'build {names}, as {one.reason}'
        case 'replan':
            return f'evaluate the launch file, as {one.reason}'
        case 'restart':
            return f'restart {names}, as {one.reason}'
        case 'restart after build':
            return f'restart {names} after the build, as {one.reason}'
        case 'keep':
            return f'nothing on {names}, as {one.reason}'
