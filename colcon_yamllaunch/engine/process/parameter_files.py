# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The files that stand for parameters on command lines."""

from collections.abc import Callable
import os
from pathlib import Path
import re
import tempfile

from colcon_yamllaunch.common.temporary_folders import temporary_folders
from colcon_yamllaunch.engine.process.own_files import FILE_SUFFIX
from colcon_yamllaunch.engine.process.own_files import FOLDER_PREFIX
from colcon_yamllaunch.engine.process.own_files import Place
from colcon_yamllaunch.engine.process.own_files import remove_parameter_files
from colcon_yamllaunch.plan.plan import ParameterFile
from colcon_yamllaunch.plan.plan import Process


class ParameterFiles:
    """
    Parameter files in one private folder, made when the first is needed.

    :param made: Is told the folder when it is made
    """

    def __init__(self, made: Callable[[Place], None]) -> None:
        self._made = made
        self._folder: Place | None = None
        # what each of them has now
        self._contents: dict[str, str] = {}

    def command_line(self, number: int, process: Process) -> list[str]:
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

    def remove(self) -> None:
        """Remove the folder, if there is one."""
        if self._folder is not None:
            remove_parameter_files(self._folder)
            self._folder = None
            self._contents.clear()

    def _path(
        self, number: int, index: int, label: str, argument: ParameterFile
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


def _make_folder(file: str, content: str) -> Place:
    """Make a folder, with a first file, where there is room for it."""
    problem: OSError | None = None
    for temporary in temporary_folders(os.environ):
        place = None
        try:
            path = tempfile.mkdtemp(prefix=FOLDER_PREFIX, dir=temporary)
            place = Place.of(os.path.abspath(path))
            _write(place.path, file, content)
        except OSError as error:
            problem = problem or error
            if place is not None:
                remove_parameter_files(place)
        else:
            return place
    assert problem is not None
    raise problem


def _write(folder: str, file: str, content: str) -> None:
    Path(folder, file).write_text(content, encoding='utf-8')
