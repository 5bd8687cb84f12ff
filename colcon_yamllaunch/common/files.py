# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Reading and writing files, and where temporary ones may go."""

from collections.abc import Iterable, Mapping
from contextlib import suppress
import errno
import json
import os
from pathlib import Path
import stat
from typing import Any

#: The largest file that is read where nothing else is said (bytes).
MAXIMUM_SIZE = 64 * 1024 * 1024

# as the file system of pipes without a name shows them
_OWN_PIPE = '/pipe:['
#: Where everybody may write, as the Filesystem Hierarchy Standard has it; the
#: last one is in memory, so that a full disk does not matter to it (glibc).
SHARED_FOLDERS = ('/tmp', '/var/tmp', '/dev/shm')

#: Where installers put files; nobody edits them.
_SYSTEM = tuple(
    f'/{name}/'
    for name in (
        *('bin', 'boot', 'dev', 'etc', 'lib', 'lib32', 'lib64', 'nix', 'opt'),
        *('proc', 'run', 'sbin', 'snap', 'sys', 'usr'),
    )
)

# what is written later, or None if all is written at once
_put_off: list[Path] | None = None


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


def read_json(path: Path) -> Any:
    """Return what a file of JSON holds, None if it is missing or damaged."""
    try:
        return json.loads(content_of(path))
    except (OSError, ValueError, RecursionError):
        return None


def write_json(
    path: Path, values: Mapping[str, Any], mode: int = 0o666
) -> None:
    """Write a cache file as :func:`save_json` does, if that is possible."""
    with suppress(OSError):
        save_json(path, values, mode)


def save_json(
    path: Path, values: Mapping[str, Any], mode: int = 0o666
) -> None:
    """
    Write JSON to a file that appears complete or not at all, with its folder.

    :param values: What it is to hold
    :param mode: Who may read and write it
    :raises OSError: when it cannot be written
    """
    write_file(path, json.dumps(values).encode(), mode)


def temporary_folders(environment: Mapping[str, str]) -> tuple[Path, ...]:
    """
    Return the folders for temporary files, the one to be tried first.

    Python's :mod:`tempfile` ends in the current folder, which is the user's
    workspace, if none of the usual places can be written to.

    :param environment: `TMPDIR` in it comes first if it is absolute (POSIX)
    """
    own = environment.get('TMPDIR', '')
    folders = (own, *SHARED_FOLDERS) if os.path.isabs(own) else SHARED_FOLDERS
    return tuple(Path(folder) for folder in dict.fromkeys(folders))


def split_path(value: str | None) -> list[str]:
    """Return the folders that a variable such as PATH lists, if any."""
    return [entry for entry in (value or '').split(os.pathsep) if entry]


def put_off() -> None:
    """Postpone flushing of all disks to :func:`catch_up`."""
    global _put_off
    _put_off = []


def catch_up() -> None:
    """Write what was put off."""
    global _put_off
    folders, _put_off = _put_off, None
    if folders:
        sync_file_systems(folders)


def sync_file_systems(folders: Iterable[Path]) -> None:
    """
    Write all that is not yet on the disks of some folders, in one call each.

    Folders on the same disk count once. Where this cannot be done, nothing is.
    """
    if _put_off is not None:
        _put_off.extend(folders)
        return
    # this takes some milliseconds, and few launches build
    import ctypes

    done = set()
    for folder in folders:
        with suppress(OSError, AttributeError):
            descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
            try:
                device = os.fstat(descriptor).st_dev
                if device not in done:
                    # of Linux, see syncfs(2); Python has only sync(2), which
                    # waits for all disks there are
                    ctypes.CDLL(None).syncfs(descriptor)
                    done.add(device)
            finally:
                os.close(descriptor)


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


def is_user_file(path: str, workspace: tuple[str, ...] = ()) -> bool:
    """
    Return whether users may edit `path`: installers did not put it there.

    :param workspace: Folders of the user, with a separator at the end; they
      may be below a system folder
    """
    return os.path.isabs(path) and (
        not path.startswith(_SYSTEM) or path.startswith(workspace)
    )
