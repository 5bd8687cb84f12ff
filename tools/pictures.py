#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Make the pictures of the documentation from real runs in a terminal.

    .venv/bin/python tools/pictures.py            # all of them, in two minutes
    .venv/bin/python tools/pictures.py launch     # docs/launch.svg alone

`launch` is an animated one: a launch of sample_ws builds, and goes on with its
files, while a script and a source in C++ are edited. Long waits are shortened.
The others are screens of launches of the package `robot`, which is beside
this file. All of them run in copies.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
import random
import shutil
import sys
import tempfile
import time

from recorded_terminal import PATIENCE, Piece, RecordedTerminal, Row
from svg_terminal import Film, film, Frame, still

CI = Path(__file__).resolve().parent
SAMPLE_WS = CI.parent / 'sample_ws'
DOCS = CI.parent / 'docs'

COMMAND = ('colcon', 'launch', '--watch', 'my_pkg', 'demo.yaml')
#: What the screens are of.
ROBOT = ('colcon', 'launch', 'robot')
#: What is replaced while it runs: in which file, and by what.
EDITS = (
    ('src/my_pkg/scripts/counter.py', 'Publishing', 'Sending'),
    ('flow/src/pump.cpp', 'Pumped', 'Moved'),
)
PROMPT = '\x1b[1;32m~/sample_ws$\x1b[0m '
#: The terminal, in characters.
COLUMNS, ROWS = 96, 24
#: Seconds without output that are shown at most.
LONGEST_WAIT = 0.7
#: Seconds that typing a word takes, and that the film stands at its end.
TYPING, REST = 0.15, 4.0
#: How often the listener speaks before each edit, and before Ctrl-C.
MESSAGES = 3


def main() -> int:
    """Record, draw and write."""
    makers = {'launch': _launch, 'robot': _robot, 'map': _map, 'fleet': _fleet}
    names = sys.argv[1:] or [*makers]
    unknown = {*names} - {*makers}
    if unknown:
        raise SystemExit(f'there is {", ".join(makers)}, no {unknown.pop()}')
    for name in names:
        makers[name]()
    return 0


# the film


class _Recording:
    """Makes a film of what a terminal shows."""

    def __init__(self, terminal: RecordedTerminal) -> None:
        self._terminal = terminal
        self.film = Film(COLUMNS, ROWS)
        self._second = 0.0
        self._last = time.monotonic()
        self._known = 0
        self.take(0.0)

    def take(self, second: float | None = None) -> list[str]:
        """
        Take what is shown now, and return the new lines.

        :param second: How many seconds have passed, unless it is as many as
          have
        """
        new = self._terminal.output(self._known)
        below = tuple(self._terminal.below())
        frames = self.film.frames
        if new or not frames or frames[-1].below != below:
            now = time.monotonic()
            if second is None:
                second = min(now - self._last, LONGEST_WAIT)
            self._last = now
            self._known += len(new)
            self._add(second, new, below)
        return [''.join(piece.text for piece in row) for row in new]

    def remark(self, row: Row) -> None:
        """Put something among the output that no program has written."""
        self._add(0.4, [row], self.film.frames[-1].below)

    def _add(
        self, wait: float, rows: list[Row], below: tuple[Row, ...]
    ) -> None:
        self._second += wait
        self.film.output += rows
        count = len(self.film.output)
        self.film.frames.append(Frame(self._second, count, below))


def _launch() -> None:
    with (
        _copied(SAMPLE_WS) as workspace,
        _terminal(COLUMNS) as terminal,
    ):
        recording = _Recording(terminal)
        terminal.show(PROMPT)
        recording.take(0.6)
        terminal.show(' '.join(COMMAND) + '\n')
        recording.take(TYPING * len(COMMAND))
        terminal.run(*COMMAND, folder=workspace)
        _watch(terminal, recording, workspace)
        terminal.show(PROMPT)
        recording.take(0.3)
    title = f'A terminal: {" ".join(COMMAND)}'
    _write('launch', film(recording.film, REST, title))


def _watch(
    terminal: RecordedTerminal, recording: _Recording, workspace: Path
) -> None:
    """Edit what runs, and stop it at last."""
    edits, new = list(EDITS), ''
    heard = 0
    deadline = time.monotonic() + PATIENCE
    while terminal.is_running:
        if time.monotonic() > deadline:
            raise SystemExit('the launch did not do what the picture shows')
        terminal.read(0.1)
        text = '\n'.join(recording.take())
        if new not in text:
            # what was saved is not there yet
            continue
        new = ''
        heard += text.count('which double is')
        if heard < MESSAGES:
            continue
        heard = 0
        if len(edits) == len(EDITS):
            recording.film.poster = len(recording.film.frames) - 1
        if edits:
            path, old, new = edits.pop(0)
            recording.remark(_remark(f'# saved {path}: {new}, not {old}'))
            file = workspace / path
            file.write_text(file.read_text().replace(old, new))
        else:
            new = 'stopping'
            recording.remark(_remark('# Ctrl-C'))
            terminal.type('\x03')
    terminal.read(0.1)
    recording.take()


# the screens


def _robot() -> None:
    with _robot_ws() as workspace:
        with _terminal(80) as terminal:
            terminal.run(*ROBOT, 'robot.yaml', folder=workspace)
            terminal.wait_for('gripper ×2 exit 1')
            if not terminal.comes('% ', seconds=20.0):
                print('the planner got little, as the machine is busy')
            terminal.wait(2.0)
            _still('terminal_block', terminal, 12, 'The status block')
            terminal.type('2')
            terminal.wait_for('s stop', 'l log')
            _still('terminal_keys', terminal, 8, "After a process's key")
            # the blank takes that back
            terminal.type(' LL/dark\r2m')
            terminal.wait_for('/dark', 'level WARN', '1 muted')
            terminal.type('\r')
            # by then what was before has scrolled away
            terminal.wait_for('is dark', count=9)
            _still('terminal_filter', terminal, 7, 'Lines that have a text')
        _full_screen(workspace)
        with _terminal(40) as terminal:
            terminal.run(*ROBOT, 'robot.yaml', folder=workspace)
            terminal.wait_for('gripper ×2 exit 1')
            terminal.wait(2.0)
            _still('terminal_narrow', terminal, 12, 'The same in 40 columns')


def _full_screen(workspace: Path) -> None:
    # so that lines fit
    form = '[{severity}] [{name}]: {message}'
    with _terminal(100, RCUTILS_CONSOLE_OUTPUT_FORMAT=form) as terminal:
        terminal.run(*ROBOT, 'robot.yaml', '--ui', folder=workspace)
        terminal.wait_for('3 ✗ gripper')
        terminal.type('2')
        terminal.wait(4.0)
        _still('full_screen', terminal, 24, 'The full screen of a launch')
        terminal.type('\x03')
        terminal.wait_for('ended')
        terminal.type('q')
        while terminal.is_running:
            terminal.read(0.1)


def _map() -> None:
    with _robot_ws() as workspace, _terminal(80) as terminal:
        terminal.run(*ROBOT, 'map.yaml', folder=workspace)
        terminal.wait_for('frame 4')
        terminal.type('2a')
        terminal.wait_for('Name of')
        terminal.type('kitchen\r')
        terminal.wait_for('the kitchen')
        terminal.wait(2.0)
        terminal.type('living ro')
        terminal.wait_for('living ro')
        title = 'The input line'
        _still('terminal_input', terminal, 12, title, with_cursor=True)


def _fleet() -> None:
    with _robot_ws() as workspace, _terminal(80) as terminal:
        terminal.run(*ROBOT, 'fleet.yaml', folder=workspace)
        terminal.wait_for('gripper exit 1')
        terminal.wait(2.0)
        _still('terminal_many', terminal, 10, 'Many processes')


def _remark(text: str) -> Row:
    return (Piece(0, text, 'brightblack', 'default', False),)


def _terminal(columns: int, **variables: str) -> RecordedTerminal:
    # apart from what else talks on this machine
    variables['ROS_DOMAIN_ID'] = str(random.randint(1, 101))
    return RecordedTerminal(columns, ROWS, variables)


@contextmanager
def _copied(source: Path) -> Iterator[Path]:
    """Return a copy of a folder, without what was built in it."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, source.name)
        products = shutil.ignore_patterns('build', 'install', 'log')
        shutil.copytree(source, copy, ignore=products)
        yield copy


@contextmanager
def _robot_ws() -> Iterator[Path]:
    """Return a workspace with the package `robot`."""
    with tempfile.TemporaryDirectory() as folder:
        workspace = Path(folder, 'robot_ws')
        shutil.copytree(CI / 'robot', workspace / 'src' / 'robot')
        yield workspace


def _still(
    name: str,
    terminal: RecordedTerminal,
    count: int,
    title: str,
    *,
    with_cursor: bool = False,
) -> None:
    """Write the last rows of a screen."""
    rows = terminal.rows(with_cursor=with_cursor)[-count:]
    _write(name, still(rows, terminal.columns, title))


def _write(name: str, picture: str) -> None:
    path = DOCS / f'{name}.svg'
    path.write_text(picture, encoding='utf-8')
    print(f'{path.relative_to(CI.parent)}: {len(picture) / 1024:.0f} KiB')


if __name__ == '__main__':
    sys.exit(main())
