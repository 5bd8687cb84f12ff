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

from colcon_yamllaunch.common.codec import Codec
from colcon_yamllaunch.common.codec import only
from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.json_files import write_json
from colcon_yamllaunch.common.text_files import content_of
from colcon_yamllaunch.workspace.freshness.build_context import BuildContext
from colcon_yamllaunch.workspace.freshness.build_decision import BuildMode

#: The name of a record, below `build/<package>/`.
RECORD_NAME = 'colcon_launch.json'
#: To be raised when what is in a record changes.
RECORD_VERSION = 3

#: How a file names what goes by another name here.
_KEYS = {'mode': 'how', 'clean_id': 'origin', 'interface_id': 'shape'}
#: The parts of the context, which a file has among the rest.
_CONTEXT = ('settings', 'environment', 'dependencies')


class DamagedRecordError(Exception):
    """There is a record, but it cannot be read."""


@dataclass(frozen=True, slots=True)
class Record:
    """
    A build.

    :param files: The files of the source before the build; one that is read
      from elsewhere goes by its absolute path
    :param written: Those that were written during the build
    :param generated: Those that builds write by themselves
    :param mode: How it was built, as a number
    :param id: Another one for each build
    :param clean_id: The id of the last build from scratch
    :param interface_id: The id of the last build of more than compiled code
    :param succeeded: Whether it ended well; all below is as it was after the
      last build that did
    :param finished: When it ended (nanoseconds since the epoch), or 0
    :param built_at: When a build ended well, or 0
    :param live: The files whose edits show without a build
    :param installed: What was installed, relative to the install space, and
      what it was like
    :param products: What was built, relative to the build folder, likewise
    :param traces: When the files that colcon leaves were written
    :param arguments: Those that CMake was called with, as colcon keeps them
    :param variables: Variables that the package looked for by itself
    """

    source: str
    files: dict[str, Fingerprint]
    written: frozenset[str] = frozenset()
    generated: frozenset[str] = frozenset()
    mode: int = BuildMode.COMPILE
    id: str = ''
    clean_id: str = ''
    interface_id: str = ''
    succeeded: bool = False
    finished: int = 0
    built_at: int = 0
    live: frozenset[str] = frozenset()
    installed: dict[str, Fingerprint] = field(default_factory=dict)
    products: dict[str, Fingerprint] = field(default_factory=dict)
    traces: dict[str, int] = field(default_factory=dict)
    arguments: str = ''
    variables: dict[str, str] = field(default_factory=dict)
    context: BuildContext = BuildContext({}, {}, {})


def read_record(path: Path) -> Record | None:
    """
    Read a record; None if there is none, or one of another version.

    :raises DamagedRecordError: when there is one that makes no sense
    """
    try:
        data = content_of(path)
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
    values = _CODEC.to_json(record)
    context = values.pop('context')
    values |= {name: context[name] for name in _CONTEXT}
    values |= {key: values.pop(name) for name, key in _KEYS.items()}
    return {'version': RECORD_VERSION, **values}


def _decode(values: Any) -> Record | None:
    version = values.pop('version')
    if isinstance(version, int) and version != RECORD_VERSION:
        return None
    values |= {name: values.pop(key) for name, key in _KEYS.items()}
    context = {name: values.pop(name) for name in _CONTEXT}
    return _CODEC.from_json(Record, {**values, 'context': context})


def _read_files(data: Any) -> dict[str, Fingerprint]:
    # each launch reads thousands of them, of its own making
    return {path: Fingerprint(*one) for path, one in only(dict, data).items()}


# which file it is does not matter
_CODEC = Codec(
    special={
        dict[str, Fingerprint]: (
            lambda files: {path: files[path][:-1] for path in sorted(files)},
            _read_files,
        )
    }
)
