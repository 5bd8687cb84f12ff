# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Processes that editors debug: `--debug`, with the real debuggers."""

from collections.abc import Iterator
from contextlib import contextmanager
import json
from pathlib import Path
import shutil
import socket
import subprocess
import sys
from typing import Any

import pytest
from support.user import User

SCRIPT = """\
import time
value = 40
value += 2
print('value', value, flush=True)
time.sleep(99)
"""
C = """\
#include <stdio.h>
#include <unistd.h>
int main(void) {
  int value = 40;
  value += 2;
  printf("value %d\\n", value);
  fflush(stdout);
  return sleep(99);
}
"""
LAUNCH = """\
launch:
  - executable: {{cmd: {0} script.py}}
  - executable: {{cmd: ./program}}
"""


@pytest.fixture
def second(second: User) -> User:
    second.write('launch.yaml', LAUNCH.format(sys.executable))
    # as --symlink-install does
    second.write('source.py', SCRIPT)
    (second.root / 'script.py').symlink_to('source.py')
    second.write('program', '#!/bin/sh\necho value 42\nexec sleep 99\n')
    (second.root / 'program').chmod(0o755)
    return second


@pytest.fixture
def port() -> int:
    with socket.socket() as listener:
        listener.bind(('127.0.0.1', 0))
        found: int = listener.getsockname()[1]
        return found


class Editor:
    """What an editor says in the Debug Adapter Protocol."""

    def __init__(self, port: int) -> None:
        self._socket = socket.create_connection(('127.0.0.1', port), 30)
        self._file = self._socket.makefile('rb')
        self._number = 0

    def close(self) -> None:
        self._file.close()
        self._socket.close()

    def ask(self, command: str, **arguments: Any) -> None:
        self._number += 1
        message = {
            'seq': self._number,
            'type': 'request',
            'command': command,
            'arguments': arguments,
        }
        data = json.dumps(message).encode()
        header = f'Content-Length: {len(data)}\r\n\r\n'.encode()
        self._socket.sendall(header + data)

    def wait_for(self, name: str) -> dict[str, Any]:
        """Return the body of the next event or response of a name."""
        while True:
            length = 0
            while (line := self._file.readline().strip()) != b'':
                length = int(line.partition(b':')[2])
            message = json.loads(self._file.read(length))
            if name in (message.get('event'), message.get('command')):
                assert message.get('success', True), message
                body: dict[str, Any] = message.get('body') or {}
                return body


@contextmanager
def connected(port: int) -> Iterator[Editor]:
    editor = Editor(port)
    try:
        yield editor
    finally:
        editor.close()


def test_an_editor_debugs_a_program_in_python(second: User, port: int) -> None:
    pytest.importorskip('debugpy')
    launch = second.start('colcon', 'launch', 'launch.yaml')
    launch.wait_for(r'python-1\] +value 42')
    output = second.launch('--debug', f'python-1:{port}')
    assert f'python-1: waits for a debugger at 127.0.0.1:{port}' in output
    assert launch.output.count('value 42') < 4
    source = second.root / 'source.py'
    with connected(port) as editor:
        editor.ask('initialize', adapterID='debugpy')
        editor.wait_for('initialize')
        editor.ask('attach', justMyCode=False)
        editor.wait_for('initialized')
        editor.ask(
            'setBreakpoints',
            source={'path': str(source)},
            breakpoints=[{'line': 3}],
        )
        editor.wait_for('setBreakpoints')
        editor.ask('configurationDone')
        stopped = editor.wait_for('stopped')
        editor.ask('stackTrace', threadId=stopped['threadId'])
        frame = editor.wait_for('stackTrace')['stackFrames'][0]
        path = Path(frame['source']['path']).resolve()
        assert (path, frame['line']) == (source, 3)
        editor.ask('evaluate', expression='value', frameId=frame['id'])
        assert editor.wait_for('evaluate')['result'] == '40'
        # who asks for the same port meanwhile ends nothing
        refused = second.launch('--debug', f'program:{port}', code=1)
        assert f'port {port} cannot be used: Address already' in refused
        editor.ask('disconnect')
    assert launch.interrupt() == 0, launch.output


@pytest.mark.skipif(
    not all(map(shutil.which, ('gdb', 'gdbserver', 'cc'))),
    reason='needs gdb, gdbserver and a C compiler',
)
def test_an_editor_debugs_a_compiled_program(
    second: User, port: int, tmp_path: Path
) -> None:
    source, program = second.root / 'program.c', second.root / 'program'
    source.write_text(C)
    command = ['cc', '-g', '-O0', '-o', str(program), str(source)]
    subprocess.run(command, check=True)
    launch = second.start('colcon', 'launch', 'launch.yaml')
    launch.wait_for(r'program.*value 42')
    output = second.launch('--debug', f'program:{port}')
    assert f'program-2: waits for a debugger at 127.0.0.1:{port}' in output
    orders = [
        *('set sysroot /', f'target remote 127.0.0.1:{port}'),
        *('break program.c:5', 'continue', 'print value', 'detach'),
    ]
    seen = subprocess.run(
        ['gdb', '-q', '-batch', *(f'-ex={o}' for o in orders), str(program)],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert '$1 = 40' in seen.stdout, seen
    assert launch.interrupt() == 0, launch.output


def test_what_cannot_be_debugged_runs_on(second: User, port: int) -> None:
    second.environment['PATH'] = f'{second.root}:{second.environment["PATH"]}'
    second.write(
        'python',
        f'#!/bin/sh\n[ "$1" = -c ] && exit 1\nexec {sys.executable} "$@"\n',
    )
    (second.root / 'python').chmod(0o755)
    second.write('launch.yaml', LAUNCH.format('python'))
    launch = second.start('colcon', 'launch', 'launch.yaml')
    launch.wait_for(r'python.*value 42')
    refused = second.launch('--debug', f'python:{port}', code=1)
    assert 'python -m pip install debugpy' in refused
    refused = second.launch('--debug', 'python:0', code=1)
    assert "needs a port from 1 to 65535 after ':', not '0'" in refused
    refused = second.launch('--debug', '*', code=1)
    assert '--debug takes one process, not ' in refused
    assert 'debug requested' not in launch.output
    assert launch.interrupt() == 0, launch.output
