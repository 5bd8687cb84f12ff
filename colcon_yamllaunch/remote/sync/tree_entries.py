# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What is in a folder, as it is told from one machine to another.

A path is relative and has `/` between its parts; names that are no UTF-8 are
as Python has them (`os.fsdecode`), which JSON keeps.
"""

import base64
from collections.abc import Mapping
import json
import os
from pathlib import Path
import stat
from typing import Any
import zlib

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.fingerprint import content_digest
from colcon_yamllaunch.common.fingerprint import digest

#: `['f', is executable, digest]`, `['l', target]` or `['d']`; as in JSON.
Entry = list[Any]
Entries = dict[str, Entry]

FOLDER: Entry = ['d']
#: How much is unpacked at most (bytes).
_MAXIMUM_SIZE = 512 * 1024 * 1024
#: The digest of any file that has content is asked for (bytes).
_ANY_SIZE = 2**62


def file_entry(is_executable: bool, digest_of_content: str) -> Entry:
    """Return the entry of a file."""
    return ['f', int(is_executable), digest_of_content]


def link_entry(target: str) -> Entry:
    """Return the entry of a symbolic link."""
    return ['l', target]


def is_executable(status: os.stat_result) -> bool:
    """Tell whether the owner of a file may run it."""
    return bool(status.st_mode & stat.S_IXUSR)


def digest_of(path: str, status: os.stat_result) -> str:
    """
    Return the digest of a file of any size.

    :raises UserError: when it cannot be read
    """
    found = content_digest(Path(path), status.st_size, _ANY_SIZE)
    if not found:
        raise UserError(f'{shown(path)} cannot be read')
    return found


def tree_digest(entries: Mapping[str, Entry]) -> str:
    """Return the digest of all entries of a folder."""
    ordered = json.dumps(sorted(entries.items()), separators=(',', ':'))
    return digest(ordered.encode())


def packed(values: Any) -> str:
    """Return values as a text that takes little room in a message."""
    text = json.dumps(values, separators=(',', ':')).encode()
    return base64.b85encode(zlib.compress(text, 1)).decode()


def unpacked(text: str) -> Any:
    """
    Return what :func:`packed` was given.

    :raises ValueError: when it is damaged, or endless
    """
    unpacker = zlib.decompressobj()
    try:
        data = unpacker.decompress(base64.b85decode(text), _MAXIMUM_SIZE)
    except zlib.error as e:
        raise ValueError(str(e)) from e
    if unpacker.unconsumed_tail:
        raise ValueError('it is too long')
    return json.loads(data)


def shown(path: str) -> str:
    """Return a path fit to be shown in a line."""
    text = os.fsencode(path).decode(errors='replace')
    return ''.join(c if c.isprintable() else '?' for c in text)


def safe_path(path: str) -> str:
    """
    Return a path if it leads nowhere else than below its folder.

    :raises UserError: when it does not
    """
    parts = path.split('/')
    if path.startswith('/') or '..' in parts or '\0' in path:
        raise UserError(f'{shown(path)} is no path below the workspace')
    return path
