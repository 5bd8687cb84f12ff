# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Files that other programs and people read and write."""

import errno
import os
from pathlib import Path
import stat

#: The largest file that is read where nothing else is said (bytes).
MAXIMUM_SIZE = 64 * 1024 * 1024

# as the file system of pipes without a name shows them
_OWN_PIPE = '/pipe:['


def content_of(path: str | Path, limit: int = MAXIMUM_SIZE) -> bytes:
    """
    Return what an ordinary file holds, or a pipe without a name.

    A named pipe might never end, a device has no end, and even to open one
    may do something.

    :param limit: The most that is read, in bytes
    :raises OSError: when it is another file, a larger one, or cannot be read;
      its `strerror` is fit to be shown
    """
    _refuse_endless(os.stat(path).st_mode, path)
    # whatever it is exchanged for meanwhile, opening it does not wait
    descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    with open(descriptor, 'rb') as file:
        status = os.fstat(descriptor)
        _refuse_endless(status.st_mode, path)
        os.set_blocking(descriptor, True)
        # files of /proc have no size
        content = file.read(min(status.st_size or limit, limit) + 1)
    if max(len(content), status.st_size) > limit:
        raise OSError(
            errno.EFBIG, f'it has more than {limit} bytes', str(path)
        )
    return content


def text_of(path: Path) -> str:
    """Return the text of a file, whatever is in it; empty without one."""
    try:
        text = content_of(path).decode('utf-8', errors='replace')
    except OSError:
        return ''
    # as in files that are opened as texts
    return text.replace('\r\n', '\n').replace('\r', '\n')


def names_in(folder: str | Path) -> list[str]:
    """Return the names in a folder, in any order; none without one."""
    try:
        return os.listdir(folder)
    except OSError:
        return []


def write_file(path: Path, content: bytes, mode: int = 0o666) -> None:
    """
    Write a file that appears complete, with its folder.

    :param mode: Who may read and write it
    :raises OSError: when it cannot be written
    """
    temporary = path.with_name(f'.{path.name}.{os.getpid()}')
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary.unlink(missing_ok=True)
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL
    try:
        with open(os.open(temporary, flags, mode), 'wb') as file:
            file.write(content)
        temporary.replace(path)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise


def _refuse_endless(mode: int, path: str | Path) -> None:
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(
            errno.EISDIR, os.strerror(errno.EISDIR), str(path)
        )
    if stat.S_ISREG(mode):
        return
    if not stat.S_ISFIFO(mode) or _OWN_PIPE not in os.path.realpath(path):
        kind = 'a named pipe' if stat.S_ISFIFO(mode) else 'a device'
        raise OSError(
            errno.EINVAL, f'it is {kind}, not an ordinary file', str(path)
        )
