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
from dataclasses import replace
import json
import os
from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.fingerprint import digest
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.sweep.run_result import result_from_json
from colcon_yamllaunch.sweep.run_result import RunResult


@dataclass(frozen=True, slots=True)
class Code:
    """
    A version of the code that runs use.

    :param commit: The git commit, '' without git
    :param parts: The digest of each file or folder of it that is known
    """

    commit: str
    parts: Mapping[str, str]


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
        # the commit and the fingerprint that each run was planned with
        self._planned: dict[int, tuple[str, str]] = {}
        # the parts of each version, by its fingerprint
        self._versions: dict[str, dict[str, str]] = {}
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

    def plan(self, run: int, code: Code) -> str:
        """
        Keep which code a run is planned with, and return its fingerprint.

        Runs may use different parts of the code: it is another version only
        if a part that both versions have differs.

        :raises UserError: when it cannot be written
        """
        parts = code.parts
        same = (
            name
            for name, known in reversed(self._versions.items())
            if all(known.get(path, one) == one for path, one in parts.items())
        )
        name = next(same, '')
        if not name:
            text = json.dumps(parts, sort_keys=True)
            name = digest(text.encode())[:8]
        known = self._versions.setdefault(name, {})
        if more := dict(parts.items() - known.items()):
            known.update(more)
            self._write({'fingerprint': name, 'parts': more})
        if self._planned.get(run) != (code.commit, name):
            self._planned[run] = code.commit, name
            values = {'planned': run, 'commit': code.commit}
            self._write({**values, 'fingerprint': name})
        return name

    def add(self, result: RunResult) -> None:
        """
        Keep a result, with the code that its run was planned with.

        :raises UserError: when it cannot be written
        """
        commit, fingerprint = self._planned.get(result.run, ('', ''))
        result = replace(result, commit=commit, fingerprint=fingerprint)
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
            case {'planned': int(run)}:
                self._planned[run] = (
                    str(values.get('commit', '')),
                    str(values.get('fingerprint', '')),
                )
            case {'fingerprint': str(name), 'parts': dict(parts)}:
                self._versions.setdefault(name, {}).update(parts)
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
            f'{self._path} cannot be written: {error.strerror or error}',
            'what it has is kept, and the same command goes on from there',
        )
