#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Record a real run in a terminal and write it as an animated SVG.

    python .ci/picture.py docs/launch.svg

A launch of sample_ws is recorded in a copy of it: it builds, and goes on with
its files. While it runs, a script and a source in C++ are edited. Long waits
are shortened.
"""

from collections.abc import Iterator
from dataclasses import dataclass
import fcntl
import html
import os
from pathlib import Path
import pty
import random
import re
import select
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import termios
import time

SAMPLE_WS = Path(__file__).resolve().parents[1] / 'sample_ws'
COMMAND = ('colcon', 'launch', '--watch', 'my_pkg', 'demo.yaml')
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
#: Seconds until the messages are there, or the end after Ctrl-C.
PATIENCE = 300.0

#: The size of a character in the picture, and the space around the text.
WIDTH, HEIGHT, MARGIN = 8.4, 18, 14
#: The colours of a terminal by their SGR number: One Dark's.
COLORS = {
    31: '#e06c75',
    32: '#98c379',
    33: '#e5c07b',
    34: '#61afef',
    35: '#c678dd',
    36: '#56b6c2',
    37: '#dcdfe4',
    90: '#7f848e',
    91: '#ef7d87',
    92: '#a9d48a',
    93: '#f0cf8c',
    94: '#7dbff5',
    95: '#d291e4',
    96: '#6cc7d2',
}
FOREGROUND, BACKGROUND, FAINT = '#dcdfe4', '#1e2127', '#7f848e'
_ESCAPE = re.compile(
    r'\x1b\[([0-9;?]*)([A-Za-z])|\x1b\][^\x07\x1b]*(?:\x07|\x1b\\)'
)


@dataclass(frozen=True, slots=True)
class Chunk:
    """Some output, and the seconds that passed before it."""

    wait: float
    text: str


@dataclass(frozen=True, slots=True)
class Line:
    """A line of the film: when it appears, and its coloured pieces."""

    second: float
    pieces: tuple[tuple[str, str], ...]


def main() -> int:
    """Record, draw and write."""
    target = Path(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        workspace = Path(folder, 'sample_ws')
        products = shutil.ignore_patterns('build', 'install', 'log')
        shutil.copytree(SAMPLE_WS, workspace, ignore=products)
        chunks = list(_film(workspace))
    target.write_text(draw(lines_of(chunks)), encoding='utf-8')
    return 0


def _film(workspace: Path) -> Iterator[Chunk]:
    yield from _type(*COMMAND)
    yield from _record(workspace)
    yield Chunk(0.3, PROMPT)


def _type(*words: str) -> Iterator[Chunk]:
    yield Chunk(0.6, PROMPT)
    yield Chunk(TYPING * len(words), ' '.join(words) + '\n')


def _record(workspace: Path) -> Iterator[Chunk]:
    terminal, child_end = pty.openpty()
    size = struct.pack('HHHH', ROWS, COLUMNS, 0, 0)
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, size)
    launch = subprocess.Popen(
        COMMAND,
        cwd=workspace,
        env=os.environ
        | {
            'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
            'ROS_DOMAIN_ID': str(random.randint(1, 101)),
            'TERM': 'xterm-256color',
        },
        stdin=child_end,
        stdout=child_end,
        stderr=child_end,
        start_new_session=True,
    )
    os.close(child_end)
    try:
        yield from _watch(terminal, launch, workspace)
    finally:
        launch.kill()
        launch.wait()
        os.close(terminal)


def _watch(
    terminal: int, launch: 'subprocess.Popen[bytes]', workspace: Path
) -> Iterator[Chunk]:
    edits, new = list(EDITS), ''
    heard, last = 0, time.monotonic()
    deadline = last + PATIENCE
    while select.select([terminal], [], [], deadline - time.monotonic())[0]:
        try:
            text = os.read(terminal, 65536).decode(errors='replace')
        except OSError:
            return
        now = time.monotonic()
        yield Chunk(now - last, text)
        last = now
        heard += text.count('which double is')
        if heard >= MESSAGES and edits:
            heard = -(10**6)
            path, old, new = edits.pop(0)
            yield Chunk(
                0.4, f'\x1b[2m# saved {path}: {new}, not {old}\x1b[0m\n'
            )
            file = workspace / path
            file.write_text(file.read_text().replace(old, new))
            last = time.monotonic()
        elif heard < 0 and new in text:
            heard = 0
        elif heard >= MESSAGES:
            heard, new = -(10**6), '^C'
            yield Chunk(0.4, f'{new}\n')
            launch.send_signal(signal.SIGINT)
    raise SystemExit('the launch did not do what the picture shows')


def lines_of(chunks: list[Chunk]) -> list[Line]:
    """Cut what was recorded into lines, each with the time that it is done."""
    lines: list[Line] = []
    pieces: list[tuple[str, str]] = []
    second, style, column = 0.0, '', 0
    for chunk in chunks:
        second += min(chunk.wait, LONGEST_WAIT)
        for kind, text in _tokens(chunk.text):
            if kind == 'style':
                style = _style(text, style)
            elif kind == 'end':
                lines.append(Line(second, tuple(pieces)))
                pieces, column = [], 0
            else:
                while text:
                    if column == COLUMNS:
                        # it goes on in the next one
                        lines.append(Line(second, tuple(pieces)))
                        pieces, column = [], 0
                    shown = text[: COLUMNS - column]
                    text = text[len(shown) :]
                    column += len(shown)
                    pieces.append((style, shown))
    lines.append(Line(second, tuple(pieces)))
    return lines


def _tokens(text: str) -> Iterator[tuple[str, str]]:
    position = 0
    for escape in _ESCAPE.finditer(text):
        yield from _plain(text[position : escape.start()])
        if escape[2] == 'm':
            yield 'style', escape[1]
        position = escape.end()
    yield from _plain(text[position:])


def _plain(text: str) -> Iterator[tuple[str, str]]:
    for index, part in enumerate(text.replace('\r', '').split('\n')):
        if index:
            yield 'end', ''
        if part:
            yield 'text', part


def _style(codes: str, before: str) -> str:
    style = before
    for code in (int(c or 0) for c in codes.split(';')):
        if code == 0:
            style = ''
        elif code == 1:
            style += 'font-weight:bold;'
        elif code == 2:
            style += f'fill:{FAINT};'
        elif code in COLORS:
            style += f'fill:{COLORS[code]};'
    return style


def draw(lines: list[Line]) -> str:
    """Draw lines as an SVG that scrolls as a terminal does."""
    total = lines[-1].second + REST
    width = round(COLUMNS * WIDTH + 2 * MARGIN)
    height = ROWS * HEIGHT + 2 * MARGIN
    text = '\n'.join(
        _draw_line(number, line, total) for number, line in enumerate(lines)
    )
    return f"""\
<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" \
width="{width}" height="{height}" role="img" \
aria-label="A terminal: colcon launch --watch my_pkg demo.yaml">
<style>
text {{ font: 14px ui-monospace, Menlo, Consolas, 'DejaVu Sans Mono', \
monospace; fill: {FOREGROUND}; white-space: pre; }}
.line {{ animation: {total:.2f}s step-end infinite; }}
#all {{ animation: scroll {total:.2f}s step-end infinite; }}
{_scrolling(lines, total)}
@media (prefers-reduced-motion) {{ .line, #all {{ animation: none; }} \
#all {{ transform: translateY({_offset(len(lines))}px); }} }}
</style>
<clipPath id="screen"><rect x="0" y="{MARGIN}" width="{width}" \
height="{ROWS * HEIGHT}"/></clipPath>
<rect width="{width}" height="{height}" rx="8" fill="{BACKGROUND}"/>
<g clip-path="url(#screen)"><g id="all">
{text}
</g></g>
</svg>
"""


def _offset(shown: int) -> int:
    return -max(0, shown - ROWS) * HEIGHT


def _scrolling(lines: list[Line], total: float) -> str:
    steps = {0.0: 0}
    for number, line in enumerate(lines):
        steps[100 * line.second / total] = _offset(number + 1)
    frames = ' '.join(
        f'{percent:.3f}% {{ transform: translateY({offset}px); }}'
        for percent, offset in steps.items()
    )
    return f'@keyframes scroll {{ {frames} }}'


def _draw_line(number: int, line: Line, total: float) -> str:
    percent = 100 * line.second / total
    y = MARGIN + number * HEIGHT + round(HEIGHT * 0.75)
    spans = ''.join(
        f'<tspan style="{style}">{html.escape(text)}</tspan>'
        if style
        else html.escape(text)
        for style, text in line.pieces
    )
    return (
        f'<style>@keyframes l{number} {{ 0% {{ opacity: 0; }} '
        f'{percent:.3f}% {{ opacity: 1; }} }}</style>'
        f'<text class="line" style="animation-name:l{number}" '
        f'x="{MARGIN}" y="{y}" xml:space="preserve">{spans}</text>'
    )


if __name__ == '__main__':
    sys.exit(main())
