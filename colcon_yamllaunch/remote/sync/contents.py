# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
How the launcher and a machine describe files to each other.

A *content* is a text that differs where two files do: `f DIGEST`, `xf DIGEST`
for one that its owner may execute, `l TARGET` for a symbolic link, `d` for a
folder, and an empty text where there is nothing. Names that are not UTF-8 are
as Python has them (`os.fsdecode`), which JSON keeps.
"""

import base64
import json
import os
from pathlib import Path
import shutil
import stat
from typing import Any
import zlib

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.fingerprint import content_digest

#: The content of a folder.
FOLDER = 'd'
#: The beginning of the content of a link; its target follows.
LINK = 'l '
#: The size limit of unpacked values (bytes).
_MAXIMUM_SIZE = 512 * 1024 * 1024
#: Read files of any size (bytes).
_ANY_SIZE = 2**62
_INSTALL_COMMANDS = (
    *('apt install', 'dnf install', 'zypper install'),
    *('pacman -S', 'apk add'),
)


def content_at(path: str, *, follows_links: bool = False) -> str:
    """
    Return the content of the file at `path`.

    :raises UserError: when it cannot be read
    """
    try:
        status = os.stat(path, follow_symlinks=follows_links)
    except (FileNotFoundError, NotADirectoryError):
        return ''
    except OSError as e:
        raise unreadable(path, e.strerror) from e
    if stat.S_ISDIR(status.st_mode):
        return FOLDER
    if stat.S_ISLNK(status.st_mode):
        return LINK + os.readlink(path)
    if not stat.S_ISREG(status.st_mode):
        return 'other'
    found = content_digest(Path(path), status.st_size, _ANY_SIZE)
    if not found:
        raise unreadable(path, os.strerror(13))
    return file_content(found, is_executable=is_executable(status))


def file_content(digest_of_file: str, *, is_executable: bool) -> str:
    """Return the content of a file."""
    return f'{"x" if is_executable else ""}f {digest_of_file}'


def is_file(content: str) -> bool:
    """Return whether a content is that of a file."""
    return content.removeprefix('x').startswith('f ')


def is_executable(status: os.stat_result) -> bool:
    """Return whether the owner of a file may execute it."""
    return bool(status.st_mode & stat.S_IXUSR)


def have_same_data(one: str, other: str) -> bool:
    """Return whether two contents differ at most in who may execute them."""
    return one.removeprefix('x') == other.removeprefix('x')


def packed(values: Any) -> str:
    """Return values as a compressed text for a message."""
    text = json.dumps(values, separators=(',', ':')).encode()
    return base64.b85encode(zlib.compress(text, 1)).decode()


def unpacked(text: str) -> Any:
    """
    Return the values that :func:`packed` received.

    :raises ValueError: when the text is damaged, or too long
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
    """Return a path for a message, in one line."""
    text = os.fsencode(path).decode(errors='replace')
    return ''.join(c if c.isprintable() else '?' for c in text)


def unreadable(path: str, reason: str | None) -> UserError:
    """Return the error about a file that cannot be read."""
    return UserError(
        f'{shown(path)} cannot be read: {reason}. Make it readable, or take '
        'it out of the package'
    )


def check_rsync(where: str) -> None:
    """
    Check that rsync is installed.

    :param where: Names this machine: `here` or `there`
    :raises UserError: when it is not; the text names the command to install it
    """
    if shutil.which('rsync') is not None:
        return
    command = next(
        (c for c in _INSTALL_COMMANDS if shutil.which(c.partition(' ')[0])),
        _INSTALL_COMMANDS[0],
    )
    raise UserError(
        f'rsync is not installed {where}, which sends the code: install it '
        f"{where} by 'sudo {command} rsync'"
    )
