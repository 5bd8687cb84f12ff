# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A built copy of sample_ws, and programs started from it by hand."""

from collections.abc import Callable
from collections.abc import Iterator
import contextlib
from dataclasses import dataclass
import importlib.util
import os
from pathlib import Path
import queue
import re
import shutil
import signal
import subprocess
import sys
import threading

import pytest

SAMPLE_WS = Path(__file__).parents[2] / 'sample_ws'
#: Seconds for a build of the workspace; some six are usual.
BUILD_TIMEOUT = 300
#: Seconds for a program to print a line or to end; one or two are usual.
PROGRAM_TIMEOUT = 60
#: What the shell that runs the tests may have sourced.
SOURCED = (
    'AMENT_PREFIX_PATH',
    'CMAKE_PREFIX_PATH',
    'COLCON_PREFIX_PATH',
    'PYTHONPATH',
)

Environment = dict[str, str]


def copy_sample_ws(destination: Path) -> Path:
    """Copy the workspace's sources, without what somebody built there."""
    products = [SAMPLE_WS / name for name in ('build', 'install', 'log')]

    def ignored(folder: str, names: list[str]) -> list[str]:
        return [
            name
            for name in names
            if name == '__pycache__' or Path(folder, name) in products
        ]

    shutil.copytree(SAMPLE_WS, destination, ignore=ignored)
    return destination


def clean_environment() -> Environment:
    """Return this process's environment with nothing sourced in it."""
    environment = {
        name: value
        for name, value in os.environ.items()
        if name not in SOURCED
    }
    programs = str(Path(sys.executable).parent)
    environment['PATH'] = os.pathsep.join([programs, environment['PATH']])
    return environment


@dataclass(frozen=True)
class Workspace:
    """A built workspace and the environment that its setup.bash makes."""

    root: Path
    environment: Environment


def _build(root: Path, environment: Environment) -> None:
    done = subprocess.run(
        ['colcon', 'build', '--symlink-install'],
        cwd=root,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=BUILD_TIMEOUT,
        check=False,
    )
    assert done.returncode == 0, done.stdout


def _source(root: Path, environment: Environment) -> Environment:
    script = 'source "$1" && exec env -0'
    done = subprocess.run(
        ['bash', '-c', script, 'bash', str(root / 'install/setup.bash')],
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
        timeout=PROGRAM_TIMEOUT,
        check=True,
    )
    pairs = (line.partition('=') for line in done.stdout.split('\0') if line)
    return {name: value for name, _, value in pairs}


@pytest.fixture(scope='session')
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """Build a copy of sample_ws with plain colcon, and source it."""
    if importlib.util.find_spec('rclpy') is None:
        pytest.skip('rclpy is not installed (the extra "ros")')
    root = copy_sample_ws(tmp_path_factory.mktemp('sample') / 'ws')
    environment = clean_environment()
    _build(root, environment)
    return Workspace(root, _source(root, environment))


class Program:
    """A running program whose output can be waited for."""

    def __init__(self, argv: list[str], environment: Environment) -> None:
        self._process = subprocess.Popen(
            argv,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        self.lines: list[str] = []
        self._arriving: queue.Queue[str | None] = queue.Queue()
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as stdout:
            for line in stdout:
                self._arriving.put(line.rstrip('\n'))
        self._arriving.put(None)

    def wait_for(self, wanted: str) -> None:
        """Wait until the program prints exactly this line."""
        self.wait_for_match(re.escape(wanted))

    def wait_for_match(self, pattern: str) -> None:
        """Wait until it prints a line that is what a pattern says."""
        while not any(re.fullmatch(pattern, line) for line in self.lines):
            try:
                line = self._arriving.get(timeout=PROGRAM_TIMEOUT)
            except queue.Empty:
                line = None
            assert line is not None, f'no {pattern!r} in {self.lines}'
            self.lines.append(line)

    def end(self) -> int:
        """Wait until the program ends, keep its output, return its code."""
        code = self._process.wait(timeout=PROGRAM_TIMEOUT)
        self._reader.join(timeout=PROGRAM_TIMEOUT)
        while (line := self._arriving.get_nowait()) is not None:
            self.lines.append(line)
        return code

    def stop(self, with_signal: signal.Signals) -> int:
        """Send a signal and wait for the end."""
        self._process.send_signal(with_signal)
        return self.end()

    def kill(self) -> None:
        """Leave nothing behind, whatever the test did."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        self._reader.join()


Start = Callable[..., Program]


@pytest.fixture
def start() -> Iterator[Start]:
    """Start programs that are gone when the test is over."""
    programs: list[Program] = []

    def start_program(environment: Environment, *argv: str | Path) -> Program:
        program = Program([str(part) for part in argv], environment)
        programs.append(program)
        return program

    yield start_program
    for program in programs:
        program.kill()


@pytest.fixture
def ros_environment(workspace: Workspace, ros_domain_id: int) -> Environment:
    """Return the workspace's environment, in a ROS domain of its own."""
    return workspace.environment | {
        'PYTHONUNBUFFERED': '1',
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'ROS_DOMAIN_ID': str(ros_domain_id),
    }
