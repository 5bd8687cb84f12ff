# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Edits at random, also while something is built or started anew.

After each burst of edits, what runs is what a fresh launch would run, and
nothing else. `SOAK_MINUTES` says for how long; `make soak` takes minutes,
other runs of the tests some seconds.
"""

from collections.abc import Callable
import os
from pathlib import Path
import random
import re
import time

import pytest
from support.watched import launch_processes
from support.watched import make_flow
from support.watched import wait_until
from support.watched import Watched

pytestmark = pytest.mark.full

SECONDS = 60 * float(os.environ.get('SOAK_MINUTES', '0.08'))
SEED = os.environ.get('WATCH_SEED')
#: How long what an edit leads to may take on a busy machine (seconds).
PATIENCE = 120.0


class Editor:
    """
    Somebody who edits the package, and knows what has to run then.

    :param root: The folder of the package
    """

    def __init__(self, root: Path, chance: random.Random) -> None:
        self._root = root
        self._chance = chance
        self._version = 0
        #: What each file of interest is to say, when it is whole.
        self.whole: dict[str, str] = {
            name: (root / name).read_text()
            for name in (
                *('scripts/talk.py', 'src/word.c', 'src/other.c'),
                *('config/talk.yaml', 'launch/demo.yaml', 'launch/more.yaml'),
            )
        }
        self.says = {'talk': 'one', 'loop': 'one', 'other': 'one'}
        self.value = '1'
        self.further: list[int] = []
        self.edits: list[Callable[[], None]] = [
            self._script,
            self._library,
            self._program,
            self._parameters,
            self._add,
            self._remove,
            self._break,
            self._delete,
            self._repeat,
            self._unused,
            self._mend,
        ]

    def burst(self) -> list[str]:
        """Edit this and that, until all is whole."""
        done = []
        for _ in range(self._chance.randrange(1, 6)):
            edit = self._chance.choice(self.edits)
            edit()
            done.append(edit.__name__)
            time.sleep(self._chance.choice((0.0, 0.0, 0.05, 0.3, 1.0)))
        self._mend()
        return done

    def expected(self) -> dict[str, str]:
        """Return the last line of each node."""
        lines = {n: f'{n} says {w}' for n, w in self.says.items()}
        lines['talk'] += f' value: {self.value}'
        return lines

    def _next(self) -> str:
        self._version += 1
        return f'v{self._version}'

    def _save(self, name: str, text: str) -> None:
        file = self._root / name
        match self._chance.randrange(4):
            case 0:
                file.write_text(text)
            case 1:
                # as vim does: a probe, a backup, a new file
                probe = file.with_name('4913')
                probe.touch()
                probe.unlink()
                backup = file.with_name(f'{file.name}~')
                if file.exists():
                    file.rename(backup)
                file.write_text(text)
                backup.unlink(missing_ok=True)
            case 2:
                draft = file.with_name(f'.{file.name}.tmp')
                draft.write_text(text)
                draft.rename(file)
            case 3:
                # in two goes
                file.write_text(text[: len(text) // 2])
                file.write_text(text)
        if name.startswith('scripts/'):
            file.chmod(0o755)

    def _set(self, name: str, old: str, new: str) -> None:
        assert old in self.whole[name], (name, old)
        self.whole[name] = self.whole[name].replace(old, new)
        self._save(name, self.whole[name])

    def _script(self) -> None:
        new = self._next()
        self._set(
            'scripts/talk.py', f'says {self.says["talk"]}', f'says {new}'
        )
        self.says['talk'] = new

    def _library(self) -> None:
        new = self._next()
        self._set('src/word.c', f'"{self.says["loop"]}"', f'"{new}"')
        self.says['loop'] = new

    def _program(self) -> None:
        new = self._next()
        self._set('src/other.c', f'"{self.says["other"]}"', f'"{new}"')
        self.says['other'] = new

    def _parameters(self) -> None:
        new = self._next()
        self._set('config/talk.yaml', f': {self.value}', f': {new}')
        self.value = new

    def _add(self) -> None:
        self.further.append(100_000 + int(self._next()[1:]))
        self._include()

    def _remove(self) -> None:
        if self.further:
            self.further.remove(self._chance.choice(self.further))
            self._include()

    def _include(self) -> None:
        text = 'launch:\n' + ''.join(
            f'- executable: {{cmd: sleep {n}, name: further}}\n'
            for n in (1000, *self.further)
        )
        self.whole['launch/more.yaml'] = text
        self._save('launch/more.yaml', text)

    def _break(self) -> None:
        name = self._chance.choice(sorted(self.whole))
        self._save(name, '}{ this is broken (\n' + self.whole[name])

    def _delete(self) -> None:
        name = self._chance.choice(sorted(self.whole))
        (self._root / name).unlink(missing_ok=True)

    def _repeat(self) -> None:
        name = self._chance.choice(sorted(self.whole))
        self._save(name, self.whole[name])

    def _unused(self) -> None:
        for name in ('.git/index.lock', 'README.md~', '#talk.py#'):
            file = self._root / name
            file.parent.mkdir(exist_ok=True)
            file.write_text(self._next())

    def _mend(self) -> None:
        for name, text in self.whole.items():
            file = self._root / name
            if not file.exists() or file.read_text() != text:
                self._save(name, text)


def test_what_runs_is_what_a_fresh_launch_would_run(user):
    seed = SEED or str(random.randrange(10**6))
    make_flow(user)
    editor = Editor(user.root / 'src/flow', random.Random(seed))
    editor._include()
    w = Watched(user).watches()
    end = time.monotonic() + SECONDS
    history: list[list[str]] = []

    def differences() -> list[str]:
        """Tell what is not as it is in a fresh launch."""
        running = w.running()
        sleeps = {'1000', *map(str, editor.further)}
        found = []
        lines = w.last_lines()
        for label, line in editor.expected().items():
            if label not in running:
                found.append(f'{label} does not run')
            elif lines.get(label) != line:
                found.append(f'{label} wrote {lines.get(label)}, not {line}')
        others = [p for n, p in running.items() if n not in editor.says]
        words = sorted(_argument(pid) for pid in others)
        if words != sorted(sleeps):
            found.append(f'{words} sleep, not {sorted(sleeps)}')
        return found

    def is_all() -> bool:
        pids = set(w.running().values())
        return launch_processes(min(pids)) == pids

    while not history or time.monotonic() < end:
        history.append(editor.burst())
        deadline = time.monotonic() + PATIENCE
        while found := differences():
            if time.monotonic() > deadline:
                pytest.fail(f'{seed} {history}: {found}\n{w.launch.output}')
            assert w.launch.process.poll() is None, w.launch.output
            time.sleep(0.02)
        wait_until(is_all)
    # but for the script, which may begin while its file is away
    output = re.sub(r'^\[talk\].*', '', w.launch.output, flags=re.M)
    assert 'Traceback' not in output
    assert 'internal error' not in output
    w.launch.interrupt()


def _argument(pid: int) -> str:
    try:
        words = Path(f'/proc/{pid}/cmdline').read_bytes().split(b'\0')
    except OSError:
        return ''
    return words[1].decode() if len(words) > 1 else ''
