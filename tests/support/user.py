# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The installed `colcon launch`, run in workspaces as users do."""

import codecs
import contextlib
import os
from pathlib import Path
import re
import signal
import subprocess
import sys
import time

from support.manifest import manifest

#: Seconds; a loaded machine needs some.
DEADLINE = 180
#: What the shell that runs the tests may have set.
FOREIGN_VARIABLES = re.compile(
    r'AMENT_|CMAKE_PREFIX_PATH|COLCON|ROS_|PYTHONPATH|OVERRIDE_LAUNCH'
)

#: Runs its arguments with all signals blocked, and SIGCHLD ignored.
BLOCKING = (
    sys.executable,
    '-c',
    'import os, signal, sys; '
    'signal.signal(signal.SIGCHLD, signal.SIG_IGN); '
    'signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals()); '
    'os.execvp(sys.argv[1], sys.argv[1:])',
)

CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project({name} NONE)
install(PROGRAMS scripts/hello.sh DESTINATION lib/${{PROJECT_NAME}})
install(DIRECTORY launch config DESTINATION share/${{PROJECT_NAME}})
"""
HELLO = '#!/bin/sh\necho "hello from {name}" "$@"\n'
LAUNCH = """\
launch:
  - executable:
      cmd: $(find-pkg-prefix {name})/lib/{name}/hello.sh
"""


class Launch:
    """A running `colcon launch`, or one that has ended."""

    def __init__(
        self, argv: list[str], cwd: Path, environment: dict[str, str]
    ) -> None:
        self._log = (cwd / f'.output-{time.monotonic_ns()}').open('w+b')
        Path(self._log.name).unlink()
        self.process = subprocess.Popen(
            argv,
            cwd=cwd,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=self._log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )

    @property
    def output(self) -> str:
        """All that was printed up to now."""
        size = os.fstat(self._log.fileno()).st_size
        data = os.pread(self._log.fileno(), size, 0)
        # the last character may be written in part
        return codecs.getincrementaldecoder('utf-8')().decode(data)

    def wait_for(self, pattern: str) -> re.Match[str]:
        """Wait until the output matches a regular expression."""
        deadline = time.monotonic() + DEADLINE
        while time.monotonic() < deadline:
            has_ended = self.process.poll() is not None
            found = re.search(pattern, self.output)
            if found:
                return found
            if has_ended:
                break
            time.sleep(0.02)
        raise AssertionError(f'no {pattern!r} in:\n{self.output}')

    def interrupt(self) -> int:
        """Do what Ctrl-C does, and wait for the end."""
        self.process.send_signal(signal.SIGINT)
        return self.end()

    def end(self) -> int:
        """Wait for the end and return the exit code."""
        return self.process.wait(timeout=DEADLINE)

    def close(self) -> None:
        """Leave nothing behind, whatever the test did."""
        if self.process.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
        self._log.close()


class User:
    """Somebody with a workspace and a shell."""

    def __init__(self, home: Path) -> None:
        self.root = home / 'ws'
        self.root.mkdir()
        (home / 'run').mkdir(mode=0o700)
        programs = str(Path(sys.executable).parent)
        self.environment = {
            name: value
            for name, value in os.environ.items()
            if not FOREIGN_VARIABLES.match(name)
        } | {
            'HOME': str(home),
            'PATH': os.pathsep.join([programs, os.environ['PATH']]),
            # so that others do not see the launches
            'XDG_RUNTIME_DIR': str(home / 'run'),
        }
        self._launches: list[Launch] = []

    def write(self, path: str, text: str, mode: int = 0o644) -> Path:
        """Write a file in the workspace."""
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding='utf-8')
        file.chmod(mode)
        return file

    def package(self, name: str, launch: str = LAUNCH) -> Path:
        """Write a plain CMake package that says hello."""
        self.write(f'src/{name}/CMakeLists.txt', CMAKE.format(name=name))
        hello = HELLO.format(name=name)
        self.write(f'src/{name}/scripts/hello.sh', hello, 0o755)
        self.write(f'src/{name}/config/hello.txt', 'hello\n')
        text = launch.replace('{name}', name)
        return self.write(f'src/{name}/launch/{name}.yaml', text).parents[1]

    def manifest(
        self, name: str, depends: str = '', mail: str = 'someone@example.com'
    ) -> Path:
        """Write the package.xml of a package."""
        text = manifest(name, 'cmake', depends, mail)
        return self.write(f'src/{name}/package.xml', text)

    def start(self, *words: str, cwd: Path | None = None) -> Launch:
        """Start a command."""
        launch = Launch(list(words), cwd or self.root, self.environment)
        self._launches.append(launch)
        return launch

    def launch(
        self, *words: str, cwd: Path | None = None, code: int = 0
    ) -> str:
        """Run `colcon launch` to its end and return its output."""
        launch = self.start('colcon', 'launch', *words, cwd=cwd)
        ended = launch.end()
        output = launch.output
        assert ended == code, output
        assert 'Traceback' not in output
        return output

    def leave(self) -> None:
        """End whatever is still running."""
        for launch in self._launches:
            launch.close()


def built(output: str) -> list[str]:
    """Return the packages that colcon built, sorted."""
    return sorted(re.findall(r'^Starting >>> (\S+)', output, re.MULTILINE))
