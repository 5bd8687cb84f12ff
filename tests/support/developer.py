# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Somebody with a workspace here and a machine that it is brought to.

The machine is a folder here, reached by processes instead of ssh. Each request
is answered by a process of its own, which has the standard library and our
modules and nothing else, as on a machine.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
from typing import Any

import colcon_yamllaunch
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
)
from colcon_yamllaunch.remote.sync.code_sync import Code, sync_code, Synced
from colcon_yamllaunch.workspace.packages.package import Package
from support.file_clock import let_files_settle
from support.user import CMAKE, HELLO

#: What is asked when there is nothing to bring.
QUIET = ['build.begin', 'build.end']
_ANSWER = """\
import sys
sys.path.insert(0, sys.argv[1])
import importlib, json, os
from colcon_yamllaunch.common.errors import UserError
module, _, name = sys.argv[2].partition('.')
found = importlib.import_module('colcon_yamllaunch.remote.sync.' + module)
arguments = json.loads(sys.stdin.buffer.read())
os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
out = os.dup(1)
os.dup2(2, 1)
def tell(**message):
    os.write(out, json.dumps(message).encode() + b'\\n')
try:
    tell(result=getattr(found, name)(arguments, lambda line: tell(line=line)))
except UserError as e:
    tell(error=str(e))
"""
_LIBRARY = str(Path(colcon_yamllaunch.__file__).parent.parent)


class MachineHere(MachineConnection):
    """
    A machine, which is its own connection.

    :param home: The home folder there; it is made
    :param programs: Where its programs are
    """

    def __init__(self, home: Path, programs: str | None = None) -> None:
        home.mkdir(exist_ok=True)
        self.home = home
        self.root = home / 'ws'
        path = programs or os.pathsep.join(
            [str(Path(sys.executable).parent), os.environ['PATH']]
        )
        self.environment = {'HOME': str(home), 'PATH': path}
        #: What each of its commands begins with.
        self.inside: list[str] = []
        #: The requests and programs that it was asked for.
        self.asked: list[str] = []
        self._running: list[subprocess.Popen[bytes]] = []

    def ask(
        self,
        request: str,
        arguments: Mapping[str, Any],
        on_line: Callable[[str], None] | None = None,
    ) -> dict[str, Any]:
        self.asked.append(request)
        # the Python of no virtual environment, which might have a colcon
        python = os.path.realpath(sys.executable)
        command = [python, '-I', '-S', '-c']
        with subprocess.Popen(
            [*self.inside, *command, _ANSWER, _LIBRARY, request],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd=self.home,
            env=self.environment,
            start_new_session=True,
        ) as process:
            self._running.append(process)
            assert process.stdin is not None and process.stdout is not None
            process.stdin.write(json.dumps(arguments).encode())
            process.stdin.close()
            for line in process.stdout:
                message = json.loads(line)
                if 'line' in message:
                    assert on_line is not None
                    on_line(message['line'])
                elif 'error' in message:
                    raise UserError(message['error'])
                else:
                    result: dict[str, Any] = message['result']
                    return result
        raise UserError('the connection is lost')

    def run_program(
        self, argv: Sequence[str], stdin: int, stdout: int
    ) -> tuple[int, list[str]]:
        self.asked.append(argv[0])
        process = subprocess.run(
            [*self.inside, *argv],
            stdin=stdin,
            stdout=stdout,
            stderr=subprocess.PIPE,
            cwd=self.home,
            env=self.environment,
            check=False,
        )
        os.close(stdin)
        os.close(stdout)
        code = process.returncode
        errors = process.stderr.decode(errors='replace').splitlines()
        return code if code >= 0 else 128 - code, errors

    def forget(self, name: str) -> None:
        """Have a program there no more."""
        programs = self.home / 'programs'
        programs.mkdir(exist_ok=True)
        for folder in reversed(self.environment['PATH'].split(os.pathsep)):
            for program in Path(folder).glob('*'):
                link = programs / program.name
                link.unlink(missing_ok=True)
                link.symlink_to(program)
        (programs / name).unlink()
        self.environment['PATH'] = str(programs)

    def write(self, path: str, text: str, mode: int = 0o644) -> Path:
        """Write a file in the workspace there."""
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        file.chmod(mode)
        return file

    def close(self) -> None:
        """End what still runs of requests."""
        for process in self._running:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)


class Developer:
    """Somebody with a workspace here and a machine."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / 'here'
        self.machine = MachineHere(folder / 'arm')
        #: How it is reached.
        self.connection: MachineConnection = self.machine
        self.packages: list[Package] = []
        self.said: list[str] = []
        self.build_arguments: tuple[str, ...] = ()
        self.merge_install = False
        self.environment: dict[str, str] = {}

    def write(self, path: str, text: str, mode: int = 0o644) -> Path:
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        file.chmod(mode)
        return file

    def package(self, name: str, *needs: str) -> None:
        self.write(f'src/{name}/CMakeLists.txt', CMAKE.format(name=name))
        hello = HELLO.format(name=name)
        self.write(f'src/{name}/scripts/hello.sh', hello, 0o755)
        self.write(f'src/{name}/config/hello.txt', 'hello\n')
        (self.root / f'src/{name}/launch').mkdir()
        self.add(name, f'src/{name}', 'cmake', *needs)

    def add(
        self, name: str, place: str, package_type: str, *needs: str
    ) -> None:
        """Have a package whose files are there."""
        path = self.root / place
        self.packages.append(
            Package(name, path, package_type, frozenset(needs))
        )

    def move(self, name: str, place: str) -> None:
        """Have a package elsewhere, where it was moved to."""
        self.packages = [
            replace(package, path=self.root / place)
            if package.name == name
            else package
            for package in self.packages
        ]

    def sync(self, *needed: str, mode: str = 'build') -> Synced:
        let_files_settle(self.root)
        self.said.clear()
        self.machine.asked.clear()
        code = Code(
            self.root,
            self.packages,
            self.root / 'build',
            self.root / 'install',
            merge_install=self.merge_install,
            build_arguments=self.build_arguments,
            settings={},
            environment=self.environment,
            title='colcon launch a',
        )
        return sync_code(
            mode,
            'arm',
            str(self.machine.root),
            self.connection,
            code,
            frozenset(needed),
            self.said.append,
        )

    def hello(self, name: str) -> str:
        path = self.machine.root / f'install/{name}/lib/{name}/hello.sh'
        return subprocess.run([path], capture_output=True, text=True).stdout
