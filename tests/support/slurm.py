# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A real Slurm on this machine: one node, partitions `cpu` and `gpu`.

Its three servers, of Debian's packages, run as whoever runs the tests, with
a key, ports and files of their own. What `srun` and others need to find them
is one variable, SLURM_CONF.
"""

from collections.abc import Callable
import contextlib
import os
from pathlib import Path
import pwd
import re
import socket
import subprocess
import sys
import time

import pytest
from support.marked_processes import (
    command_of,
    DEADLINE,
    descendants,
    kill,
    marked,
    wait_until_none,
)
from support.system_servers import (
    program,
    reserved_port,
    run_quietly,
    start_server,
)

#: The processors that the node has, for Slurm.
PROCESSORS = 16
#: The variable that names the configuration, by which jobs are found, too.
CONFIGURATION = 'SLURM_CONF'

_NEEDED = {
    'munged': 'munge',
    'slurmctld': 'slurmctld',
    'slurmd': 'slurmd',
    'srun': 'slurm-client',
}
#: See slurm.conf(5). No control groups, which containers seldom allow; the
#: hardware is what we say; and a node that was away is taken again.
_SLURM = """\
ClusterName=tests
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller_port}
SlurmdPort={node_port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/controller.pid
SlurmdPidFile={folder}/node.pid
SlurmctldLogFile={folder}/controller.log
SlurmdLogFile={folder}/node.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
TaskProlog={folder}/prolog
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=5
MaxArraySize=10001
MaxJobCount=20000
GresTypes=gpu
NodeName=node NodeHostname={host} NodeAddr=127.0.0.1 CPUs={processors} \
RealMemory=500 Gres=gpu:2 State=UNKNOWN
PartitionName=cpu Nodes=node Default=YES MaxTime=INFINITE State=UP
PartitionName=gpu Nodes=node MaxTime=INFINITE State=UP
"""
#: What passes for graphics processors.
_GRES = 'Name=gpu File=/dev/null\nName=gpu File=/dev/zero\n'


def why_not() -> str:
    """Return why there can be no Slurm here, or nothing."""
    for name, package in _NEEDED.items():
        if program(name) is None:
            return f'{name} is not installed (Debian: {package})'
    return ''


def skip_without_slurm() -> None:
    """Skip the test where there can be no Slurm."""
    reason = why_not()
    if reason:
        pytest.skip(reason)


def _version() -> tuple[int, ...]:
    """Return the version of Slurm, such as (22, 5)."""
    server = program('slurmd')
    assert server is not None
    argv = [server, '-V']
    text = subprocess.run(argv, capture_output=True, text=True).stdout
    return tuple(map(int, re.findall(r'\d+', text)[:2]))


class Slurm:
    """
    The three servers, and what their users need.

    :ivar folder: All their files
    :ivar home: The home folder on the node
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.home = folder / 'home'
        self._configuration = folder / 'slurm.conf'
        self._servers: list[subprocess.Popen[bytes]] = []
        self._open = contextlib.ExitStack()

    def __enter__(self) -> 'Slurm':
        with contextlib.ExitStack() as stack:
            stack.callback(self._close)
            self._write()
            self._start()
            stack.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._close()

    def environment(self, environment: dict[str, str]) -> dict[str, str]:
        """Return an environment in which Slurm's commands find the node."""
        # the tests themselves may run as a job
        kept = {
            name: value
            for name, value in environment.items()
            if not name.startswith(('SLURM_', 'SRUN_', 'SBATCH_', 'SALLOC_'))
        }
        return kept | {CONFIGURATION: str(self._configuration)}

    def run(self, *words: str) -> 'subprocess.CompletedProcess[str]':
        """Run one of Slurm's commands."""
        environment = self.environment(dict(os.environ))
        return run_quietly(words, environment, self.folder)

    def queue(self) -> list[str]:
        """Return the ids of the jobs that wait, run or end."""
        done = self.run('squeue', '--noheader', '--format=%i')
        assert done.returncode == 0, done.stderr
        return done.stdout.split()

    def left(self) -> list[str]:
        """Return the command lines of all that jobs left on the node."""
        return [command_of(pid) for pid in self._jobs()]

    def wait_until_empty(self, seconds: float = DEADLINE) -> float:
        """Wait until there is no job, and return how long it took."""
        return wait_until_none(lambda: self.queue() + self.left(), seconds)

    def cancel_all(self) -> None:
        """End all jobs, and wait for that."""
        for job in self.queue():
            self.run('scancel', '--signal=KILL', '--full', job)
            self.run('scancel', job)
        kill(self._jobs())
        self.wait_until_empty()

    @property
    def log(self) -> str:
        """What the servers wrote."""
        files = [*self.folder.glob('*.log'), *self.folder.glob('*.out')]
        return '\n'.join(
            f'{file.name}:\n{file.read_text(errors="replace")}'
            for file in files
        )

    def _jobs(self) -> list[int]:
        """Return the processes of jobs: they are below no server of ours."""
        own = {server.pid for server in self._servers}
        own |= {os.getpid()}
        found = marked(CONFIGURATION, str(self._configuration))
        return [pid for pid in found if pid not in own]

    def _write(self) -> None:
        for name in ('state', 'spool', self.home.name):
            (self.folder / name).mkdir()
        key = self.folder / 'munge.key'
        key.touch(mode=0o600)
        key.write_bytes(os.urandom(128))
        ports = [self._open.enter_context(reserved_port()) for _ in 'cn']
        text = _SLURM.format(
            folder=self.folder,
            host=socket.gethostname().partition('.')[0],
            user=pwd.getpwuid(os.getuid()).pw_name,
            controller_port=ports[0].getsockname()[1],
            node_port=ports[1].getsockname()[1],
            processors=PROCESSORS,
        )
        self._configuration.write_text(text, encoding='utf-8')
        (self.folder / 'gres.conf').write_text(_GRES, encoding='utf-8')
        # what it prints are variables of each task. The home folder is the
        # only one: what else a task lacks, it lacks on any cluster
        prolog = self.folder / 'prolog'
        prolog.write_text(
            f'#!/bin/sh\necho "export HOME={self.home}"\n', encoding='utf-8'
        )
        prolog.chmod(0o755)
        # a login there finds colcon
        path = Path(sys.executable).parent
        (self.home / '.profile').write_text(
            f'echo welcome\nPATH={path}:$PATH\n', encoding='utf-8'
        )
        # older ones do without because of `proctrack/pgid`
        text = 'CgroupPlugin=disabled\n' if _version() >= (23, 11) else ''
        (self.folder / 'cgroup.conf').write_text(text, encoding='utf-8')

    def _start(self) -> None:
        def one(*words: str, variables: dict[str, str] | None = None) -> None:
            server = program(words[0])
            assert server is not None
            output = self.folder / f'{words[0]}.out'
            argv = [server, *words[1:]]
            environment = dict(os.environ) if variables is None else variables
            self._servers.append(start_server(argv, environment, output))

        def file(name: str) -> str:
            return str(self.folder / name)

        one(
            'munged',
            '--foreground',
            # the folder of the tests is nobody else's
            '--force',
            f'--socket={file("munge.socket")}',
            f'--key-file={file("munge.key")}',
            f'--pid-file={file("munge.pid")}',
            f'--seed-file={file("munge.seed")}',
            f'--log-file={file("munge.log")}',
        )
        self._wait(lambda: (self.folder / 'munge.socket').exists())
        # by an option, so that the variable tells jobs from servers
        configuration = str(self._configuration)
        plain = {
            name: value
            for name, value in os.environ.items()
            if not name.startswith('SLURM')
        }
        one('slurmctld', '-D', '-c', '-f', configuration, variables=plain)
        self._wait(lambda: self.run('scontrol', 'ping').returncode == 0)
        node = ('-D', '-c', '-N', 'node', '-f', configuration)
        one('slurmd', *node, variables=plain)
        self._wait(
            lambda: (
                self.run('sinfo', '-h', '-o', '%t').stdout.strip() == 'idle'
            )
        )

    def _wait(self, is_done: Callable[[], bool]) -> None:
        deadline = time.monotonic() + DEADLINE
        while not is_done():
            for server in self._servers:
                assert server.poll() is None, self.log
            assert time.monotonic() < deadline, self.log
            time.sleep(0.05)

    def _close(self) -> None:
        doomed = self._jobs()
        for server in self._servers:
            doomed += [server.pid, *descendants(server.pid)]
        while doomed:
            kill(doomed)
            for server in self._servers:
                server.wait()
            doomed = self._jobs()
        self._open.close()
