# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Parameter files and other files of a launch in folders like `/tmp`.

The guard or another terminal may have to remove them, knowing only what the
launcher has told it, and other users may write to the folders. So a folder is
identified by its device and inode, too, is opened without following links,
and is used through its descriptor. Only files that the launcher makes there
are removed; anything else stays.

This module is part of the guard and imports little.
"""

from collections.abc import Callable, Iterable
from contextlib import suppress
import os
import re
import stat
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.frozen import dataclass

if TYPE_CHECKING:
    from colcon_yamllaunch.plan.plan import ParameterFile, Process

#: How the name of a folder for parameter files begins.
FOLDER_PREFIX = 'colcon_launch_'
#: What the names of parameter files end with, before it a number.
FILE_SUFFIX = '.yaml'

_FLAGS = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC


@dataclass(frozen=True, slots=True)
class OwnFile:
    """
    A file or folder of a launch, told apart from others of its path.

    :param path: An absolute path
    """

    path: str
    device: int
    inode: int

    @staticmethod
    def of(path: str) -> 'OwnFile':
        """
        Return what is at a path.

        :raises OSError: when there is nothing
        """
        status = os.stat(path, follow_symlinks=False)
        return OwnFile(path, status.st_dev, status.st_ino)

    def is_at(self, status: os.stat_result) -> bool:
        """Return whether a status is that of this file, and ours."""
        found = status.st_dev, status.st_ino, status.st_uid
        return found == (self.device, self.inode, os.getuid())


def remove_parameter_files(folder: OwnFile) -> None:
    """
    Remove the folder with the parameter files of a launch.

    What else is in it stays, and then so does the folder.
    """
    name = os.path.basename(folder.path)
    with suppress(OSError):
        descriptor = os.open(folder.path, _FLAGS)
        try:
            status = os.fstat(descriptor)
            if (
                not name.startswith(FOLDER_PREFIX)
                or not folder.is_at(status)
                or stat.S_IMODE(status.st_mode) & 0o066
            ):
                return
            for entry in os.listdir(descriptor):
                _remove_parameter_file(descriptor, entry)
            if folder.is_at(os.stat(folder.path, follow_symlinks=False)):
                # a folder that is not empty cannot be removed like this
                os.rmdir(folder.path)
        finally:
            os.close(descriptor)


def remove_file(file: OwnFile) -> None:
    """Remove a file or socket if it still is the one that was made."""
    folder, name = os.path.split(file.path)
    with suppress(OSError):
        descriptor = os.open(folder, _FLAGS)
        try:
            status = os.stat(name, dir_fd=descriptor, follow_symlinks=False)
            if file.is_at(status) and not stat.S_ISDIR(status.st_mode):
                os.unlink(name, dir_fd=descriptor)
        finally:
            os.close(descriptor)


def _remove_parameter_file(folder: int, name: str) -> None:
    # LABEL-NUMBER-INDEX.yaml
    stem = name.removesuffix(FILE_SUFFIX)
    numbers = stem.rsplit('-', 2)[1:]
    if stem == name or len(numbers) != 2:
        return
    status = os.stat(name, dir_fd=folder, follow_symlinks=False)
    if stat.S_ISREG(status.st_mode) and all(map(str.isdecimal, numbers)):
        os.unlink(name, dir_fd=folder)


class ParameterFiles:
    """
    Parameter files in one private folder, made when the first is needed.

    :param made: Receives the folder when it is made
    """

    def __init__(self, made: Callable[[OwnFile], None]) -> None:
        self._made = made
        self._folder: OwnFile | None = None
        # what each of them has now
        self._contents: dict[str, str] = {}

    def command_line(self, number: int, process: 'Process') -> list[str]:
        """
        Return the arguments of a process with paths for parameter files.

        :param number: The number of the process in the plan
        :raises OSError: when a file cannot be written
        """
        return [
            argument
            if isinstance(argument, str)
            else self._path(number, index, process.label, argument)
            for index, argument in enumerate(process.argv)
        ]

    def give(self, argv: Iterable[str], user: int) -> None:
        """
        Let another user read those of the files that a command line names.

        :param user: The number of the user
        :raises OSError: when that is not possible
        """
        folder = '' if self._folder is None else self._folder.path
        for argument in argv:
            if folder and os.path.dirname(argument) == folder:
                # nobody else can list it, or read files in it
                os.chmod(folder, 0o711)
                os.chmod(argument, 0o600)
                os.chown(argument, user, -1)

    def remove(self) -> None:
        """Remove the folder, if there is one."""
        if self._folder is not None:
            remove_parameter_files(self._folder)
            self._folder = None
            self._contents.clear()

    def _path(
        self, number: int, index: int, label: str, argument: 'ParameterFile'
    ) -> str:
        name = re.sub(r'[^A-Za-z0-9_.-]', '_', label)[:100]
        file = f'{name}-{number}-{index}{FILE_SUFFIX}'
        if self._folder is None:
            self._folder = _make_folder(file, argument.content)
            self._made(self._folder)
        elif self._contents.get(file) != argument.content:
            _write(self._folder.path, file, argument.content)
        self._contents[file] = argument.content
        return os.path.join(self._folder.path, file)


def _make_folder(file: str, content: str) -> OwnFile:
    """Make a folder, with a first file, where there is room for it."""
    # few launches need one, and the guard never does
    import tempfile

    from colcon_yamllaunch.common.files import temporary_folders

    problem: OSError | None = None
    for temporary in temporary_folders(os.environ):
        folder = None
        try:
            path = tempfile.mkdtemp(prefix=FOLDER_PREFIX, dir=temporary)
            folder = OwnFile.of(os.path.abspath(path))
            _write(folder.path, file, content)
        except OSError as error:
            problem = problem or error
            if folder is not None:
                remove_parameter_files(folder)
        else:
            return folder
    assert problem is not None
    raise problem


def _open_private(path: str, flags: int) -> int:
    return os.open(path, flags, 0o600)


def _write(folder: str, file: str, content: str) -> None:
    path = os.path.join(folder, file)
    # other users may enter the folder, see `ParameterFiles.give`
    with open(path, 'w', encoding='utf-8', opener=_open_private) as stream:
        stream.write(content)
