# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The results of a sweep, and the folder that has them.

`sweep.json` identifies the sweep; `journal.jsonl` has the result of each run,
as soon as it is known. `results.csv`, `junit.xml` and `report.html` are made
from the two (see `reports`), and `runs/NUMBER/` has the logs of a run.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import field, replace
import fcntl
import hashlib
import json
import os
from pathlib import Path
import shutil
import time
from typing import Any, Literal

from colcon_yamllaunch.common.codec import Codec, CodecError, to_json
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.files import read_json, write_json
from colcon_yamllaunch.common.fingerprint import digest
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.plan.position import shown_path
from colcon_yamllaunch.sweep.table import RunTable

#: Exists in each folder of a sweep, and in no other.
_DEFINITION = 'sweep.json'
_FORMAT = 1
JOURNAL = 'journal.jsonl'
RESULTS = 'results.csv'
JUNIT = 'junit.xml'
REPORT = 'report.html'
#: In the folder of a run: the messages of its planning, if there were any.
MESSAGES = 'messages.log'
_RUNS = 'runs'
#: The files for Slurm, and in it the results of its tasks; see `slurm_task`.
SLURM = 'slurm'
DONE = 'done'
ARRAYS = 'arrays.json'
#: Seconds that the runs of a killed sweep have to end, how many of them pass
#: without a message, and the interval of the checks.
_LOCK_TIMEOUT = 15.0
_QUIET = 1.0
_INTERVAL = 0.05
#: Characters of a reason that are kept.
_REASON = 1000
#: The limit of numbers that can be plotted.
_LARGEST = 1e100
#: A later version may have written the journal.
_CODEC = Codec(accept_unknown=True)

#: How a run ended: its launch exits with 0; it does not; or there was none, or
#: its result is unknown, as its machine failed.
Outcome = Literal['succeeded', 'failed', 'error']


@dataclass(frozen=True, slots=True)
class RunResult:
    """
    The result of a run.

    :param run: Its number
    :param reason: Why it did not succeed, in one line
    :param seconds: How long its launch took
    :param metrics: The values that were found, as they were written
    :param commit: The git commit of the code, with `-dirty` if it was
      modified; '' without git
    :param fingerprint: The fingerprint of the code, '' if it is unknown
    """

    run: int
    outcome: Outcome
    reason: str = ''
    seconds: float = 0.0
    metrics: Mapping[str, str] = field(default_factory=dict)
    commit: str = ''
    fingerprint: str = ''

    @property
    def succeeded(self) -> bool:
        """Whether the outcome is `succeeded`."""
        return self.outcome == 'succeeded'


def result_from_json(values: Any) -> RunResult | None:
    """Return the result that `values` describes, None if it is invalid."""
    try:
        result = _CODEC.from_json(RunResult, values)
    except CodecError:
        return None
    if result.run < 1 or abs(result.seconds) >= _LARGEST:
        return None
    return replace(
        result,
        reason=one_reason(result.reason),
        commit=one_reason(result.commit),
        fingerprint=one_reason(result.fingerprint),
    )


def failed_run(run: int, reason: str) -> RunResult:
    """Return the result of a run that could not be launched."""
    return RunResult(run, 'error', one_reason(reason))


def versions_of(
    results: Iterable[RunResult],
) -> dict[str, list[RunResult]]:
    """Return results by the version of the code, for people."""
    found: dict[str, list[RunResult]] = {}
    for result in results:
        found.setdefault(result.fingerprint, []).append(result)
    return {
        # modified code may have been committed since
        ', '.join(
            filter(None, [*dict.fromkeys(r.commit for r in runs), version])
        )
        or 'not recorded': runs
        for version, runs in found.items()
    }


def one_reason(text: str) -> str:
    """Return a reason in one line, shortened if it is very long."""
    line = ' '.join(text.split())
    return line if len(line) <= _REASON else f'{line[: _REASON - 1]}…'


def number_of(text: str) -> float | None:
    """Return the number that `text` is, None if it is none."""
    try:
        value = float(text)
    except ValueError:
        return None
    # larger ones were not measured, and sums of them overflow
    return value if abs(value) < _LARGEST else None


@dataclass(frozen=True, slots=True)
class SweepDefinition:
    """
    The properties that make two sweeps the same one.

    :param command: The command, for people
    :param target: The package and the launch file
    :param goal: Options that a run depends on, with their values as texts
    :param metrics: The metrics with their expressions
    """

    command: str
    target: tuple[str, ...]
    table: RunTable
    goal: Mapping[str, str]
    metrics: Mapping[str, str]

    @property
    def title(self) -> str:
        """The package and the launch file, for people."""
        return ' '.join(self.target)

    @property
    def fingerprint(self) -> str:
        """The same for the same sweep, and for no other."""
        runs = [[r.arguments, r.repeat] for r in self.table.runs]
        what = [self.target, runs, dict(self.goal), dict(self.metrics)]
        text = json.dumps(what, sort_keys=True)
        return hashlib.sha256(text.encode(errors='replace')).hexdigest()

    @property
    def default_name(self) -> str:
        """The name of the folder for the results."""
        words = [Path(word).name.partition('.')[0] for word in self.target]
        name = '-'.join(words)
        safe = ''.join(c if c.isalnum() or c in '-_' else '_' for c in name)
        return f'{safe[:80]}-{self.fingerprint[:8]}'


class ResultsFolder:
    """
    The folder of one sweep, locked as long as this process uses it.

    An existing folder must be of this sweep.

    :param path: Where it is
    :param say: Called with a message if another sweep still holds the lock
    :raises UserError: when it cannot be written, has the results of another
      sweep, or other files, or is in use
    """

    def __init__(
        self,
        path: Path,
        definition: SweepDefinition,
        say: Callable[[str], None],
    ) -> None:
        self.path = path
        self.definition = definition
        self._cwd = os.getcwd()
        self._lock = -1
        try:
            self._open(say)
            self.journal = SweepJournal(path / JOURNAL)
        except UserError:
            self._unlock()
            raise

    @property
    def results(self) -> Mapping[int, RunResult]:
        """The results so far, by the number of the run."""
        return self.journal.results

    def _open(self, say: Callable[[str], None]) -> None:
        path, file = self.path, self.path / _DEFINITION
        definition = self.definition
        try:
            path.mkdir(parents=True, exist_ok=True)
            self._lock = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
        except OSError as e:
            raise self._unwritable(e) from e
        self._wait_for_lock(say)
        known = read_json(file)
        values = known if isinstance(known, dict) else {}
        if known is None and any(entry != file for entry in path.iterdir()):
            raise UserError(
                f"--results: '{path}' has other files than the results of a "
                'sweep',
                'give a new or an empty folder',
            )
        journal = path / JOURNAL
        has_results = journal.exists() and journal.stat().st_size
        if known is None or not (
            has_results or (path / SLURM / ARRAYS).exists()
        ):
            # the command of an unused one had a mistake
            shutil.rmtree(path / _RUNS, ignore_errors=True)
            write_json(
                file,
                {
                    'format': _FORMAT,
                    'command': definition.command,
                    'fingerprint': definition.fingerprint,
                },
            )
        elif values.get('fingerprint') != definition.fingerprint:
            raise UserError(
                f"--results: '{path}' has the results of another sweep: "
                f'{values.get("command", "")}',
                'give another folder, or delete that one',
            )
        if not file.is_file() or not os.access(path, os.W_OK | os.X_OK):
            raise self._unwritable(None)

    def _wait_for_lock(self, say: Callable[[str], None]) -> None:
        """
        Lock the folder; the runs of a killed sweep have a moment to end.

        :raises UserError: when another sweep uses it
        """
        begin = time.monotonic()
        has_said = False
        while True:
            try:
                fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as e:
                waited = time.monotonic() - begin
                if waited > _LOCK_TIMEOUT:
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
        """Close the journal, and unlock the folder."""
        self.journal.close()
        self._unlock()

    def _unlock(self) -> None:
        if self._lock != -1:
            os.close(self._lock)
            self._lock = -1

    def run_folder(self, number: int) -> Path:
        """Return the folder for the logs of a run."""
        return self.path / _RUNS / f'{number:04}'

    def shown(self, path: Path) -> str:
        """Return a path as the user would write it."""
        return shown_path(str(path), self._cwd)

    def clear(self, number: int) -> None:
        """Delete the files of an earlier try of a run."""
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


@dataclass(frozen=True, slots=True)
class Code:
    """
    A version of the code that runs use.

    :param commit: The git commit, '' without git
    :param parts: The digest of each known file or folder
    """

    commit: str
    parts: Mapping[str, str]


class SweepJournal:
    """
    The result of each run, one JSON object a line.

    A line is written at once, so that no end of the sweep, not even SIGKILL,
    loses a result. The last line of a run counts; a torn line is ignored.

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
        # a torn line stays a line of its own
        self._is_torn = bool(data) and not data.endswith(b'\n')

    def plan(self, run: int, code: Code) -> str:
        """
        Record the code that a run is planned with; return its fingerprint.

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
        Record a result, with the code that its run was planned with.

        :raises UserError: when it cannot be written
        """
        commit, fingerprint = self._planned.get(result.run, ('', ''))
        result = replace(result, commit=commit, fingerprint=fingerprint)
        self.results[result.run] = result
        self._write(to_json(result))

    def forget(self, runs: Collection[int]) -> None:
        """
        Drop the results of runs that are to be run again.

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
        """Close the file."""
        os.close(self._file)

    def _failed(self, error: OSError) -> UserError:
        return UserError(
            f'{self._path} cannot be written: {error.strerror or error}',
            'what it has is kept, and the same command goes on from there',
        )
