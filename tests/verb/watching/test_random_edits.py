# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Edits at random, also while something is built or started anew.

After each burst of edits, what runs is what a fresh launch would run, and
nothing else: processes say what they were made from, and are compared with
the plan of a launch that begins then, and with `/proc`. `SOAK_MINUTES` says
for how long, `SOAK_SEED` with what it begins; `make soak` takes minutes, with
nodes of ROS and launch files in Python, too. Other runs of the tests have some
bursts that are always the same.
"""

from collections import Counter
import hashlib
import json
import os
from pathlib import Path
import re
import shutil
import subprocess
import time
from typing import Any

import pytest
from support.random_editor import Editor
from support.ros_parts import source_for
from support.user import DEADLINE, User
from support.watched import launch_processes, Watched

pytestmark = pytest.mark.full

SECONDS = 60 * float(os.environ.get('SOAK_MINUTES', '0'))
SEED = os.environ.get('SOAK_SEED', '1')
#: How many bursts there are without minutes.
FEW = 2
#: With minutes, the seeds that there are one after the other.
SEEDS = 4
NUMBERS = range(SEEDS if SECONDS else 1)


class Judge:
    """Compares what runs with what a fresh launch would run."""

    def __init__(self, user: User, editor: Editor, watched: Watched) -> None:
        self._user = user
        self._editor = editor
        self._watched = watched
        self._beside: Counter[str] = Counter()

    def differences(self) -> list[str]:
        """Tell what is not as it is in a fresh launch."""
        # as that takes its time, what began late shows afterwards
        return self._in_all() or self._in_plans() or self._in_all()

    def _in_all(self) -> list[str]:
        found = self._in_words() or self._in_processes()
        return found or (self._in_ros() if 'box' in self._editor.says else [])

    def _in_words(self) -> list[str]:
        """Compare what processes say, and which there are."""
        running = self._watched.running()
        lines = self._watched.last_lines()
        expected = self._editor.expected()
        found = []
        for label, line in expected.items():
            if label not in running:
                found.append(f'{label} does not run')
            elif lines.get(label) != line:
                found.append(f'{label} wrote {lines.get(label)}, not {line}')
        others = [pid for n, pid in running.items() if n not in expected]
        words = sorted(_command(pid)[-1] for pid in others)
        sleeps = self._editor.expected_sleeps()
        if words != sleeps:
            found.append(f'{words} sleep, not {sleeps}')
        return found

    def _in_ros(self) -> list[str]:
        """Look at states and components."""
        kinds = ('started', 'state_changed', 'loaded')
        last = {e['label']: e for e in self._watched.events(*kinds)}
        found = []
        if last['camera'].get('state') != 'active':
            found.append('camera is not active')
        if last['parameters']['time'] < last['box']['time']:
            found.append('parameters is not loaded')
        return found

    def _in_processes(self) -> list[str]:
        """Look for a process too many."""
        running = set(self._watched.running().values())
        helpers = _descendants(self._watched.launch.process.pid) - running
        # each job has a process of its own, which one like it comes after
        beside = Counter(' '.join(_command(pid)) for pid in helpers)
        # what asks for versions as the launch begins comes no more
        self._beside = self._beside & beside or beside
        found = []
        if beside != self._beside:
            found.append(f'{beside} are beside it, not {self._beside}')
        # what speaks with ROS belongs to the launch, too
        of_launch = launch_processes(min(running)) - helpers
        if of_launch != running:
            found.append(f'{of_launch} are of the launch, not {running}')
        return found

    def _in_plans(self) -> list[str]:
        """Compare with the plan of a launch that begins now."""
        shown = subprocess.run(
            ['colcon', 'launch', 'flow', 'demo.yaml', '--plan=json', '--why'],
            cwd=self._user.root,
            env=self._user.environment,
            capture_output=True,
            text=True,
            check=False,
        )
        if shown.returncode:
            return [f'no fresh launch: {shown.stderr}']
        found = [
            f'stale: {line}'
            for line in shown.stderr.splitlines()
            if '; needed by ' in line and 'up to date' not in line
        ]
        entries = json.loads(shown.stdout)['entries']
        plan = [_started(e) for e in entries if e['type'] == 'process']
        running = [_runs(pid) for pid in self._watched.running().values()]
        for one in plan:
            if one in running:
                running.remove(one)
            else:
                found.append(f'{one} is only in the plan')
        return [*found, *(f'{one} only runs' for one in running)]


def _started(entry: dict[str, Any]) -> list[str]:
    """Return what a process of a plan is when it runs."""
    program = shutil.which(entry['argv'][0])
    assert program is not None
    data = Path(program).read_bytes()
    code = 'a script' if data[:2] == b'#!' else _digest(data)
    return [entry['cwd'], code, *entry['argv']]


def _runs(pid: int) -> list[str]:
    """Return what a process is, likewise, whatever reads its script."""
    words = _command(pid)
    try:
        cwd = os.readlink(f'/proc/{pid}/cwd')
        code = _digest(Path(f'/proc/{pid}/exe').read_bytes())
    except OSError:
        return words
    if Path(words[0]).name.startswith('python'):
        code, words = 'a script', words[1:]
    return [cwd, code, *words]


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _command(pid: int) -> list[str]:
    try:
        data = Path(f'/proc/{pid}/cmdline').read_bytes()
    except OSError:
        return ['']
    return data.decode().split('\0')[:-1] or ['']


def _descendants(pid: int) -> set[int]:
    found: set[int] = set()
    pending = [pid]
    while pending:
        parent = pending.pop()
        try:
            path = Path(f'/proc/{parent}/task/{parent}/children')
            children = {int(word) for word in path.read_text().split()}
        except OSError:
            continue
        pending += children
        found |= children
    return found


# one after the other, so that they have the machine for themselves
one_by_one = pytest.mark.xdist_group('random_edits')


@one_by_one
@pytest.mark.parametrize('number', NUMBERS)
def test_random_edits_lead_to_what_a_new_launch_runs(user, number):
    edit_at_random(user, number)


@one_by_one
@pytest.mark.skipif(not SECONDS, reason='it takes minutes: make soak')
@pytest.mark.parametrize('number', NUMBERS)
def test_random_edits_lead_to_the_nodes_of_a_new_launch(
    user, ros_parts, ros_domain_id, number
):
    source_for(user, ros_parts, ros_domain_id)
    edit_at_random(user, number, 'ros')


@one_by_one
@pytest.mark.skipif(not SECONDS, reason='it takes minutes: make soak')
@pytest.mark.parametrize('number', NUMBERS)
def test_random_edits_of_python_launch_files(ros_user, number):
    edit_at_random(ros_user, number, 'python')


def edit_at_random(user: User, number: int, kind: str = '') -> None:
    """Edit the files of a launch, and compare after each burst."""
    user.root = user.root.resolve()
    # what Python has compiled is told apart by whole seconds
    user.environment['PYTHONDONTWRITEBYTECODE'] = '1'
    editor = Editor(user.root, f'{SEED}.{number}', number / SEEDS, kind)
    editor.lay_out()
    watched = Watched(user)
    editor.running = watched.running
    judge = Judge(user, editor, watched)
    end = time.monotonic() + SECONDS / SEEDS
    history: list[list[str]] = [[]]

    def judged() -> None:
        deadline = time.monotonic() + DEADLINE
        while found := judge.differences():
            shown = watched.launch.output
            assert watched.launch.process.poll() is None, shown
            if time.monotonic() > deadline:
                pytest.fail(f'{SEED} {history}: {found}\n{shown}')
            time.sleep(0.05)

    judged()
    while len(history) <= FEW or time.monotonic() < end:
        history.append(editor.burst())
        judged()
    left = _descendants(watched.launch.process.pid)
    assert watched.launch.interrupt() == 0
    assert not [pid for pid in left if Path(f'/proc/{pid}').exists()]
    assert _complaints(watched.launch.output) == []


def _complaints(output: str) -> list[str]:
    """Return what no user should see, but for what the edits broke."""
    # what colcon says of a package that it could not build is its own
    own = re.sub(r'(?ms)^--- stderr: \S+$.*?^---$', '', output)
    lines = [
        line
        for line in own.splitlines()
        if not re.match(r'\[(talk|mind|camera|box|further_\w+)\]', line)
    ]
    bad = ('Traceback', 'internal error', 'File "', 'nothing is watched')
    return [line for line in lines if any(text in line for text in bad)]
