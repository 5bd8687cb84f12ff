# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What Slurm is asked, by its own commands.

`sacct` works only where a cluster keeps accounts; `squeue` and `scontrol`
always do, but forget a job some minutes after its end (MinJobAge).
"""

from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
import re
import shutil
import subprocess

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass

#: Seconds that a command of Slurm may take.
_PATIENCE = 60.0
#: What slurm.conf(5) has as its default.
_ARRAY_SIZE = 1001
_JOB = re.compile(r'(\d+)(?:_(\d+))?')
# what each line of its commands begins with
_NAME = re.compile(r'^s[a-z]+: (?:error: |fatal: )?')
#: Jobs that are asked for at once, so that a command line is not too long.
_AT_ONCE = 500


class SlurmError(UserError):
    """Slurm does not do what it is asked; says what it said."""


@dataclass(frozen=True, slots=True)
class Ending:
    """
    What Slurm knows of the end of a task.

    :param state: As `OUT_OF_MEMORY`
    :param code: The exit code, as `1:0`
    :param node: Where it ran, '' if it did not
    """

    state: str
    code: str = ''
    node: str = ''


class SlurmClient:
    """
    Slurm, as the user has it.

    :param environment: The user's environment
    :raises SlurmError: when it is not installed
    """

    def __init__(self, environment: Mapping[str, str]) -> None:
        self._environment = dict(environment)
        path = environment.get('PATH')
        for name in ('sbatch', 'squeue', 'scancel', 'scontrol'):
            if shutil.which(name, path=path) is None:
                raise SlurmError(
                    f"--on slurm needs the command '{name}' of Slurm, and "
                    'there is none here',
                    'go to a machine of the cluster that has it',
                )
        self._has_accounts = shutil.which('sacct', path=path) is not None

    def array_size(self) -> int:
        """Return how many tasks an array job may have."""
        try:
            text = self._run('scontrol', 'show', 'config')
        except SlurmError:
            return _ARRAY_SIZE
        found = re.search(r'^MaxArraySize\s*=\s*(\d+)', text, re.MULTILINE)
        return _ARRAY_SIZE if found is None else max(1, int(found[1]))

    def submit(self, options: Sequence[str], script: str) -> int:
        """
        Submit a batch job, and return its number.

        :raises SlurmError: when Slurm does not take it
        """
        text = self._run('sbatch', '--parsable', *options, input_text=script)
        # behind a semicolon is the cluster
        number = text.strip().splitlines()[-1:] or ['']
        found = _JOB.match(number[0])
        if found is None:
            raise SlurmError(f"sbatch says '{text.strip()}', and no job")
        return int(found[1])

    def queue(
        self, jobs: Iterable[int]
    ) -> dict[tuple[int, int], tuple[str, str]]:
        """
        Return the tasks that wait, run or end, each by its job and index.

        Of each its state, as `PD` or `R`, and why it waits.

        :raises SlurmError: when Slurm does not answer
        """
        wanted = sorted(set(jobs))
        found: dict[tuple[int, int], tuple[str, str]] = {}
        for start in range(0, len(wanted), _AT_ONCE):
            some = wanted[start : start + _AT_ONCE]
            listed = ','.join(map(str, some))
            try:
                text = self._run(
                    'squeue',
                    *('--noheader', '--array', f'--jobs={listed}'),
                    *('--states=all', '--format=%F|%K|%t|%r'),
                )
            except SlurmError as e:
                # all of them are forgotten
                if 'Invalid job id' in str(e):
                    continue
                raise
            for line in text.splitlines():
                words = line.strip().split('|')
                if len(words) == 4 and words[0].isdigit():
                    index = int(words[1]) if words[1].isdigit() else 0
                    found[int(words[0]), index] = (words[2], words[3])
        return found

    def cancel(self, jobs: Iterable[int], *, kill: bool = False) -> None:
        """
        Have jobs end, those that have ended as well.

        :raises SlurmError: when Slurm does not answer
        """
        numbers = list(map(str, jobs))
        if not numbers:
            return
        if kill:
            self._run('scancel', '--quiet', '--signal=KILL', '-f', *numbers)
        self._run('scancel', '--quiet', *numbers)

    def ending(self, job: int, index: int) -> Ending | None:
        """Return what is known of the end of a task."""
        task = f'{job}_{index}'
        if self._has_accounts:
            try:
                text = self._run(
                    'sacct',
                    *('--noheader', '--parsable2', '--allocations'),
                    *('--jobs', task, '--format=State,ExitCode,NodeList'),
                )
            except SlurmError:
                # the cluster keeps none
                self._has_accounts = False
            else:
                for line in text.splitlines():
                    state, code, node, *_ = [*line.split('|'), '', '', '']
                    if state:
                        return Ending(state.split(' ')[0], code, node)
        try:
            text = self._run('scontrol', 'show', 'job', task, '--oneliner')
        except SlurmError:
            return None
        values = dict(re.findall(r'(\w+)=(\S*)', text))
        if 'JobState' not in values:
            return None
        node = values.get('NodeList', '')
        return Ending(
            values['JobState'],
            values.get('ExitCode', ''),
            '' if node == '(null)' else node,
        )

    def _run(self, *words: str, input_text: str = '') -> str:
        try:
            done = subprocess.run(
                words,
                input=input_text,
                env=self._environment,
                capture_output=True,
                text=True,
                errors='replace',
                timeout=_PATIENCE,
                check=False,
                # Ctrl-C is for the sweep
                start_new_session=True,
            )
        except subprocess.TimeoutExpired as e:
            raise SlurmError(
                f'{words[0]} has not answered in {_PATIENCE:g} s'
            ) from e
        except OSError as e:
            raise SlurmError(f'{words[0]}: {e.strerror or e}') from e
        if done.returncode:
            lines = (done.stderr or done.stdout).splitlines()
            said = [_NAME.sub('', line).strip() for line in lines]
            text = '; '.join(filter(None, said))
            raise SlurmError(text or f'exit code {done.returncode}')
        return done.stdout
