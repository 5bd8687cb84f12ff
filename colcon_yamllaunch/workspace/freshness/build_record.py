# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The record of a package's last build, in its folder below `build/`.

It is written before a build starts and again when that has ended, so that a
build that was cut off shows.
"""

from collections.abc import Mapping
from dataclasses import field
import json
from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.json_files import write_json
from colcon_yamllaunch.workspace.freshness.build_context import Conditions
from colcon_yamllaunch.workspace.freshness.build_decision import How

#: The name of a record, below `build/<package>/`.
RECORD_NAME = 'colcon_launch.json'
#: To be raised when what is in a record changes.
RECORD_VERSION = 2


class DamagedRecordError(Exception):
    """There is a record, but it cannot be read."""


@dataclass(frozen=True, slots=True)
class Record:
    """
    A build.

    :param source: The folder that is built
    :param files: The files of the source before the build; one that is read
      from elsewhere goes by its absolute path
    :param how: How it was built, as a number
    :param id: Another one for each build
    :param origin: The id of the last build from scratch
    :param shape: The id of the last build of more than compiled code
    :param succeeded: Whether it ended well; all below is as it was after the
      last build that did
    :param finished: When it ended (nanoseconds since the epoch), or 0
    :param built_at: When a build ended well, or 0
    :param live: The files whose edits show without a build
    :param installed: What was installed, relative to the install space, and
      what it was like
    :param traces: When the files that colcon leaves were written
    :param arguments: Those that CMake was called with, as colcon keeps them
    :param settings: As in :class:`Conditions`, and so are the next two
    """

    source: str
    files: dict[str, Fingerprint]
    how: int = How.COMPILE
    id: str = ''
    origin: str = ''
    shape: str = ''
    succeeded: bool = False
    finished: int = 0
    built_at: int = 0
    live: frozenset[str] = frozenset()
    installed: dict[str, str] = field(default_factory=dict)
    traces: dict[str, int] = field(default_factory=dict)
    arguments: str = ''
    settings: dict[str, str] = field(default_factory=dict)
    environment: dict[str, str] = field(default_factory=dict)
    dependencies: dict[str, str | None] = field(default_factory=dict)

    @property
    def conditions(self) -> Conditions:
        """What the build depended on beside the source."""
        return Conditions(self.settings, self.environment, self.dependencies)


def read_record(path: Path) -> Record | None:
    """
    Read a record.

    :returns: None if there is none, or if it is one of another version
    :raises DamagedRecordError: if there is one that makes no sense
    """
    try:
        data = path.read_bytes()
    except OSError:
        return None
    try:
        return _decode(json.loads(data))
    except (ValueError, TypeError, KeyError, AttributeError) as e:
        raise DamagedRecordError from e


def write_record(path: Path, record: Record) -> None:
    """Write a record; without one it is built again, which is no harm."""
    write_json(path, _encode(record))


def _encode(record: Record) -> Mapping[str, Any]:
    values = {key: getattr(record, key) for key in Record.__dataclass_fields__}
    values['files'] = {
        # which file it is does not matter
        name: found[:-1]
        for name, found in sorted(record.files.items())
    }
    values['live'] = sorted(record.live)
    return {'version': RECORD_VERSION, **values}


def _decode(values: Any) -> Record | None:
    version = values.pop('version')
    if isinstance(version, int) and version != RECORD_VERSION:
        return None
    values['files'] = {
        name: Fingerprint(*found) for name, found in values['files'].items()
    }
    values['live'] = frozenset(values['live'])
    record = Record(**values)
    _check(record)
    return record


def _check(record: Record) -> None:
    texts = (
        *(record.id, record.origin, record.shape),
        *(record.source, record.arguments),
    )
    mappings = (
        record.installed,
        record.traces,
        record.settings,
        record.environment,
        record.dependencies,
    )
    numbers = (record.how, record.finished, record.built_at)
    if not (
        all(isinstance(text, str) for text in texts)
        and all(isinstance(mapping, dict) for mapping in mappings)
        and all(isinstance(number, int) for number in numbers)
    ):
        raise TypeError('not a record')
