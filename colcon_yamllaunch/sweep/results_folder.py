# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The folder with all that a sweep leaves.

`sweep.json` says which sweep it is, `journal.jsonl` what came of each run, as
soon as that is known; `results.csv`, `junit.xml` and `report.html` are made
from the two, and `runs/NUMBER/` has the logs of a run.
"""

from collections.abc import Callable
from collections.abc import Mapping
from contextlib import suppress
import fcntl
import hashlib
import json
import os
from pathlib import Path
import shutil
import time
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.json_files import read_json
from colcon_yamllaunch.common.json_files import write_json
from colcon_yamllaunch.sweep.run_table import RunTable

#: What tells a folder of a sweep from others.
_DEFINITION = 'sweep.json'
_FORMAT = 1
JOURNAL = 'journal.jsonl'
RESULTS = 'results.csv'
JUNIT = 'junit.xml'
REPORT = 'report.html'
#: In the folder of a run: what was said as it was planned, if anything was.
MESSAGES = 'messages.log'
_RUNS = 'runs'
#: What Slurm needs, and in it what its tasks tell; see `slurm_files`.
SLURM = 'slurm'
DONE = 'done'
ARRAYS = 'arrays.json'
#: Seconds that the runs of a sweep that was killed have to end, how many of
#: them pass before that is said, and how many between two looks.
_PATIENCE = 15.0
_QUIET = 1.0
_INTERVAL = 0.05


@dataclass(frozen=True, slots=True)
class SweepDefinition:
    """
    What makes a sweep the same one when its command is given again.

    :param command: The command, for people
    :param target: The package and the launch file
    :param goal: What a run is to achieve and how it is started: options with
      their values, as texts
    :param metrics: The metrics with their expressions
    """

    command: str
    target: tuple[str, ...]
    table: RunTable
    goal: Mapping[str, str]
    metrics: Mapping[str, str]

    @property
    def fingerprint(self) -> str:
        """What is the same for the same sweep, and for no other."""
        runs = [[r.arguments, r.repeat] for r in self.table.runs]
        what = [self.target, runs, dict(self.goal), dict(self.metrics)]
        text = json.dumps(what, sort_keys=True)
        return hashlib.sha256(text.encode(errors='replace')).hexdigest()


class ResultsFolder:
    """
    The folder of one sweep, locked as long as this process has it.

    :param path: Where it is
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = -1

    def open(
        self, definition: SweepDefinition, say: Callable[[str], None]
    ) -> None:
        """
        Make it, or go on with what is there.

        :param say: Is told that what an earlier sweep left is waited for
        :raises UserError: when it cannot be written, has the results of
          another sweep, or something else, or is in use
        """
        path = self.path
        try:
            path.mkdir(parents=True, exist_ok=True)
            self._lock = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
        except OSError as e:
            raise self._unwritable(e) from e
        self._wait_for_others(say)
        known = read_json(path / _DEFINITION)
        fingerprint = definition.fingerprint
        if known is None and any(
            entry for entry in path.iterdir() if entry.name != _DEFINITION
        ):
            raise UserError(
                f"--results: '{path}' has other files than the results of a "
                'sweep',
                'give a new or an empty folder',
            )
        if known is not None and self._is_unused():
            # of a sweep that came to nothing, as its command had a mistake
            known = None
            shutil.rmtree(path / _RUNS, ignore_errors=True)
        if known is not None and (
            not isinstance(known, dict)
            or known.get('fingerprint') != fingerprint
        ):
            command = known.get('command') if isinstance(known, dict) else ''
            raise UserError(
                f"--results: '{path}' has the results of another sweep: "
                f'{command}',
                'give another folder, or delete that one',
            )
        if known is None:
            write_json(
                path / _DEFINITION,
                {
                    'format': _FORMAT,
                    'command': definition.command,
                    'fingerprint': fingerprint,
                },
            )
            if not (path / _DEFINITION).is_file():
                raise self._unwritable(None)
        if not os.access(path, os.W_OK | os.X_OK):
            raise self._unwritable(None)

    def _is_unused(self) -> bool:
        """Tell whether no run has come of the sweep that it is of."""
        try:
            is_empty = not (self.path / JOURNAL).stat().st_size
        except OSError:
            is_empty = True
        return is_empty and not (self.path / SLURM / ARRAYS).exists()

    def _wait_for_others(self, say: Callable[[str], None]) -> None:
        """
        Lock it; the runs of a sweep that was killed have a moment to end.

        :raises UserError: when another sweep is at work
        """
        begin = time.monotonic()
        has_said = False
        while True:
            try:
                fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as e:
                waited = time.monotonic() - begin
                if waited > _PATIENCE:
                    raise UserError(
                        f'another colcon sweep is at work in {self.path}',
                        'wait for it, or give another folder with --results',
                    ) from e
                if waited > _QUIET and not has_said:
                    has_said = True
                    say(f'waiting for the colcon sweep in {self.path} to end')
                time.sleep(_INTERVAL)
            except OSError:
                # a file system without locks
                return
            else:
                return

    def close(self) -> None:
        """Leave it to others."""
        if self._lock != -1:
            os.close(self._lock)
            self._lock = -1

    def run_folder(self, number: int) -> Path:
        """Return where the logs of a run are."""
        return self.path / _RUNS / f'{number:04}'

    def clear(self, number: int) -> None:
        """Delete what an earlier try of a run left."""
        shutil.rmtree(self.run_folder(number), ignore_errors=True)
        with suppress(OSError):
            (self.path / SLURM / DONE / f'{number}.json').unlink()

    def _unwritable(self, error: OSError | None) -> UserError:
        reason = (error and error.strerror) or 'no permission, or no room'
        return UserError(
            f"the folder for the results, '{self.path}', cannot be written: "
            f'{reason}',
            'name another one with --results DIR',
        )


def default_name(definition: SweepDefinition) -> str:
    """Return what the folder of a sweep is called, the same each time."""
    words = [Path(word).name.partition('.')[0] for word in definition.target]
    name = '-'.join(words)
    safe = ''.join(c if c.isalnum() or c in '-_' else '_' for c in name)
    return f'{safe[:80]}-{definition.fingerprint[:8]}'


def write_text(path: Path, text: str | bytes) -> None:
    """
    Write a file that appears complete.

    :raises OSError: when it cannot be written
    """
    data = text if isinstance(text, bytes) else text.encode(errors='replace')
    temporary = path.with_name(f'.{path.name}.{os.getpid()}')
    try:
        temporary.write_bytes(data)
        temporary.replace(path)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise


def definition_values(values: Mapping[str, Any]) -> dict[str, str]:
    """Return options as texts, for a definition; those not given left out."""
    return {
        name: str(value)
        for name, value in values.items()
        if value not in (None, (), False)
    }


def shown_path(path: Path) -> str:
    """Return a path as it is from here, if it is below."""
    try:
        return str(path.relative_to(Path.cwd()))
    except (OSError, ValueError):
        return str(path)
