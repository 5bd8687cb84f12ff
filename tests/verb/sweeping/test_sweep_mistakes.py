# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""One clear error for each mistake, before anything is built or run."""

import re

from colcon_yamllaunch.common.errors import UserError
import pytest
from support.command_lines import sweep_options as parsed
from support.user import User

SIM = """\
launch:
  - arg: {name: seed, default: '1'}
  - arg: {name: speed, default: '1'}
  - executable: {cmd: touch ran}
"""


def test_options_anywhere() -> None:
    options = parsed(
        *('--jobs', '8', 'my_pkg', 'sim.yaml', 'seed:=1..9', '--again'),
        *('failed', '--metric', r'far=drove ([\d.]+) m', 'world:=lab'),
        *('--metric', 'last=-(x)', '--require', '95%', '--for', '3'),
        *('--launch-prefix', 'nice'),
    )
    assert options.positionals == ('my_pkg', 'sim.yaml')
    assert options.arguments == {'seed': '1..9', 'world': 'lab'}
    assert options.fixed == {'launch-prefix': 'nice'}
    assert (options.jobs, options.again, options.for_) == (8, 'failed', 3.0)
    assert options.require == 0.95
    assert [m.name for m in options.metric] == ['far', 'last']


@pytest.mark.parametrize(
    ('words', 'error'),
    [
        ('', 'there is nothing to launch: usage: colcon sweep'),
        ('a.yaml --jobs 0', "--jobs needs a number from 1 on, not '0'"),
        ('a.yaml --repeat x', "--repeat needs a number from 1 on, not 'x'"),
        ('a.yaml --require 95', 'such as 95%'),
        ('a.yaml --require 101%', 'such as 95%'),
        ('a.yaml --again most', "invalid choice: 'most'"),
        ('a.yaml --metric x=y', "'y' has no group"),
        ('a.yaml --metric x=(y) --metric x=(z)', "that are called 'x'"),
        ('a.yaml seed:=1 seed:=2', 'one list: seed:=1,2'),
        ('a.yaml :=2', 'has no name'),
        ('a.yaml --seed 1..3', "did you mean 'seed:=1..3'"),
        ('a.yaml --watch', "'colcon sweep' has no option '--watch'"),
        ('a.yaml --on robot@arm', 'is written slurm:OPTION=VALUE'),
        ('a.yaml --on slurm:array=3', "'array' is for the sweep to say"),
        ('a.yaml --on slurm:Time=3', 'is no option of sbatch'),
        ('a.yaml --for 3 --timeout 3', '--for and --timeout exclude'),
    ],
)
def test_command_lines(words: str, error: str) -> None:
    with pytest.raises(UserError) as caught:
        parsed(*words.split())
    assert error in str(caught.value)


@pytest.mark.parametrize(
    ('words', 'error'),
    [
        ('b.yaml', "there is no launch file 'b.yaml'"),
        ('sim.yaml seed:=1..x', "the range '1..x' is not made of numbers"),
        (
            'sim.yaml sead:=1..3',
            "no launch file declares the launch argument 'sead'\n"
            "  help: did you mean 'seed'?",
        ),
        ('sim.yaml --table no.csv', "'no.csv' cannot be read"),
        ('sim.yaml --table bad.csv', 'bad.csv:2: error: there are 1 value'),
        ('sim.yaml seed:=1 --metric seed=(x)', "a column 'seed' already"),
        ('sim.yaml --results other', 'has other files than the results'),
        ('sim.yaml --results sim.yaml/x', 'cannot be written: Not a dir'),
        ('sim.yaml --on slurm:partition=cpu', "needs the command 'sbatch'"),
    ],
)
def test_wrong_sweeps_are_refused(user: User, words: str, error: str) -> None:
    user.write('sim.yaml', SIM)
    user.write('bad.csv', 'seed,speed\n1\n')
    user.write('other/thesis.tex', '')
    if 'slurm' in words:
        # where no Slurm is, but all else that this needs
        user.write('bin/x', '')
        python = user.environment['PATH'].split(':')[0]
        user.environment['PATH'] = f'{python}:{user.root}/bin'
    launch = user.start('colcon', 'sweep', *words.split())
    assert launch.end() == 1
    assert re.match(r'(colcon sweep|bad\.csv:2): error: ', launch.output)
    assert error in launch.output
    assert launch.output.count('error') == 1
    assert not (user.root / 'ran').exists()


def test_a_value_that_is_no_choice(user: User) -> None:
    user.write(
        'sim.yaml', SIM.replace('seed, ', 'seed, choice: [{value: 1}], ')
    )
    launch = user.start('colcon', 'sweep', 'sim.yaml', 'seed:=2')
    assert launch.end() == 1
    assert launch.output.startswith(
        "colcon sweep: error: launch argument 'seed' cannot be '2', as "
    )


def test_the_results_of_another_sweep(user: User) -> None:
    user.write('sim.yaml', SIM)
    words = ['colcon', 'sweep', 'sim.yaml', '--results', 'r']
    assert user.start(*words, 'seed:=1..2').end() == 0
    other = user.start(*words, 'seed:=1..3')
    assert other.end() == 1
    assert 'has the results of another sweep: colcon sweep' in other.output
