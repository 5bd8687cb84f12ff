# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon sweep --on slurm:…`, with a real Slurm of one node."""

from collections.abc import Callable, Iterator
import csv
from pathlib import Path
import signal
import time

import pytest
from support.slurm import Slurm
from support.user import DEADLINE, Launch, User

SIM = """\
launch:
  - arg: {name: seed}
  - executable: {cmd: sh sim.sh $(var seed), name: sim}
"""
SCRIPT = """\
echo "job $SLURM_JOB_ID, domain $ROS_DOMAIN_ID"
echo "reached after $1.5 s"
[ $1 = 3 ] && exit 1
touch begun-$1
until [ -e go-$1 ] || [ -e go-all ]; do sleep 0.1; done
"""


@pytest.fixture
def queuer(user: User, slurm: Slurm) -> Iterator[User]:
    """Return a user with a launch, and with Slurm."""
    user.environment = slurm.environment(user.environment)
    user.write('sim.yaml', SIM)
    user.write('sim.sh', SCRIPT)
    yield user
    user.leave()
    slurm.run('scontrol', 'update', 'nodename=node', 'state=resume')
    slurm.cancel_all()


def sweep(user: User, seeds: str, *words: str) -> Launch:
    return user.start(
        *('colcon', 'sweep', 'sim.yaml', f'seed:={seeds}', '--results', 'r'),
        *('--on', 'slurm:partition=cpu', *words),
    )


def rows(user: User) -> dict[str, dict[str, str]]:
    path = user.root / 'r' / 'results.csv'
    with path.open(encoding='utf-8') as file:
        return {row['seed']: row for row in csv.DictReader(file)}


def wait(is_so: Callable[[], object]) -> None:
    deadline = time.monotonic() + DEADLINE
    while not is_so():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def begun(user: User, *seeds: str) -> None:
    for seed in seeds:
        wait((user.root / f'begun-{seed}').exists)


def test_an_array_job(queuer: User, slurm: Slurm) -> None:
    queuer.write('go-all', '')
    metric = r'time=reached after ([\d.]+) s'
    launch = sweep(queuer, '1..4', '--metric', metric)
    assert launch.end() == 1, launch.output
    assert '4 runs: 3 succeeded, 1 failed' in launch.output
    assert 'failed: run 3, seed:=3: sim-1 exited with code 1' in launch.output
    assert [row['time'] for row in rows(queuer).values()] == [
        *('1.5', '2.5', '3.5', '4.5')
    ]
    (version,) = {row['fingerprint'] for row in rows(queuer).values()}
    assert version
    log = Path(queuer.root / 'r/runs/0002/launch.log').read_text()
    assert 'job ' in log
    assert not slurm.queue()


def test_ctrl_c_cancels_and_keeps(queuer: User, slurm: Slurm) -> None:
    queuer.write('go-1', '')
    launch = sweep(queuer, '1,5,6')
    begun(queuer, '1', '5', '6')
    wait(lambda: '"run": 1' in journal(queuer))
    assert launch.interrupt() == 128 + signal.SIGINT
    assert '3 runs: 1 succeeded, 2 not run yet' in launch.output
    slurm.wait_until_empty()
    queuer.write('go-all', '')
    launch = sweep(queuer, '1,5,6')
    assert launch.end() == 0, launch.output
    assert '1 of 3 runs are done; going on' in launch.output


def journal(user: User) -> str:
    path: Path = user.root / 'r' / 'journal.jsonl'
    return path.read_text() if path.exists() else ''


def test_a_sweep_that_is_killed_is_gone_on_with(queuer: User) -> None:
    launch = sweep(queuer, '1,5')
    begun(queuer, '1', '5')
    launch.process.kill()
    launch.end()
    launch = sweep(queuer, '1,5')
    launch.wait_for('2 runs are with Slurm already')
    queuer.write('go-all', '')
    assert launch.end() == 0, launch.output
    assert len(rows(queuer)) == 2


def test_a_node_that_fails(queuer: User, slurm: Slurm) -> None:
    launch = sweep(queuer, '5')
    begun(queuer, '5')
    slurm.run(
        *('scontrol', 'update', 'nodename=node', 'state=down', 'reason=x')
    )
    assert launch.end() == 1
    assert 'its node failed: node (Slurm: NODE_FAIL)' in launch.output
    assert rows(queuer)['5']['outcome'] == 'error'


def test_what_slurm_refuses(queuer: User) -> None:
    launch = sweep(queuer, '1', '--on', 'slurm:partition=none')
    assert launch.end() == 1
    assert 'Slurm does not take the runs: ' in launch.output
    assert 'nvalid partition' in launch.output


def test_a_run_that_cannot_be_planned(queuer: User) -> None:
    queuer.write(
        'sim.yaml', SIM + '  - include: {file: $(dirname)/$(var seed).yaml}\n'
    )
    queuer.write('1.yaml', 'launch:\n  - executable: {cmd: echo one}\n')
    queuer.write('go-all', '')
    launch = sweep(queuer, '1,2')
    assert launch.end() == 1
    assert '2 runs: 1 succeeded, 1 had an error' in launch.output
    assert '2.yaml' in rows(queuer)['2']['reason']


def test_a_terminal_that_closes_leaves_it_to_slurm(queuer: User) -> None:
    launch = sweep(queuer, '1,5')
    begun(queuer, '1', '5')
    launch.process.send_signal(signal.SIGHUP)
    assert launch.end() == 128 + signal.SIGHUP
    launch = sweep(queuer, '1,5')
    launch.wait_for('2 runs are with Slurm already')
    queuer.write('go-all', '')
    assert launch.end() == 0, launch.output
