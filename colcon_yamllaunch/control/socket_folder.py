# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The private folders with the sockets of a user's running launches.

The first usable one has the socket of a launch, and all are looked at for
those of others, as another terminal may have other variables:

- `colcon-launch` in `XDG_RUNTIME_DIR` (XDG Base Directory Specification)
  where that is a folder of the user's own that nobody else may write to; else
  in the folder that it stands for, `/run/user/UID` (pam_systemd), likewise;
- `colcon-launch-UID` in each folder for temporary files.

A folder that others made or may enter is not used. Everything in it is
reached through its descriptor, so it cannot be exchanged between a check and
its use, and the path of a socket is never too long.
"""

from collections.abc import Mapping
from contextlib import suppress
import os
from pathlib import Path
import stat

from colcon_yamllaunch.common.temporary_folders import temporary_folders

#: The ending of a socket's name; before it stands the launcher's process id.
SUFFIX = '.sock'

#: Where the system makes a folder for each user who is logged in.
USER_FOLDERS = '/run/user'

_NAME = 'colcon-launch'
_FLAGS = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC


class FolderError(Exception):
    """A folder cannot be used; the text says why, in one line."""


def folders(environment: Mapping[str, str]) -> tuple[Path, ...]:
    """
    Return the folders where sockets may be, the one to be tried first.

    Who gives both variables, and a runtime folder that is not the system's,
    wants to be apart from the other launches of the user.
    """
    usual = f'{USER_FOLDERS}/{os.getuid()}'
    runtime = environment.get('XDG_RUNTIME_DIR', '')
    if not os.path.isabs(runtime) or not _is_own(runtime):
        runtime = usual
    found = [Path(runtime) / _NAME] if _is_own(runtime) else []
    places = temporary_folders(environment)
    if runtime != usual and environment.get('TMPDIR'):
        places = places[:1]
    found += [folder / f'{_NAME}-{os.getuid()}' for folder in places]
    return tuple(found)


def has_sockets(environment: Mapping[str, str]) -> bool:
    """Tell whether launches of the user may run; this takes no time."""
    for folder in folders(environment):
        with suppress(OSError):
            if any(name.endswith(SUFFIX) for name in os.listdir(folder)):
                return True
    return False


def open_folder(path: Path, *, make: bool) -> int:
    """
    Check that a folder is the user's alone, and return its descriptor.

    :raises FolderError: when it is not the user's alone, or cannot be made
    :raises FileNotFoundError: when it does not exist
    """
    try:
        if make:
            # if there is one already, whose it is shows below
            with suppress(FileExistsError):
                path.mkdir(mode=0o700)
        descriptor = os.open(path, _FLAGS)
    except FileNotFoundError:
        raise
    except OSError as error:
        raise FolderError(f'{path}: {error.strerror}') from error
    status = os.fstat(descriptor)
    if status.st_uid != os.getuid() or stat.S_IMODE(status.st_mode) & 0o077:
        os.close(descriptor)
        raise FolderError(
            f'{path} is not yours alone; remove it, or make it so: '
            f'chmod 700 {path}'
        )
    return descriptor


def inside(descriptor: int, name: str) -> str:
    """Return a short path of something in an open folder."""
    return f'/proc/self/fd/{descriptor}/{name}'


def _is_own(path: str) -> bool:
    try:
        status = os.stat(path)
    except OSError:
        return False
    mode = stat.S_IMODE(status.st_mode)
    return (
        stat.S_ISDIR(status.st_mode)
        and status.st_uid == os.getuid()
        and not mode & 0o022
    )
