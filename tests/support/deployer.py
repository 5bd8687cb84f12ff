# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Somebody who launches over several machines."""

from collections.abc import Mapping, Sequence
import json
import os
from pathlib import Path
import shlex
import signal
import sys
from typing import Any
import uuid

from colcon_yamllaunch.control.client import running_launches
from support.marked_processes import command_of, kill, marked, wait_until_none
from support.sshd import Sshd
from support.terminal import Terminal
from support.user import Launch, User

#: The variable by which what runs here is found.
MARK = 'COLCON_LAUNCH_TEST_DEPLOYER'
#: Seconds; a loaded machine needs some.
DEADLINE = 60
#: Where a process runs if it is not placed.
HERE = ''
#: A program that says who it is, and then what it is told.
TALKER = """\
import os, signal, sys
ignores = 'ignores' in sys.argv
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, signal.SIG_IGN if ignores else signal.SIG_DFL)
print('up', sys.argv[1:], os.getpid(), flush=True)
if 'reads' in sys.argv:
    for line in sys.stdin:
        print('heard', line.rstrip(), flush=True)
        if line.startswith('exit '):
            sys.exit(int(line.split()[1]))
while True:
    signal.pause()
"""

Words = Sequence[str]


class Deployer(User):
    """
    A user with machines, and a launch file without a workspace.

    :ivar talker: The command of a process that runs until it is ended
    """

    def __init__(self, home: Path, sshd: Sshd | None = None) -> None:
        super().__init__(home)
        if sshd is not None:
            self.environment = sshd.environment(self.environment)
        self.environment['TMPDIR'] = str(home)
        self.environment[MARK] = self._mark = uuid.uuid4().hex
        script = self.write('talker.py', TALKER)
        self.talker = (sys.executable, str(script))
        self._terminals: list[Terminal] = []

    def places(
        self,
        processes: Mapping[str, tuple[str, Words]],
        machines: Mapping[str, Mapping[str, Any]] | None = None,
        timeouts: float = 1,
        rules: Sequence[Mapping[str, Any]] = (),
        **settings: Any,
    ) -> None:
        """
        Write a launch file, and where its processes run.

        :param processes: The machine and the command line of each
        :param machines: How each is reached; by ssh under its name if it is
            not told
        :param timeouts: Seconds after which each signal is followed by the
            next one
        :param rules: What else holds for processes
        :param settings: What holds for all machines
        """
        known = {
            name: {'ssh': name, **settings}
            for name, _ in processes.values()
            if name != HERE
        }
        for name, machine in (machines or {}).items():
            known[name] = {**settings, **machine}
        actions = [
            {
                'executable': {
                    'cmd': shlex.join(words),
                    'name': name,
                    'sigterm_timeout': str(timeouts),
                    'sigkill_timeout': str(timeouts),
                }
            }
            for name, (_, words) in processes.items()
        ]
        placing = [
            {'match': name, 'machine': machine}
            for name, (machine, _) in processes.items()
            if machine != HERE
        ]
        # JSON is YAML, too
        self.write('plain.yaml', json.dumps({'launch': actions}))
        deployment = {'machines': known, 'processes': [*placing, *rules]}
        self.write('robot.yaml', json.dumps(deployment))

    def deploys(self, *options: str) -> Launch:
        """Start the launch, and return at once."""
        words = ('--deploy', 'robot.yaml', *options, 'plain.yaml')
        return self.start('colcon', 'launch', *words)

    def in_terminal(self, *words: str) -> Terminal:
        """Run `colcon launch` in a terminal."""
        size = {'TERM': 'xterm', 'COLUMNS': '100', 'LINES': '24'}
        # in a job there is no status block
        environment = self.environment | size | {'CI': ''}
        argv = ['colcon', 'launch', *words]
        self._terminals.append(Terminal(argv, self.root, environment))
        return self._terminals[-1]

    def processes(self) -> dict[int, str]:
        """Return what the user started here, with the command lines."""
        return {pid: command_of(pid) for pid in marked(MARK, self._mark)}

    def wait_until_empty(self) -> None:
        """Wait until nothing runs here that the user started."""
        wait_until_none(self.processes)

    @property
    def log_folder(self) -> Path:
        """The log folder of the last launch."""
        logs = self.root.parent / '.ros/log'
        return max(logs.glob('launch_*'), key=lambda p: p.stat().st_mtime_ns)

    def logged(self, name: str) -> str:
        """Return what the log of a process has, on whatever machine."""
        (file,) = (
            file
            for file in self.log_folder.rglob('stdout.log')
            if name in file.parent.name
        )
        return file.read_text(encoding='utf-8')

    def leave(self) -> None:
        """End whatever is still running."""
        for terminal in self._terminals:
            terminal.close()
        for launch in running_launches(self.environment, print):
            os.kill(launch.pid, signal.SIGKILL)
            launch.close()
        super().leave()
        kill(marked(MARK, self._mark))
