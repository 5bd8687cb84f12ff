# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A workspace whose launch goes on with its files, and what came of that."""

from collections import Counter
import json
from pathlib import Path
import re
import time
from typing import Any

from support.manifest import manifest
from support.user import DEADLINE
from support.user import User
from support.waiting import wait_until as wait_until

CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project(flow C)
add_library(word SHARED src/word.c)
add_executable(loop src/loop.c)
target_link_libraries(loop word)
add_executable(other src/other.c)
set_target_properties(loop PROPERTIES INSTALL_RPATH $ORIGIN/..)
install(TARGETS word DESTINATION lib)
install(TARGETS loop other DESTINATION lib/flow)
install(PROGRAMS scripts/talk.py DESTINATION lib/flow)
install(DIRECTORY launch config DESTINATION share/flow)
"""
PROGRAM = """\
#include <stdio.h>
#include <unistd.h>
{declared}
int main(void) {{ printf("{name} says %s\\n", {word}); fflush(stdout);
  for (;;) pause(); }}
"""
SCRIPT = """\
#!/usr/bin/env python3
import signal, sys, time
signal.signal(signal.SIGINT, lambda *_: sys.exit(0))
text = ''.join(open(p).read().strip() for p in sys.argv if p.endswith('.yaml'))
print('talk says one', text, flush=True)
while True: time.sleep(1000)
"""
LAUNCH = """\
launch:
- node:
    pkg: flow
    exec: talk.py
    name: talk
    param: [{from: $(find-pkg-share flow)/config/talk.yaml}]
- node: {pkg: flow, exec: loop, name: loop}
- node: {pkg: flow, exec: other, name: other}
- include: {file: $(find-pkg-share flow)/launch/more.yaml}
"""
MORE = """\
launch:
- executable: {cmd: sleep 1000, name: more}
"""


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
    user.write('src/flow/package.xml', manifest('flow', 'cmake'))
    user.write('src/flow/CMakeLists.txt', CMAKE)
    word = 'const char * word(void) { return "one"; }\n'
    user.write('src/flow/src/word.c', word)
    declared = 'const char * word(void);'
    loop = PROGRAM.format(name='loop', declared=declared, word='word()')
    user.write('src/flow/src/loop.c', loop)
    other = PROGRAM.format(name='other', declared='', word='"one"')
    user.write('src/flow/src/other.c', other)
    user.write('src/flow/scripts/talk.py', SCRIPT, 0o755)
    user.write('src/flow/config/talk.yaml', 'value: 1\n')
    user.write('src/flow/launch/demo.yaml', LAUNCH)
    user.write('src/flow/launch/more.yaml', MORE)


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
