# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a deployment file says about a machine holds there."""

from pathlib import Path
import sys

import pytest
from support.deployer import Deployer
from support.linked_part import PlainMachine
from support.sshd import Sshd

#: A Python whose clock is wrong, for a program that follows `-c`.
AHEAD = """\
import sys, time
clock = time.time
time.time = lambda: clock() + {seconds}
sys.argv = sys.argv[sys.argv.index("-c", 1) :]
exec(sys.argv.pop(1))
"""


def _python_ahead(folder: Path, seconds: float) -> str:
    """Return the path of a Python whose clock is ahead."""
    program = folder / 'python'
    code = AHEAD.format(seconds=seconds)
    text = f'#!/bin/sh\nexec {sys.executable} -c \'{code}\' "$@"\n'
    program.write_text(text)
    program.chmod(0o755)
    return str(program)


def test_variables_and_setup_are_there(deployer: Deployer, sshd: Sshd) -> None:
    setup = sshd['arm'].home / 'mine.bash'
    setup.write_text('export FOUND="$HOME/found" A=3\necho noise\n')
    script = 'echo found=$FOUND a=$A b=$B c=$C'
    deployer.environment['C'] = 'here'
    deployer.places(
        {'one': ('arm', ('sh', '-c', script))},
        sync='none',
        setup='mine.bash',
        env={'A': 1, 'B': 'x y', 'C': None},
    )
    launch = deployer.deploys()
    assert launch.end() == 0, launch.output
    home = sshd['arm'].home
    assert f'found={home}/found a=1 b=x y c=here' in launch.output
    assert 'noise' not in launch.output


def test_missing_setup_is_told(deployer: Deployer, sshd: Sshd) -> None:
    deployer.places(
        {'one': ('arm', ('true',))}, sync='none', setup='~/none.bash'
    )
    launch = deployer.deploys()
    assert launch.end() == 1
    path = sshd['arm'].home / 'none.bash'
    assert f"arm: there is no file {path}; 'setup:' names" in launch.output


@pytest.mark.parametrize('seconds', [0.04, -3600])
def test_clock_that_differs_is_told(
    deployer: Deployer, seconds: float
) -> None:
    plain = PlainMachine(deployer.root)
    python = _python_ahead(plain.home, seconds)
    machine = {'connect': list(plain.words), 'python': python}
    deployer.places({'one': ('arm', ('true',))}, {'arm': machine}, sync='none')
    launch = deployer.deploys()
    assert launch.end() == 0, launch.output
    text = 'warning: its clock is 3600.0 s behind that of this computer'
    assert (text in launch.output) == (seconds == -3600), launch.output
    assert ('clock' in launch.output) == (seconds == -3600), launch.output
    plain.wait_until_empty()
