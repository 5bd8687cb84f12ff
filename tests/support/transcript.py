# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Somebody who does what a document says.

Two kinds of blocks are done. A file has its path behind the language
(```yaml src/my_pkg/launch/demo.yaml) and is written there. A transcript
(```console) has commands behind `$ `, and what each prints, in a terminal:

- `…` stands for anything, alone in its line for any number of lines;
- `> ` begins a line that is typed at the program;
- `^C` stands for that key, pressed when all before it has been printed.

A command must print just that, and end: with exit code 1 if the transcript
has an error, else with 0. A launch whose last line is `…` goes on, and what
follows is done in a second terminal, until a block begins with `^C`.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
import re
import shlex
import time

from support.terminal import DEADLINE, Terminal

_BLOCK = re.compile(r'^```(\w+)(?: (\S+))?\n(.*?)^```$', re.DOTALL | re.M)
#: Colours, and the title of the window.
_ESCAPES = re.compile(r'\x1b\[[0-9;?]*[a-zA-Z]|\x1b\][^\x07]*\x07|\x1bD')
#: What stays below the output, as it is drawn.
_STATUS = re.compile(r'\x1b7.*?\x1b8', re.DOTALL)
_ANYTHING = '…'
_PROMPT = '$ '
_TYPED = '> '
_INTERRUPT = '^C'
_LAUNCH = 'colcon launch '
_COLUMNS = 120
#: What is printed until the key is seen, and the terminal's echo of it.
_UP_TO_INTERRUPT = r'(?:.*\n)*?(?:\^C)?\n?'


@dataclass(frozen=True, slots=True)
class Block:
    """
    A fenced block.

    :param kind: The language behind the fence
    :param path: What stands behind the language, if anything
    :param text: What is in the block
    """

    kind: str
    path: str | None
    text: str


def blocks(text: str) -> Iterator[Block]:
    """Find the fenced blocks of a Markdown document."""
    for match in _BLOCK.finditer(text):
        yield Block(match[1], match[2], match[3])


def commands(transcript: str) -> list[tuple[str | None, list[str]]]:
    """Cut a transcript into commands, None for one that runs, and lines."""
    found: list[tuple[str | None, list[str]]] = [(None, [])]
    for line in transcript.splitlines():
        if line.startswith(_PROMPT):
            found.append((line.removeprefix(_PROMPT), []))
        else:
            found[-1][1].append(line)
    return found if found[0][1] else found[1:]


def pattern(lines: list[str]) -> str:
    """Return the regular expression that stands for lines of a transcript."""
    parts = []
    for line in lines:
        if line.strip() == _ANYTHING:
            parts.append(r'(?:.*\n)*?')
        else:
            words = map(re.escape, line.rstrip().split(_ANYTHING))
            parts.append('.*'.join(words) + r' *\n')
    return ''.join(parts)


class Reader:
    """
    Somebody who reads a document and does what it says.

    :param home: Their home, where they begin
    :param environment: Their environment
    """

    def __init__(self, home: Path, environment: dict[str, str]) -> None:
        self.cwd = home
        self._environment = environment
        self._terminals: list[Terminal] = []
        self._running: Terminal | None = None
        self._seen = 0

    def do(self, block: Block) -> None:
        """Do what a block says, and compare what it prints."""
        if block.kind == 'console':
            for command, lines in commands(block.text):
                self._do_command(command, lines)
        elif block.path is not None:
            file = self.cwd / block.path
            assert file.parent.is_dir(), f'{block.path}: there is no folder'
            file.write_text(block.text, encoding='utf-8')

    def end(self) -> int:
        """Wait for the end of the launch that goes on; return its code."""
        assert self._running is not None
        return self._running.ends()

    def leave(self) -> None:
        """End whatever still runs."""
        for terminal in self._terminals:
            terminal.close()

    def _do_command(self, command: str | None, lines: list[str]) -> None:
        if command is None:
            assert self._running is not None, lines
            terminal, self._running = self._running, None
            self._follow(terminal, self._seen, lines)
        elif command.startswith('cd '):
            words = shlex.split(command)
            self.cwd = (self.cwd / Path(words[1])).resolve(strict=True)
        else:
            terminal = Terminal(
                ['bash', '-c', command],
                self.cwd,
                self._environment,
                columns=_COLUMNS,
            )
            self._terminals.append(terminal)
            if _goes_on(command, lines):
                self._running = terminal
                self._seen = _wait(terminal, 0, pattern(lines))
            else:
                self._follow(terminal, 0, lines)

    def _follow(self, terminal: Terminal, seen: int, lines: list[str]) -> None:
        """Read what a program prints, and press the keys of the lines."""
        wanted = ''
        for line in lines:
            if line == _INTERRUPT:
                seen = _wait(terminal, seen, wanted)
                terminal.types('\x03')
                wanted = _UP_TO_INTERRUPT
            elif line.startswith(_TYPED):
                seen = _wait(terminal, seen, wanted + _TYPED)
                terminal.types(line.removeprefix(_TYPED) + '\n')
                wanted = pattern([line.removeprefix(_TYPED)])
            else:
                wanted += pattern([line])
        code = terminal.ends()
        output = shown(terminal)[seen:]
        assert re.fullmatch(wanted, output), '\n'.join(
            ['expected:', *lines, 'but it printed:', output]
        )
        assert code == any(': error:' in line for line in lines), output


def _goes_on(command: str, lines: list[str]) -> bool:
    return (
        command.startswith(_LAUNCH)
        and lines[-1:] == [_ANYTHING]
        and _INTERRUPT not in lines
    )


def shown(terminal: Terminal) -> str:
    """Return the output that a terminal has shown, as text."""
    output = _STATUS.sub('', terminal.screen)
    return _ESCAPES.sub('', output).replace('\r', '')


def _wait(terminal: Terminal, seen: int, wanted: str) -> int:
    """Wait for what shall be shown; return where it ends."""
    deadline = time.monotonic() + DEADLINE
    while time.monotonic() < deadline:
        has_ended = terminal.process.poll() is not None
        found = re.compile(wanted).match(shown(terminal), seen)
        if found:
            return found.end()
        if has_ended:
            break
        time.sleep(0.05)
    raise AssertionError(f'no {wanted!r} in:\n{shown(terminal)[seen:]}')
