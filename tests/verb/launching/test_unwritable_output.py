# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a user learns when the output cannot be written."""

from collections.abc import Callable
from pathlib import Path
import shlex
import subprocess

import pytest
from support.user import User

pytestmark = [
    pytest.mark.full,
    pytest.mark.hostile,
    pytest.mark.skipif(
        not Path('/dev/full').exists(), reason='needs /dev/full'
    ),
]

FILE = 'launch:\n- executable: {name: hello, cmd: echo hello}\n'
ERROR = 'error: the output cannot be written: No space left on device'
Runs = Callable[[str], tuple[int, str]]


@pytest.fixture
def runs(user: User) -> Runs:
    """Run a line of a shell; return the exit code and standard error."""
    user.write('demo.yaml', FILE)
    # what is left at the end is in the buffer
    user.environment.pop('PYTHONUNBUFFERED', None)

    def run(line: str) -> tuple[int, str]:
        done = subprocess.run(
            ['bash', '-c', f'set -o pipefail; {line}'],
            cwd=user.root,
            env=user.environment,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
        return done.returncode, done.stderr

    return run


@pytest.mark.parametrize(
    'line',
    [
        'colcon launch demo.yaml',
        'colcon launch demo.yaml --check',
        'colcon launch --version',
        'colcon launch --help',
    ],
)
def test_one_error_and_the_exit_code_say_so(runs: Runs, line: str) -> None:
    assert runs(f'{line} >/dev/full') == (1, f'colcon launch: {ERROR}\n')


def test_the_exit_code_says_so_alone(runs: Runs) -> None:
    assert runs('colcon launch demo.yaml >/dev/full 2>&1')[0] == 1


def test_a_build_does_not_mind(user: User, runs: Runs) -> None:
    user.package('one')
    code, said = runs('colcon launch one one >/dev/full')
    assert code == 1
    assert 'Traceback' not in said
    assert '1 package built' in said
    assert said.endswith(f'colcon launch: {ERROR}\n')


def test_completion_says_so_in_one_line(runs: Runs) -> None:
    variables = "COMP_LINE='colcon launch ' COMP_POINT=14 _ARGCOMPLETE=1"
    code, said = runs(f'{variables} colcon 8>/dev/full 9>/dev/null')
    assert code == 1
    assert said == f'colcon: {ERROR}\n'


def test_a_reader_that_has_enough_is_no_error(runs: Runs) -> None:
    assert runs('colcon launch demo.yaml | head -1 >/dev/null') == (0, '')


def test_messages_that_cannot_be_shown_change_nothing(runs: Runs) -> None:
    line = 'colcon launch --quiet demo.yaml >/dev/null 2>/dev/full'
    assert runs(line) == (0, '')
    assert runs('colcon launch lost.yaml 2>/dev/full') == (1, '')


def test_an_error_keeps_its_exit_code(runs: Runs) -> None:
    # Python would write what is left at its end, and make the code 120
    script = (
        'import sys\n'
        'from colcon_yamllaunch.common.errors import UserError\n'
        'from colcon_yamllaunch.verb.options_verb import report_errors\n'
        'def fail():\n'
        '    print("something")\n'
        '    raise UserError("no")\n'
        'sys.exit(report_errors("launch", fail))\n'
    )
    line = f'python -c {shlex.quote(script)} >/dev/full'
    assert runs(line) == (1, 'colcon launch: error: no\n')
