# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What came of each run, one JSON object a line, as soon as it is known.

A line is written at once, so whatever ends the sweep, SIGKILL as well, what
is done is kept. The last line of a run counts; one that is torn does not.
"""

from collections.abc import Collection
from collections.abc import Mapping
from contextlib import suppress
import json
import os
from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.sweep.results.run_result import result_from_json
from colcon_yamllaunch.sweep.results.run_result import RunResult


class SweepJournal:
    """
    The journal of a sweep.

    :param path: The file; made when it is missing
    :raises UserError: when it cannot be read or written
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        #: The results so far, by the number of the run.
        self.results: dict[int, RunResult] = {}
        flags = os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC
        try:
            self._file = os.open(path, flags, 0o666)
            with open(self._file, 'rb', closefd=False) as file:
                data = file.read()
        except OSError as e:
            raise self._failed(e) from e
        for line in data.splitlines():
            with suppress(ValueError, RecursionError):
                self._read(json.loads(line))
        # what was torn stays a line of its own
        self._is_torn = bool(data) and not data.endswith(b'\n')

    def add(self, result: RunResult) -> None:
        """
        Keep a result.

        :raises UserError: when it cannot be written
        """
        self.results[result.run] = result
        self._write(result.as_json())

    def forget(self, runs: Collection[int]) -> None:
        """
        Have runs be done again.

        :raises UserError: when that cannot be written
        """
        if runs:
            self._write({'again': sorted(runs)})
        for run in runs:
            self.results.pop(run, None)

    def _read(self, values: Any) -> None:
        match values:
            case {'again': list(runs)}:
                for run in runs:
                    if isinstance(run, int):
                        self.results.pop(run, None)
            case _:
                result = result_from_json(values)
                if result is not None:
                    self.results[result.run] = result

    def _write(self, values: Mapping[str, Any]) -> None:
        text = json.dumps(values, ensure_ascii=False) + '\n'
        data = text.encode(errors='replace')
        if self._is_torn:
            data = b'\n' + data
            self._is_torn = False
        try:
            while data:
                data = data[os.write(self._file, data) :]
        except OSError as e:
            raise self._failed(e) from e

    def close(self) -> None:
        """Write nothing more."""
        os.close(self._file)

    def _failed(self, error: OSError) -> UserError:
        return UserError(
            f'{self._path} cannot be written: {error.strerror or error}; what '
            'it has is kept, and the same command goes on from there'
        )
