# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The environment that a setup script made last time.

It is remembered below `build/` for as long as nothing changed that it came
from; what a build wrote anew with the same content did not change. What is
kept is what the script changed, together with a digest of the variables that
it was sourced with: these may hold secrets, and never get to the disk. A
record that cannot be read counts as none, and in doubt the script is sourced.
"""

from collections.abc import Callable
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
import json
import os
from pathlib import Path
import time
from typing import Any
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.digest import digest
from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.input_states import InputState
from colcon_yamllaunch.common.input_states import look
from colcon_yamllaunch.common.input_states import read
from colcon_yamllaunch.common.search_path import split_path
from colcon_yamllaunch.workspace.environment.sourcing import Environment
from colcon_yamllaunch.workspace.environment.sourcing import OWN_VARIABLES
from colcon_yamllaunch.workspace.environment.sourcing import programs
from colcon_yamllaunch.workspace.environment.sourcing import source
from colcon_yamllaunch.workspace.environment.underlays import gone_note
from colcon_yamllaunch.workspace.environment.underlays import gone_underlays

if TYPE_CHECKING:
    from colcon_yamllaunch.workspace.environment.setup_inputs import (
        SetupInputs,
    )

#: The folder with the records, below the build folder.
FOLDER_NAME = '.colcon_launch_environments'
#: To be raised when what is in a record, or what is known of scripts, changes.
RECORD_VERSION = 2
#: How many are kept: one for each terminal with variables of its own.
MAXIMUM_RECORDS = 8

#: A Python with the ROS wheels gives this variable another order whenever it
#: starts. It makes no difference which: hooks add what is not in there.
_UNORDERED = 'LD_LIBRARY_PATH'
_RECORD_MODE = 0o600


def remembered(
    setup: Path,
    environment: Mapping[str, str],
    build_base: Path,
    sourcing: Callable[[Path, Mapping[str, str]], Environment] = source,
    clock: Callable[[], int] = time.time_ns,
) -> Environment:
    """
    Get the environment that `source SETUP` makes in a fresh bash.

    :param setup: The script
    :param environment: The variables before; left as they are
    :param build_base: The build folder of the workspace
    :param sourcing: What sources a script
    :param clock: The time, in nanoseconds
    :raises WorkspaceError: when the script is missing, fails or takes too long
    """
    path = build_base / FOLDER_NAME / _key(setup, environment)
    recalled = _recall(path, environment, clock)
    if recalled is not None:
        return recalled
    with suppress(OSError):
        path.unlink()
    return _source(setup, environment, path, sourcing, clock)


def _recall(
    path: Path, environment: Mapping[str, str], clock: Callable[[], int]
) -> Environment | None:
    try:
        record = json.loads(path.read_bytes())
        news = _news(record, clock)
        if news is None:
            return None
        variables = dict(environment)
        for name in record['unset']:
            del variables[name]
        for name, change in record['set'].items():
            variables[name] = _changed(
                variables.get(name), *map(_text, change)
            )
        result = Environment(variables, arrived=frozenset(record['arrived']))
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return None
    if news:
        _write(path, {**record, **news})
    else:
        with suppress(OSError):
            os.utime(path)
    return result


def _news(
    record: Mapping[str, Any], clock: Callable[[], int]
) -> dict[str, Any] | None:
    """Get what has to be changed in a record; None if it does not hold."""
    now = clock()
    seen = look(record['paths'])
    if seen.digest == record['state']:
        return {}
    if read(record['paths']).digest != record['contents']:
        return None
    return _seen(seen, now)


def _seen(state: InputState, now: int) -> dict[str, Any]:
    """Get the part of a record that spares reading the files."""
    return {'state': state.digest} if state.settled < now else {}


def _source(
    setup: Path,
    environment: Mapping[str, str],
    record: Path,
    sourcing: Callable[[Path, Mapping[str, str]], Environment],
    clock: Callable[[], int],
) -> Environment:
    started = clock()
    inputs = _inputs(setup, environment)
    paths = () if inputs is None else inputs.paths
    seen, before = look(paths), read(paths)
    try:
        result = sourcing(setup, environment)
    except WorkspaceError as e:
        raise WorkspaceError(f'{e}{_cure(setup)}') from e
    if result.messages:
        gone = gone_underlays(setup.parent)
        return replace(result, notes=tuple(map(gone_note, gone)))
    if inputs is None:
        return result
    result = replace(result, arrived=_arrived(inputs, result.variables))
    if before.settled < started and read(paths) == before:
        values = _values(environment, result)
        inputs_were = {
            'paths': paths,
            'state': None,
            'contents': before.digest,
        }
        _write(record, {**values, **inputs_were, **_seen(seen, started)})
    return result


def _inputs(
    setup: Path, environment: Mapping[str, str]
) -> 'SetupInputs | None':
    # what only following the scripts needs is not loaded by each launch
    from colcon_yamllaunch.workspace.environment.setup_inputs import (
        setup_inputs,
    )
    from colcon_yamllaunch.workspace.environment.setup_inputs import (
        UnknownContentError,
    )

    try:
        return setup_inputs(setup, environment, programs(environment))
    except UnknownContentError:
        return None


def _cure(setup: Path) -> str:
    from colcon_yamllaunch.workspace.environment.environment_check import (
        unknown_script,
    )

    script = unknown_script(setup.parent)
    if script is None or not setup.is_file():
        return ''
    return (
        f'\n{script} is not as colcon writes it: run `colcon build` in the '
        'workspace to have it written anew'
    )


def _arrived(
    inputs: 'SetupInputs', variables: Mapping[str, str]
) -> frozenset[str]:
    entries = {
        (variable, entry)
        for variable in {v for p in inputs.promised.values() for v, _ in p}
        for entry in split_path(variables.get(variable))
    }
    return frozenset(
        name
        for name, promised in inputs.promised.items()
        if entries.issuperset(promised)
    )


def _key(setup: Path, environment: Mapping[str, str]) -> str:
    variables = []
    for name, value in sorted(environment.items()):
        if name == _UNORDERED:
            value = os.pathsep.join(sorted(value.split(os.pathsep)))
        if name not in OWN_VARIABLES:
            variables.append(f'{name}={value}')
    place = _place(environment)
    parts = [str(RECORD_VERSION), str(setup), place, *variables]
    return digest(os.fsencode('\0'.join(parts)))


def _place(environment: Mapping[str, str]) -> str:
    """Get the current folder if it makes a difference."""
    for name in ('PATH', 'PYTHONPATH'):
        value = environment.get(name)
        if value and not all(map(os.path.isabs, value.split(os.pathsep))):
            return os.path.realpath('.')
    return ''


def _values(before: Mapping[str, str], result: Environment) -> dict[str, Any]:
    after = result.variables
    return {
        'set': {
            name: _change(before.get(name), value)
            for name, value in after.items()
            if before.get(name) != value
        },
        'unset': [name for name in before if name not in after],
        'arrived': sorted(result.arrived),
    }


def _change(before: str | None, after: str) -> list[str]:
    """Get what was put around a value, or else the new one alone."""
    if before is not None:
        head, found, tail = f':{after}:'.partition(f':{before}:')
        if found:
            return [head, tail]
    return [after]


def _changed(before: str | None, head: str, tail: str | None = None) -> str:
    if tail is None:
        return head
    if before is None:
        raise ValueError('there is no value to be put around')
    return (head + ':' + before + ':' + tail)[1:-1]


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f'{value} is no text')
    return value


def _write(path: Path, record: Mapping[str, Any]) -> None:
    # without a record the script is sourced again, which is no harm
    with suppress(OSError):
        path.parent.mkdir(mode=0o700, exist_ok=True)
        temporary = path.with_name(f'{path.name}.{os.getpid()}')
        temporary.unlink(missing_ok=True)
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL
        with open(os.open(temporary, flags, _RECORD_MODE), 'wb') as file:
            file.write(json.dumps(record).encode())
        # the record appears complete or not at all
        temporary.replace(path)
        _forget_oldest(path.parent)


def _forget_oldest(folder: Path) -> None:
    records = sorted(
        folder.iterdir(), key=lambda path: path.stat().st_mtime_ns
    )
    for path in records[:-MAXIMUM_RECORDS]:
        path.unlink(missing_ok=True)
