# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Pieces of code in processes of their own that start at once.

A process that has imported what takes long forks one for each piece. What it
has imported does not depend on variables or the current folder.
"""

from collections.abc import Mapping
import json
import os
from pathlib import Path
import select
import signal
import subprocess
import sys
from typing import Any

SERVER = """\
import asyncio, distutils.core, distlib.util, json, os, sys, traceback
import contextlib, importlib.metadata

import catkin_pkg.package, catkin_pkg.condition, em, setuptools, yaml
import colcon_core.command, colcon_core.event_reactor, colcon_core.executor
import colcon_core.verb.build
import colcon_yamllaunch.run
import colcon_yamllaunch.verb.run_launch
import colcon_yamllaunch.workspace.building.update

# colcon's extensions, which it imports to ask which of them there are
for distribution in importlib.metadata.distributions():
    for point in distribution.entry_points:
        if point.group.startswith('colcon_core.'):
            with contextlib.suppress(Exception):
                point.load()

# what a Python of this installation adds to the variables whenever it starts
added = {k: v for k, v in os.environ.items() if k not in ('PATH', 'LANG')}
requests = os.fdopen(os.dup(0), 'rb')
replies = os.fdopen(os.dup(1), 'wb')
os.dup2(os.open(os.devnull, os.O_RDONLY), 0)

def run(request):
    output = os.open(request['output'], os.O_WRONLY)
    os.dup2(output, 1)
    os.dup2(output, 2)
    requests.close()
    replies.close()
    os.environ.clear()
    os.environ.update(added | request['environment'])
    sys.path[:] = ['', *request['path'], *sys.path[1:]]
    os.chdir(request['cwd'])
    try:
        exec(compile(request['code'], '<string>', 'exec'), {})
    except SystemExit as e:
        return e.code
    except BaseException:
        traceback.print_exc()
        return 1

for line in requests:
    pid = os.fork()
    if pid == 0:
        code = run(json.loads(line))
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code if isinstance(code, int) else int(code is not None))
    _, status = os.waitpid(pid, 0)
    code = os.waitstatus_to_exitcode(status)
    replies.write(b'%d\\n' % code)
    replies.flush()
"""


class Forks:
    """Runs pieces of code, one at a time."""

    def __init__(self) -> None:
        self._server: subprocess.Popen[bytes] | None = None

    def run(
        self,
        code: str,
        cwd: Path,
        environment: Mapping[str, str],
        output: Path,
        deadline: float,
    ) -> int:
        """
        Run code to its end, and return the exit code.

        :param output: A file for all that is printed
        :param deadline: Seconds that it may take
        """
        output.touch()
        # the interpreter reads it before any code runs
        path = environment.get('PYTHONPATH', '').split(os.pathsep)
        server = self._started()
        assert server.stdin is not None
        assert server.stdout is not None
        request: dict[str, Any] = {
            'code': code,
            'cwd': str(cwd),
            'environment': dict(environment),
            'path': [entry for entry in path if entry],
            'output': str(output),
        }
        server.stdin.write(json.dumps(request).encode() + b'\n')
        server.stdin.flush()
        ready, _, _ = select.select([server.stdout], [], [], deadline)
        if not ready:
            self.close()
            raise TimeoutError(output.read_text(errors='replace'))
        return int(server.stdout.readline())

    def close(self) -> None:
        """End all of it."""
        server, self._server = self._server, None
        if server is not None:
            os.killpg(server.pid, signal.SIGKILL)
            with server:
                pass

    def _started(self) -> 'subprocess.Popen[bytes]':
        if self._server is None:
            self._server = subprocess.Popen(
                [sys.executable, '-c', SERVER],
                env={'PATH': os.environ['PATH'], 'LANG': 'C.UTF-8'},
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                start_new_session=True,
            )
        return self._server
