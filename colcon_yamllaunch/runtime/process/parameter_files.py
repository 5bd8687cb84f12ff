# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The files that stand for parameters on command lines."""

from collections.abc import Callable
import os
from pathlib import Path
import re
import shutil
import tempfile

from colcon_yamllaunch.common.temporary_folders import temporary_folders
from colcon_yamllaunch.language.plan.plan import ParameterFile
from colcon_yamllaunch.language.plan.plan import Process

_PREFIX = 'colcon_launch_'


class ParameterFiles:
    """
    Parameter files in one private folder, made when the first is needed.

    :param made: Is told the folder when it is made
    """

    def __init__(self, made: Callable[[Path], None]) -> None:
        self._made = made
        self._folder: Path | None = None
        self._paths: dict[tuple[int, int], str] = {}

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
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None
            self._paths.clear()

    def _path(
        self, number: int, index: int, label: str, argument: ParameterFile
    ) -> str:
        key = (number, index)
        if key not in self._paths:
            name = re.sub(r'[^A-Za-z0-9_.-]', '_', label)[:100]
            name = f'{name}-{number}-{index}.yaml'
            if self._folder is None:
                self._folder = self._make_folder(name, argument.content)
                self._made(self._folder)
            else:
                _write(self._folder / name, argument.content)
            self._paths[key] = str(self._folder / name)
        return self._paths[key]

    def _make_folder(self, name: str, content: str) -> Path:
        """Make the folder, with a first file, where there is room for it."""
        problem: OSError | None = None
        for place in temporary_folders(os.environ):
            folder = None
            try:
                folder = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=place))
                _write(folder / name, content)
            except OSError as error:
                problem = problem or error
                if folder is not None:
                    shutil.rmtree(folder, ignore_errors=True)
            else:
                return folder
        assert problem is not None
        raise problem


def _write(path: Path, content: str) -> None:
    path.write_text(content, encoding='utf-8')
