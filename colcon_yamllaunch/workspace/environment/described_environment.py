# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The environment of a workspace, without running its setup scripts.

Who only looks at a launch runs nothing of the workspace. So the hooks are
read as the data that most of them are (see :mod:`hooks`), in the order of
colcon's and ament's prefix scripts; what is only a script is left out.
"""

from collections.abc import Iterator
from collections.abc import Mapping
from contextlib import suppress
from heapq import heappop
from heapq import heappush
import os
from pathlib import Path

from colcon_yamllaunch.common.search_path import split_path
from colcon_yamllaunch.common.text_files import text_of
from colcon_yamllaunch.workspace.environment import hooks
from colcon_yamllaunch.workspace.environment.sourcing import chained_underlays
from colcon_yamllaunch.workspace.environment.sourcing import Environment
from colcon_yamllaunch.workspace.environment.sourcing import gone_note
from colcon_yamllaunch.workspace.environment.sourcing import gone_underlays
from colcon_yamllaunch.workspace.environment.sourcing import sourced_underlays
from colcon_yamllaunch.workspace.packages.package import is_merged

#: How many scripts are named that are left out.
SHOWN_SCRIPTS = 3

_COLCON_INDEX = 'share/colcon-core/packages'
_AMENT_INDEX = 'share/ament_index/resource_index'


def described_environment(
    setup: Path, environment: Mapping[str, str]
) -> Environment:
    """
    Return what `source SETUP` would make, as far as it is described.

    :param setup: The `setup.bash` or, without what it chains, the
      `local_setup.bash` of a prefix
    :param environment: The variables before; left as they are
    """
    base = setup.parent
    variables = dict(environment)
    chained = chained_underlays(base) if setup.name == 'setup.bash' else []
    notes = list(map(gone_note, gone_underlays(base) if chained else ()))
    sourced = sourced_underlays(environment, base)
    scripts = []
    for prefix in (*chained, base):
        found = _apply(prefix, variables)
        if prefix not in sourced:
            scripts += found
    if scripts:
        more = ', …' if len(scripts) > SHOWN_SCRIPTS else ''
        notes.append(
            'left out of the environment, as nothing is run to look at a '
            f'launch: {", ".join(scripts[:SHOWN_SCRIPTS])}{more}'
        )
    return Environment(variables, notes=tuple(notes))


def _apply(prefix: Path, variables: dict[str, str]) -> list[str]:
    """Do what the packages of a prefix describe, and return the scripts."""
    scripts = []
    if os.path.isfile(prefix / '_local_setup_util_sh.py'):
        _change(('prepend', 'COLCON_PREFIX_PATH', str(prefix)), variables)
        packages = dict(_colcon_packages(prefix))
    else:
        packages = dict(_ament_packages(prefix))
    for name in _ordered({n: needed for n, (_, needed) in packages.items()}):
        with suppress(hooks.DamagedHooksError):
            done = hooks.read_hooks(packages[name][0], name)
            scripts += done.scripts
            for change in done.changes:
                _change(change, variables)
    return scripts


def _colcon_packages(
    prefix: Path,
) -> Iterator[tuple[str, tuple[str, set[str]]]]:
    """Return packages with the prefix of each and what it needs."""
    merged = is_merged(prefix)
    for name in _names(prefix / _COLCON_INDEX if merged else prefix):
        own = prefix if merged else prefix / name
        entry = own / _COLCON_INDEX / name
        if entry.is_file():
            yield name, (str(own), set(split_path(text_of(entry))))


def _ament_packages(
    prefix: Path,
) -> Iterator[tuple[str, tuple[str, set[str]]]]:
    index = prefix / _AMENT_INDEX
    for name in _names(index / 'packages'):
        entry = index / 'package_run_dependencies' / name
        needed = text_of(entry) if entry.is_file() else ''
        yield name, (str(prefix), set(filter(None, needed.split(';'))))


def _names(folder: Path) -> list[str]:
    try:
        names = os.listdir(folder)
    except OSError:
        return []
    return sorted(name for name in names if not name.startswith('.'))


def _ordered(packages: dict[str, set[str]]) -> Iterator[str]:
    """Return packages behind what they need, else by their names."""
    pending = {
        n: packages.keys() & needs - {n} for n, needs in packages.items()
    }
    users: dict[str, list[str]] = {}
    for name, needs in pending.items():
        for needed in needs:
            users.setdefault(needed, []).append(name)
    ready = sorted(name for name, needs in pending.items() if not needs)
    while pending:
        # of a circle, for which sourcing brings in nothing, any will do
        name = heappop(ready) if ready else min(pending)
        if pending.pop(name, None) is None:
            continue
        yield name
        for user in users.get(name, ()):
            needs = pending.get(user, set())
            needs.discard(name)
            if user in pending and not needs:
                heappush(ready, user)


def _change(change: hooks.Change, variables: dict[str, str]) -> None:
    operation, name, value = change
    old = variables.get(name, '')
    if operation == 'set' or (operation == 'set-if-unset' and not old):
        variables[name] = value
    elif operation in ('append', 'prepend') and value not in split_path(old):
        both = [old, value] if operation == 'append' else [value, old]
        variables[name] = os.pathsep.join(filter(None, both))
