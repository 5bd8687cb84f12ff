# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Underlays: the prefixes that a workspace was built on top of.

Each build writes `install/setup.bash` anew, chaining the underlays of the
shell that it runs in. Built from a shell where none is sourced, a workspace
would lose them.
"""

from collections.abc import Callable
from collections.abc import Mapping
import os
from pathlib import Path
import re

from colcon_yamllaunch.common.search_path import split_path
from colcon_yamllaunch.common.text_files import text_of
from colcon_yamllaunch.workspace.environment.sourcing import Environment
from colcon_yamllaunch.workspace.environment.sourcing import source

#: How colcon names a chained prefix in setup.bash and setup.sh.
_CHAINED = re.compile(r'^COLCON_CURRENT_PREFIX="([^"$`]+)"$', re.M)


def build_environment(
    environment: Mapping[str, str],
    install_base: Path,
    sourcing: Callable[[Path, Mapping[str, str]], Environment] = source,
) -> Environment:
    """
    Return the environment to build in, with the underlays that must survive.

    A shell with underlays is followed, as `colcon build` does; one without
    gets those that the workspace was built with before.

    :param environment: The caller's
    :raises WorkspaceError: when an underlay's script fails
    """
    chained = chained_underlays(install_base)
    sourced = sourced_underlays(environment, install_base)
    if not chained:
        return Environment(environment)
    if sourced:
        return Environment(environment, notes=_difference(chained, sourced))
    notes = []
    used = []
    for prefix in chained:
        script = prefix / 'local_setup.bash'
        if os.path.isfile(script):
            environment = sourcing(script, environment).variables
            used.append(str(prefix))
        else:
            notes.append(gone_note(prefix))
    if used:
        notes.append(
            'nothing is sourced in this shell: building on top of '
            f'{", ".join(used)} as before'
        )
    return Environment(environment, notes=tuple(notes))


def chained_underlays(install_base: Path) -> list[Path]:
    """Return the underlays that the setup script sources first, in order."""
    for name in ('setup.bash', 'setup.sh'):
        path = install_base / name
        if os.path.isfile(path):
            prefixes = map(Path, _CHAINED.findall(text_of(path)))
            return [prefix for prefix in prefixes if prefix != install_base]
    return []


def gone_underlays(install_base: Path) -> list[Path]:
    """
    Return the underlays of the workspace that are not there any more.

    bash returns 0 nevertheless when it sources the workspace.
    """
    return [
        prefix
        for prefix in chained_underlays(install_base)
        if not os.path.isfile(prefix / 'local_setup.bash')
    ]


def gone_note(prefix: Path) -> str:
    """Tell the user of an underlay that is not there any more."""
    return (
        f'the workspace was built on top of {prefix}, which is not '
        'there any more: source its successor if it has one'
    )


def sourced_underlays(
    environment: Mapping[str, str], install_base: Path
) -> list[Path]:
    """
    Return the underlays that colcon would chain in an environment.

    The rules are those of the `colcon_core.prefix_path` extensions of
    colcon-core and colcon-ros: the entries of COLCON_PREFIX_PATH, then those
    of AMENT_PREFIX_PATH that have a setup script of their own or belong to an
    isolated install space.

    :param install_base: The workspace's own, which is no underlay
    """
    prefixes = [
        Path(entry)
        for entry in split_path(environment.get('COLCON_PREFIX_PATH'))
        if Path(entry).exists()
    ]
    for entry in split_path(environment.get('AMENT_PREFIX_PATH')):
        path = Path(entry)
        if any(path.glob('local_setup.*')):
            prefixes.append(path)
        elif os.path.isfile(path.parent / '.colcon_install_layout'):
            prefixes.append(path.parent)
    return [p for p in dict.fromkeys(prefixes) if p != install_base]


def _difference(chained: list[Path], sourced: list[Path]) -> tuple[str, ...]:
    lost = [str(path) for path in chained if path not in sourced]
    if not lost:
        return ()
    return (
        f'the workspace was built on top of {", ".join(lost)}, which is not '
        'sourced in this shell: a build follows the shell. Source it and '
        'launch again if it is still needed',
    )
