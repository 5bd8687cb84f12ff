# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Links through ssh, Slurm and namespaces, and what can happen to these."""

from collections.abc import Iterator, Mapping
import os
import subprocess
import time

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.deployment.deployment import Machine
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
)
import pytest
from support.linked_part import DEADLINE, LinkedPart, process
from support.namespaces import NamespaceMachine
from support.slurm import PROCESSORS, Slurm
from support.sshd import Sshd
from support.time_limits import within

WAITS = 'echo begun; sleep 1000'


def ssh_part(
    sshd: Sshd, script: str, on_lost: str = 'stop', **more: object
) -> LinkedPart:
    """Return a part on a machine of `sshd`."""
    machine = Machine('arm', 'ssh', ('arm',), on_lost=on_lost)  # type: ignore[arg-type]
    environment = sshd.environment(dict(os.environ))
    return LinkedPart(machine, [process('arm│a', script)], environment, **more)


def test_silent_connection_stops_the_part(sshd: Sshd) -> None:
    with ssh_part(sshd, WAITS) as part:
        part.wait_for(part.out)
        sshd['arm'].link.hold()
        begin = time.monotonic()
        with within(5.5):
            part.wait_for_told('lost')
        assert part.reason == 'nothing was heard of it for 4.5 s'
        deadline = begin + DEADLINE
        while any('sleep' in command for command in sshd.left()):
            assert time.monotonic() < deadline
            part.turn()
        # not by the end of the connection, which it has not heard of
        assert time.monotonic() - begin > 9
        sshd['arm'].link.release()
        part.wait_for_told('gone')
        assert part.gone_for == 'it has ended there'
    sshd.wait_until_empty()


@pytest.fixture
def jobs(slurm: Slurm) -> Iterator[Slurm]:
    """Return a Slurm without jobs, before and after."""
    yield slurm
    slurm.cancel_all()


def slurm_machine(*words: str) -> Machine:
    """Return a machine that Slurm gives."""
    return Machine('gpu', 'slurm', words)


def slurm_environment(slurm: Slurm) -> dict[str, str]:
    """Return the variables of a user of Slurm."""
    return slurm.environment(dict(os.environ))


def test_slurm_gives_a_step_of_an_allocation(jobs: Slurm) -> None:
    environment = slurm_environment(jobs)
    with Allocation(environment) as job:
        inner = environment | {'SLURM_JOB_ID': job}
        machine = slurm_machine()
        # two at once, though there is one node
        with (
            LinkedPart(machine, [process('gpu│a', WAITS)], inner) as one,
            LinkedPart(machine, [process('gpu│a', WAITS)], inner) as another,
        ):
            for part in (one, another):
                part.wait_for(lambda part=part: part.out('gpu│a'))
            # another step finds what the first one left, if Slurm has left it
            one.cut()
            one.wait_for(lambda: {'back', 'gone'} & set(one.told))
            if one.gone_for is None:
                one.finish()
            another.finish()
    jobs.wait_until_empty()


class Allocation:
    """An allocation of Slurm, for as long as it is needed."""

    def __init__(self, environment: Mapping[str, str]) -> None:
        self._environment = environment

    def __enter__(self) -> str:
        self._process = subprocess.Popen(
            ['salloc', '--quiet', 'sh', '-c', 'echo $SLURM_JOB_ID; read x'],
            env=dict(self._environment),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._process.stdout is not None
        return self._process.stdout.readline().strip()

    def __exit__(self, *_: object) -> None:
        self._process.communicate('\n')


def test_an_allocation_of_its_own_ends_with_its_command(jobs: Slurm) -> None:
    with LinkedPart(
        slurm_machine(), [process('gpu│a', WAITS)], slurm_environment(jobs)
    ) as part:
        part.wait_for(lambda: part.out('gpu│a'))
        part.cut()
        part.wait_for_told('gone')
        assert part.gone_for is not None
        assert part.gone_for.endswith('; its allocation has ended')
    jobs.wait_until_empty()


@pytest.mark.parametrize(
    ('words', 'reason'),
    [
        (('--partition=none',), 'there is no such partition'),
        (('--gres=gpu:9',), 'Slurm does not give what is asked for'),
        (('--no-such',), 'srun does not know an option'),
    ],
)
def test_error_of_srun_is_explained(
    jobs: Slurm, words: tuple[str, ...], reason: str
) -> None:
    contact = MachineConnection(
        slurm_machine(*words), (), slurm_environment(jobs)
    )
    with pytest.raises(UserError) as caught:
        contact.connect()
    assert str(caught.value).startswith(f'gpu (srun {words[0]}): {reason}: ')


def test_message_of_a_waiting_srun_is_shown(jobs: Slurm) -> None:
    environment = slurm_environment(jobs)
    said: list[str] = []

    def say(line: str) -> None:
        said.append(line)
        # somebody has no patience
        if 'queued' in line:
            raise KeyboardInterrupt

    words = f'--cpus-per-task={PROCESSORS}', '--wrap', 'sleep 1000'
    done = jobs.run('sbatch', *words)
    assert done.returncode == 0, done.stderr
    while 'sleep 1000' not in jobs.left():
        assert jobs.queue()
        time.sleep(0.05)
    contact = MachineConnection(slurm_machine(), (), environment, say=say)
    with pytest.raises(KeyboardInterrupt):
        contact.connect()
    assert 'queued and waiting for resources' in said[-1]


@pytest.fixture
def namespace_part(
    namespace: NamespaceMachine,
) -> Iterator[LinkedPart]:
    """Return a part on a machine of namespaces."""
    machine = Machine('edge', 'connect', (str(namespace.enter),))
    part = LinkedPart(machine, [process('edge│a', WAITS)])
    with part:
        part.wait_for(lambda: part.out('edge│a'))
        yield part


def test_rebooted_machine_is_gone(
    namespace_part: LinkedPart, namespace: NamespaceMachine
) -> None:
    namespace.reboot()
    namespace_part.wait_for_told('gone')
    assert namespace_part.gone_for == 'the machine was started anew meanwhile'
    assert namespace_part.told.count('lost') == 1
