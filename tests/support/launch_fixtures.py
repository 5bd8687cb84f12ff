# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Fixtures that run a plan in a launcher process of its own."""

from collections.abc import Callable, Iterator
import json
import os
from pathlib import Path
import subprocess
import sys
from typing import Any

import colcon_yamllaunch
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.position import Position
import pytest
from support.marked_processes import kill, marked
from support.waiting import is_running, wait_until

#: Seconds after which something will not happen any more.
DEADLINE = 60.0
LAUNCHER = Path(__file__).with_name('launcher.py')
ROOT = Path(colcon_yamllaunch.__file__).parents[1]


class Launch:
    """A launcher in a process of its own, and what it showed."""

    def __init__(
        self, folder: Path, entries: list[dict[str, Any]], **settings: Any
    ) -> None:
        self.folder = folder
        folder.mkdir()
        self.log_folder = folder / 'log'
        environment = {
            'PATH': os.environ['PATH'],
            'PYTHONPATH': str(ROOT),
            'TMPDIR': str(folder),
            # found in all processes of the launch, to see that none is left
            'TEST_LAUNCH': str(folder),
            **settings.pop('environment', {}),
        }
        popen = {
            'stdin': subprocess.DEVNULL,
            'stderr': subprocess.STDOUT,
            'start_new_session': True,
            'cwd': folder,
            **settings.pop('popen', {}),
        }
        shell = settings.pop('shell', ())
        plan = {'entries': entries, 'log_folder': str(self.log_folder)}
        (folder / 'plan.json').write_text(json.dumps({**plan, **settings}))
        # -S, as it needs nothing but the product
        command = [*shell, sys.executable, '-S', str(LAUNCHER)]
        command.append(str(folder / 'plan.json'))
        with (folder / 'screen').open('wb') as screen:
            popen.setdefault('stdout', screen)
            self.popen = subprocess.Popen(command, env=environment, **popen)

    @property
    def screen(self) -> str:
        return (self.folder / 'screen').read_bytes().decode()

    def shows(self, text: str) -> 'Launch':
        """Wait until a text is on the screen."""

        def seen() -> bool:
            assert self.popen.poll() is None or text in self.screen, (
                f'{text!r} is not in:\n{self.screen}'
            )
            return text in self.screen

        wait_until(seen)
        return self

    def sends(self, number: int) -> 'Launch':
        self.popen.send_signal(number)
        return self

    def ends(self) -> int:
        """Wait for the end, and return the exit code."""
        code = self.popen.wait(DEADLINE)
        assert f'File "{ROOT}' not in self.screen, 'the launcher crashed'
        return code

    def log(self, name: str) -> bytes:
        return (self.log_folder / name).read_bytes()

    def events(self, kind: str) -> list[dict[str, Any]]:
        lines = self.log('events.jsonl').decode().splitlines()
        records = [json.loads(line) for line in lines]
        return [r for r in records if r['event'] == kind]

    def processes(self) -> list[int]:
        """Return the processes of the launch, launcher and guard excluded."""
        found = marked('TEST_LAUNCH', str(self.folder))
        return [pid for pid in found if pid != self.popen.pid]

    def guards(self) -> list[int]:
        """Return the guard of the launch, if there is one."""
        found = []
        for entry in Path('/proc').iterdir():
            try:
                stat = (entry / 'stat').read_text().rpartition(') ')[2]
                environment = (entry / 'environ').read_bytes()
            except (OSError, UnicodeDecodeError):
                continue
            child = int(stat.split()[1]) == self.popen.pid
            if child and b'engine.guard' in environment:
                found.append(int(entry.name))
        return found

    def clean_up(self) -> None:
        self.popen.kill()
        self.popen.wait()
        kill(self.processes())


@pytest.fixture
def launch(tmp_path: Path) -> Iterator[Callable[..., Launch]]:
    """Return a function that starts a launcher; see :class:`Launch`."""
    launches: list[Launch] = []

    def start(*entries: dict[str, Any], **settings: Any) -> Launch:
        folder = tmp_path / f'launch{len(launches)}'
        launches.append(Launch(folder, list(entries), **settings))
        return launches[-1]

    yield start
    for one in launches:
        one.clean_up()


@pytest.fixture
def status(launch: Callable[..., Launch]) -> Iterator[Callable[..., Any]]:
    """Return a function that launches in a terminal with a status block."""
    # few tests emulate one
    from support.virtual_screen import StatusLaunch

    made: list[Any] = []

    def start(
        *entries: dict[str, Any],
        size: tuple[int, int] = (60, 12),
        shell: tuple[str, ...] = (),
        **settings: Any,
    ) -> Any:
        made.append(StatusLaunch(launch, size, entries, shell, settings))
        return made[-1]

    yield start
    for one in made:
        one.launch.clean_up()
        one.screen.close()


@pytest.fixture(scope='session')
def launch_type() -> type[Launch]:
    """Return what makes launches that several tests look at."""
    return Launch


@pytest.fixture
def sh() -> Callable[..., dict[str, Any]]:
    """Return a function that describes a shell script as a process."""

    def describe(label: str, script: str, **more: Any) -> dict[str, Any]:
        return {'label': label, 'argv': ['sh', '-c', script], **more}

    return describe


@pytest.fixture
def sleep() -> Callable[..., dict[str, Any]]:
    """Return a function that describes a process that does nothing long."""

    def describe(label: str, **more: Any) -> dict[str, Any]:
        # a shell may miss a signal while it comes up
        return {'label': label, 'argv': ['sleep', '999'], **more}

    return describe


@pytest.fixture
def python() -> Callable[..., dict[str, Any]]:
    """Return a function that describes a Python script as a process."""

    def describe(label: str, script: str, **more: Any) -> dict[str, Any]:
        argv = [sys.executable, '-S', '-c', script]
        return {'label': label, 'argv': argv, **more}

    return describe


@pytest.fixture
def process() -> Callable[..., Process]:
    """Return a function that makes a process of a plan."""

    def make(label: str = 'counter', *argv: str, **more: Any) -> Process:
        more.setdefault('position', Position('/ws/demo.yaml', 14, 5))
        more.setdefault('cwd', '/')
        return Process(label=label, argv=argv or ('true',), **more)

    return make


@pytest.fixture(name='wait_until', scope='session')
def wait_until_fixture() -> Callable[[Callable[[], Any]], Any]:
    """Return a function that waits for a condition."""
    return wait_until


@pytest.fixture(name='is_running')
def is_running_fixture() -> Callable[[int], bool]:
    """Return a function that tells whether a process runs."""
    return is_running
