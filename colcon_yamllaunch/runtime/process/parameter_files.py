# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The files that stand for parameters on command lines."""

from collections.abc import Callable
from pathlib import Path
import re
import shutil
import tempfile

from colcon_yamllaunch.language.plan.plan import ParameterFile
from colcon_yamllaunch.language.plan.plan import Process


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
            path = self._make_folder() / f'{name}-{number}-{index}.yaml'
            path.write_text(argument.content, encoding='utf-8')
            self._paths[key] = str(path)
        return self._paths[key]

    def _make_folder(self) -> Path:
        if self._folder is None:
            self._folder = Path(tempfile.mkdtemp(prefix='colcon_launch_'))
            self._made(self._folder)
        return self._folder
