# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A workspace whose launch goes on with its files, and what came of that."""

from collections import Counter
import json
from pathlib import Path
import re
import shutil
import time
from typing import Any

from support.user import DEADLINE, User
from support.waiting import wait_until as wait_until

_WORKSPACE = Path(__file__).with_name('watched_workspace')


class Watched:
    """
    A running `colcon launch --watch`.

    :param arguments: Further arguments
    """

    def __init__(self, user: User, *arguments: str) -> None:
        self.user = user
        self._seen = 0
        self._before = self.starts() if self._files() else Counter()
        self.launch = user.start(
            'colcon', 'launch', 'flow', 'demo.yaml', '--watch', *arguments
        )

    def says(self, pattern: str) -> re.Match[str]:
        """Wait until something is shown after what was saved last."""
        deadline = time.monotonic() + DEADLINE
        while time.monotonic() < deadline:
            shown = self.launch.output[self._seen :]
            found = re.search(pattern, shown)
            if found is not None:
                return found
            if self.launch.process.poll() is not None:
                break
            time.sleep(0.01)
        raise AssertionError(f'no {pattern!r} in:\n{self.launch.output}')

    def watches(self) -> 'Watched':
        """Wait until all runs, and needs no file any more to begin."""
        for name in ('talk', 'loop', 'other'):
            self.says(f'{name} says ')
        wait_until(lambda: len(self.running()) >= 4)
        return self

    def save(self, path: str, old: str, new: str) -> None:
        """Replace a text in a file of the package as an editor does."""
        file = self.user.root / 'src/flow' / path
        text = file.read_text()
        assert old in text
        self._seen = len(self.launch.output)
        # a new file takes the place of the old one
        draft = file.with_name(f'.{file.name}.swp')
        draft.write_text(text.replace(old, new))
        draft.chmod(file.stat().st_mode)
        draft.replace(file)

    def starts(self) -> 'Counter[str]':
        """Return how often each process was started."""
        return Counter(e['label'] for e in self.events('started'))

    def running(self) -> dict[str, int]:
        """Return the processes that run, by label."""
        found: dict[str, int] = {}
        for event in self.events('started', 'exited'):
            if event['event'] == 'started':
                found[event['label']] = event['pid']
            else:
                found.pop(event['label'], None)
        return found

    def last_lines(self) -> dict[str, str]:
        """Return the last line of each process, but for those of loggers."""
        pattern = r'^\[([\w.-]+)\] +(?![ \[])(.*)'
        lines = re.findall(pattern, self.launch.output, re.M)
        return dict(lines)

    def events(self, *kinds: str) -> list[dict[str, Any]]:
        """Return what was recorded of some kinds."""
        found = []
        for file in self._files():
            for line in file.read_text().split('\n')[:-1]:
                event = json.loads(line)
                if event['event'] in kinds:
                    found.append(event)
        return found

    def _files(self) -> list[Path]:
        found = self.user.root.glob('log/launch_*/events.jsonl')
        return [file for file in found if not file.parent.is_symlink()]


def make_flow(user: User) -> None:
    """Write the package `flow`, with a launch file that uses all of it."""
    shutil.copytree(_WORKSPACE / 'flow', user.root / 'src/flow')


def launch_processes(pid: int) -> set[int]:
    """Return all processes of the launch that a process belongs to."""
    identity = _identity(pid)
    folders = Path('/proc').glob('[0-9]*')
    pids = (int(folder.name) for folder in folders)
    return {p for p in pids if identity and _identity(p) == identity}


def _identity(pid: int) -> str:
    try:
        variables = Path(f'/proc/{pid}/environ').read_bytes().split(b'\0')
    except OSError:
        return ''
    for variable in variables:
        name, _, value = variable.decode(errors='replace').partition('=')
        if name == 'COLCON_LAUNCH_ID':
            return value.rpartition('.')[0]
    return ''
