# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The cache of environments that a setup script made.

A record below `build/` is valid as long as the files that sourcing reads are
unchanged: the scripts, the descriptions of hooks, and the files that these
look for. A file that a build wrote again with the same content is unchanged.
An environment is cached only if it is exactly what the hooks describe: then no
script has set variables from other sources.

A record has the changes of the script, and a digest of the variables before:
these may hold secrets, and are never written to the disk. In doubt, and if a
record cannot be read, the script is sourced.
"""

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
import json
import os
from pathlib import Path
import time

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.files import read_json, write_json
from colcon_yamllaunch.common.fingerprint import (
    are_settled,
    COARSE_TICK,
    content_digest,
    digest,
    fingerprints,
    TICK,
)
from colcon_yamllaunch.workspace.environment.sourcing import (
    Environment,
    gone_notes,
    OWN_VARIABLES,
    source,
)

#: The folder with the records, below the build folder.
FOLDER_NAME = '.colcon_launch_environments'
#: To be raised when what is in a record, or what is trusted, changes.
RECORD_VERSION = 4
#: How many are kept: one for each terminal with variables of its own.
MAXIMUM_RECORDS = 8

#: A Python with the ROS wheels gives this variable another order whenever it
#: starts. It makes no difference which: hooks add what is not in there.
_UNORDERED = 'LD_LIBRARY_PATH'
_MODE = 0o600
_SECOND = 1_000_000_000
#: What colcon writes, and writes anew with each build.
_COLCON_SCRIPTS = ('setup.bash', 'local_setup.bash', '_local_setup_util_sh.py')


def cached_environment(
    setup: Path,
    environment: Mapping[str, str],
    build_base: Path,
    sourcing: Callable[[Path, Mapping[str, str]], Environment] = source,
) -> Environment:
    """
    Return the environment that `source SETUP` makes in a fresh bash.

    :param environment: The variables before; left as they are
    :raises WorkspaceError: when the script is missing, fails or takes too long
    """
    path = build_base / FOLDER_NAME / _key(setup, environment)
    known = _load_if_valid(path, environment)
    if known is not None:
        return known
    with suppress(OSError):
        path.unlink()
    return _source(setup, environment, path, sourcing)


def known_environment(
    setup: Path, environment: Mapping[str, str], build_base: Path
) -> Environment:
    """
    Return what `source SETUP` would make, as far as that is known without.

    That is what it made last time if that holds, else what is described.
    """
    path = build_base / FOLDER_NAME / _key(setup, environment)
    known = _load_if_valid(path, environment)
    if known is not None:
        return known
    # a launch that runs does without it
    from colcon_yamllaunch.workspace.environment import hooks

    return hooks.described_environment(setup, environment)


def _load_if_valid(
    path: Path, environment: Mapping[str, str]
) -> Environment | None:
    record = read_json(path)
    try:
        paths = record['paths']
        state = _state(paths)
        if state != record['state']:
            is_settled = are_settled(fingerprints(paths).values())
            if _contents(paths) != record['contents']:
                return None
            write_json(path, {**record, 'state': is_settled and state}, _MODE)
        variables = dict(environment)
        for name, change in record['changes'].items():
            if change is None:
                del variables[name]
            else:
                # where the value before stands in the new one
                variables[name] = variables.get(name, '').join(change)
        os.utime(path)
        return Environment(variables, packages=frozenset(record['packages']))
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return None


def _source(
    setup: Path,
    environment: Mapping[str, str],
    record: Path,
    sourcing: Callable[[Path, Mapping[str, str]], Environment],
) -> Environment:
    # most launches need not source
    from colcon_yamllaunch.workspace.environment.hooks import Description

    started = time.time_ns()
    described = Description(setup, environment)
    paths = list(dict.fromkeys(described.paths))
    state, before = _state(paths), fingerprints(paths).values()
    contents = _contents(paths)
    try:
        result = sourcing(setup, environment)
    except WorkspaceError as e:
        for script in (setup.parent / name for name in _COLCON_SCRIPTS):
            if f'{script}: line ' in str(e):
                raise WorkspaceError(
                    f'{e}\n{script} is damaged: run `colcon build` in the '
                    'workspace to have it written anew'
                ) from e
        raise
    if result.messages:
        return replace(result, notes=gone_notes(setup.parent))
    if not described.matches(result.variables):
        return result
    result = replace(result, packages=frozenset(described.packages))
    # a file that changed while it ran, or a tick before, may show no change
    is_older = all(
        one is None
        or one.ctime + (TICK if one.ctime % _SECOND else COARSE_TICK) < started
        for one in before
    )
    if _state(paths) == state and is_older:
        values = {
            'paths': paths,
            'state': state,
            'contents': contents,
            'changes': _changes(environment, result.variables),
            'packages': sorted(described.packages),
        }
        _write(record, values)
    return result


def _state(paths: Iterable[str]) -> str:
    """Return a digest of the sizes and times of files and folders."""
    found: list[tuple[int, ...] | None] = []
    for path in paths:
        try:
            s = os.stat(path)
            found.append((s.st_size, s.st_mtime_ns, s.st_ctime_ns, s.st_ino))
        except OSError:
            found.append(None)
    return digest(repr(found).encode())


def _contents(paths: Iterable[str]) -> str:
    """Return a digest of what is in files and of the names in folders."""
    parts: list[object] = []
    for path, found in fingerprints(paths).items():
        if found is None:
            parts.append(None)
        elif os.path.isdir(path):
            parts.append(sorted(os.listdir(path)))
        else:
            content = content_digest(Path(path), found.size)
            parts.append([found.executable, content or found])
    return _digest(parts)


def _digest(values: object) -> str:
    return digest(json.dumps(values).encode())


def _key(setup: Path, environment: Mapping[str, str]) -> str:
    variables: dict[str, object] = dict(environment)
    for name in OWN_VARIABLES:
        variables.pop(name, None)
    if _UNORDERED in variables:
        folders = environment[_UNORDERED].split(os.pathsep)
        variables[_UNORDERED] = sorted(folders)
    return _digest([RECORD_VERSION, str(setup), sorted(variables.items())])


def _changes(
    before: Mapping[str, str], after: Mapping[str, str]
) -> dict[str, list[str] | None]:
    """Return what sets variables, without the values that they had."""
    changes: dict[str, list[str] | None] = {}
    for name in before.keys() | after.keys():
        old, value = before.get(name), after.get(name)
        if value is None:
            changes[name] = None
        elif value != old:
            changes[name] = value.split(old) if old else [value]
    return changes


def _write(path: Path, record: Mapping[str, object]) -> None:
    # without a record the script is sourced again, which is no harm
    with suppress(OSError):
        path.parent.mkdir(mode=0o700, exist_ok=True)
        write_json(path, record, _MODE)
        records = sorted(
            path.parent.iterdir(), key=lambda path: path.stat().st_mtime_ns
        )
        for oldest in records[:-MAXIMUM_RECORDS]:
            oldest.unlink(missing_ok=True)
