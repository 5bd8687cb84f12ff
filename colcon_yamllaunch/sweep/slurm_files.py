# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What a sweep and its tasks tell one another, in the folder of its results.

`slurm/common.json` has what all runs have in common, `runs/NUMBER/plan.json`
what one has; `slurm/array-N.json` says which run each task of an array job
is, and `slurm/done/NUMBER.json` what came of it. The folder is on a file
system that the nodes share.
"""

from collections.abc import Iterator
from collections.abc import Mapping
from contextlib import suppress
import json
import os
from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.codec import Codec
from colcon_yamllaunch.common.codec import only
from colcon_yamllaunch.common.codec import to_json
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.json_files import read_json
from colcon_yamllaunch.engine.output.line_pattern import LinePattern
from colcon_yamllaunch.sweep.results import ARRAYS
from colcon_yamllaunch.sweep.results import DONE
from colcon_yamllaunch.sweep.results import result_from_json
from colcon_yamllaunch.sweep.results import RunResult
from colcon_yamllaunch.sweep.results import SLURM
from colcon_yamllaunch.sweep.results import write_text
from colcon_yamllaunch.sweep.run import Goal

_COMMON = 'common.json'
_CODEC = Codec(
    special={
        LinePattern: (
            lambda pattern: pattern.text,
            lambda data: LinePattern(only(str, data)),
        )
    }
)
PLAN = 'plan.json'


@dataclass(frozen=True, slots=True)
class Common:
    """
    What all runs have in common.

    :param environment: The environment of their processes
    :param user: That of the user; what is another one on a node was set by
      Slurm
    :param share_network: Whether runs stay in the network of the machine
    """

    goal: Goal
    environment: Mapping[str, str]
    user: Mapping[str, str]
    share_network: bool = False


class SlurmFiles:
    """
    These files.

    :param results: The folder of the results
    """

    def __init__(self, results: Path) -> None:
        self.folder = results / SLURM
        self.done = self.folder / DONE
        #: Where tasks write what does not get to a log of their run.
        self.output = self.folder / 'output'

    def make(self) -> None:
        """
        Make the folders.

        :raises UserError: when that is not possible
        """
        try:
            for folder in (self.done, self.output):
                folder.mkdir(parents=True, exist_ok=True)
        except OSError as e:
            raise _unwritable(self.folder, e) from e

    def write_common(self, common: Common) -> None:
        """
        Write what all runs have in common; only the user can read it.

        :raises UserError: when that is not possible
        """
        path = self.folder / _COMMON
        try:
            # there may be secrets in an environment
            path.touch(mode=0o600)
            path.chmod(0o600)
            text = json.dumps(_CODEC.to_json(common))
            path.write_text(text, encoding='utf-8')
        except OSError as e:
            raise _unwritable(path, e) from e

    def read_common(self) -> Common:
        """
        Return what all runs have in common.

        :raises OSError: when it cannot be read
        """
        text = (self.folder / _COMMON).read_text(encoding='utf-8')
        return _CODEC.from_json(Common, json.loads(text), 'common')

    def arrays(self) -> dict[int, list[int]]:
        """Return the runs of each array job, by its number."""
        known = read_json(self.folder / ARRAYS)
        found = {}
        for job, runs in (known if isinstance(known, dict) else {}).items():
            if job.isdigit() and isinstance(runs, list):
                found[int(job)] = [run for run in runs if isinstance(run, int)]
        return found

    def write_arrays(self, arrays: Mapping[int, list[int]]) -> None:
        """
        Keep in mind which array jobs there are.

        :raises UserError: when that is not possible
        """
        path = self.folder / ARRAYS
        try:
            write_text(path, json.dumps(arrays))
        except OSError as e:
            raise _unwritable(path, e) from e

    def write_list(self, runs: list[int]) -> Path:
        """
        Write the runs of an array job, and return the file.

        :raises UserError: when that is not possible
        """
        number = 1
        while (path := self.folder / f'array-{number}.json').exists():
            number += 1
        try:
            write_text(path, json.dumps(runs))
        except OSError as e:
            raise _unwritable(path, e) from e
        return path

    def write_plan(self, folder: Path, values: Mapping[str, Any]) -> None:
        """
        Write what a run has.

        :param folder: The folder of the run
        :raises UserError: when that is not possible
        """
        path = folder / PLAN
        try:
            folder.mkdir(parents=True, exist_ok=True)
            path.touch(mode=0o600)
            path.write_text(json.dumps(values), encoding='utf-8')
        except OSError as e:
            raise _unwritable(path, e) from e

    def write_result(self, result: RunResult) -> None:
        """
        Write what came of a run, on the node.

        :raises OSError: when that is not possible
        """
        text = json.dumps(to_json(result))
        write_text(self.done / f'{result.run}.json', text)

    def results(self) -> Iterator[RunResult]:
        """Iterate over what came of runs; each is told once."""
        # a file system over the network tells what is new in a folder when
        # that is opened
        try:
            names = os.listdir(self.done)
        except OSError:
            return
        for name in names:
            if not name[0].isdigit():
                continue
            path = self.done / name
            result = result_from_json(read_json(path))
            if result is not None:
                yield result
                with suppress(OSError):
                    path.unlink()


def _unwritable(path: Path, error: OSError) -> UserError:
    return UserError(
        f"'{path}' cannot be written: {error.strerror or error}",
        'name another folder with --results DIR',
    )
