# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Slurm, through its commands.

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
_ANSWER_TIMEOUT = 60.0
#: The default of slurm.conf(5).
_ARRAY_SIZE = 1001
# the beginning of each line of an error
_NAME = re.compile(r'^s[a-z]+: (?:error: |fatal: )?')
#: Jobs in one query, so that the command line is not too long.
_AT_ONCE = 500
_OPTION = re.compile(r'[a-z][a-z-]*')
#: Options that the sweep itself sets.
_OURS = frozenset(
    (
        *('array', 'chdir', 'dependency', 'error', 'export', 'hold', 'input'),
        *('output', 'parsable', 'requeue', 'no-requeue', 'test-only', 'wait'),
        *('wrap', 'job-name'),
    )
)


class SlurmError(UserError):
    """Slurm reports an error; has its text."""


def read_slurm_options(option: str, text: str) -> tuple[str, ...]:
    """
    Return options of `sbatch`, written `slurm:partition=cpu,time=10`.

    A comma in brackets is part of a value, as in `nodelist=n[1,3]`.

    :param option: The option that has them, for errors
    :raises UserError: when they are written otherwise
    """
    kind, _, rest = text.partition(':')
    if kind != 'slurm':
        raise UserError(
            f'{option} is written slurm:OPTION=VALUE,… with options of '
            f"sbatch, such as slurm:partition=cpu,time=10, not '{text}'"
        )
    options = []
    for word in filter(None, re.split(r',(?![^\[]*\])', rest)):
        name, equals, value = word.partition('=')
        name = name.strip().removeprefix('--')
        if not _OPTION.fullmatch(name):
            raise UserError(
                f"{option}: '{word}' is no option of sbatch",
                'they are written name=value, as in partition=cpu; a comma '
                'separates them',
            )
        if name in _OURS:
            raise UserError(
                f"{option}: '{name}' is for the sweep to say, not for its user"
            )
        options.append(f'--{name}{equals}{value}')
    return tuple(options)


@dataclass(frozen=True, slots=True)
class Ending:
    """
    The end of a task.

    :param state: Such as `OUT_OF_MEMORY`
    :param code: The exit code, such as `1:0`
    :param node: Where it ran, '' if it did not
    """

    state: str
    code: str = ''
    node: str = ''


class SlurmClient:
    """
    The Slurm that the user can reach.

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

        :raises SlurmError: when Slurm refuses it
        """
        text = self._run('sbatch', '--parsable', *options, input_text=script)
        # behind a semicolon is the cluster
        number = text.strip().splitlines()[-1:] or ['']
        found = re.match(r'\d+', number[0])
        if found is None:
            raise SlurmError(f"sbatch says '{text.strip()}', and no job")
        return int(found[0])

    def queue(
        self, jobs: Iterable[int]
    ) -> dict[tuple[int, int], tuple[str, str]]:
        """
        Return the state of each task, such as `PD`, and why it waits.

        The keys are job and index. Slurm forgets tasks some time after their
        end.

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
        Cancel jobs; some may have ended already.

        :raises SlurmError: when Slurm does not answer
        """
        numbers = list(map(str, jobs))
        if not numbers:
            return
        if kill:
            self._run('scancel', '--quiet', '--signal=KILL', '-f', *numbers)
        self._run('scancel', '--quiet', *numbers)

    def ending(self, job: int, index: int) -> Ending | None:
        """Return how a task ended, None if that is unknown."""
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
                timeout=_ANSWER_TIMEOUT,
                check=False,
                # Ctrl-C is for the sweep
                start_new_session=True,
            )
        except subprocess.TimeoutExpired as e:
            raise SlurmError(
                f'{words[0]} has not answered in {_ANSWER_TIMEOUT:g} s'
            ) from e
        except OSError as e:
            raise SlurmError(f'{words[0]}: {e.strerror or e}') from e
        if done.returncode:
            lines = (done.stderr or done.stdout).splitlines()
            said = [_NAME.sub('', line).strip() for line in lines]
            text = '; '.join(filter(None, said))
            raise SlurmError(text or f'exit code {done.returncode}')
        return done.stdout
