# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The launchers that `benchmarks/peers.py` measures."""

from collections.abc import Callable
from dataclasses import dataclass, replace
import json
from pathlib import Path
import re
import shlex
import shutil
import subprocess
import sys
import tarfile
import urllib.request
import venv

from runtime import Commands, launch_file, Launcher, PATIENCE

PROCESS_COMPOSE = (
    'https://github.com/F1bonacc1/process-compose/releases/latest/download/'
    'process-compose_linux_amd64.tar.gz'
)
BETTER_LAUNCH = """\
from better_launch import BetterLaunch, launch_this


@launch_this
def start():
    launch = BetterLaunch()
    for number, (program, *arguments) in enumerate({commands}):
        launch.node(
            'none',
            program,
            f'p{{number}}',
            cmd_args=arguments,
            raw=True,
            autostart_process=False,
        ).start()
"""


class FailedError(Exception):
    """A launcher did not do its work; the text says what was missing."""


@dataclass(frozen=True)
class Peer:
    """
    A launcher. Commands are words with spaces between them.

    :param name: Its name in the tables
    :param program: The program that must be on the PATH
    :param command: The command that launches FILE
    :param version: The command that prints the version
    :param file: The name of its file
    :param write: Returns the text of its file, from the command lines
    :param package: Its name on PyPI
    :param release: The address of a `.tar.gz` that contains the program
    :param watches: The option that makes it restart what is edited; empty if
      it does so anyway, None if it cannot
    :param arguments: The command that shows the launch arguments of FILE
    :param path: The program that was found
    """

    name: str
    program: str
    command: str
    version: str
    file: str = 'benchmark.yaml'
    write: Callable[[Commands], str] = launch_file
    package: str = ''
    release: str = ''
    watches: str | None = None
    arguments: str = ''
    path: Path | None = None

    def words(self, command: str) -> tuple[str, ...]:
        """Return the words of a command, with the program that was found."""
        path = str(self.path or self.program)
        words = command.split()
        return tuple(path if w == self.program else w for w in words)

    def launcher(self, *before: str, options: str = '') -> Launcher:
        """Return how to run it, with words before and options after it."""
        command = (*before, *self.words(f'{self.command} {options}'))
        return Launcher(command, b'', b'', file=self.file, write=self.write)


def dora_file(commands: Commands) -> str:
    """Return a data flow of dora whose nodes are shell commands."""
    nodes = [
        {'id': f'p{n}', 'path': 'shell', 'args': shlex.join(command)}
        for n, command in enumerate(commands)
    ]
    return json.dumps({'nodes': nodes})


def procfile(commands: Commands) -> str:
    """Return a Procfile."""
    lines = enumerate(map(shlex.join, commands))
    return ''.join(f'p{number}: {line}\n' for number, line in lines)


def process_compose_file(commands: Commands) -> str:
    """Return a file of process-compose that restarts what is edited."""
    entries = {}
    for number, command in enumerate(commands):
        folder, _, name = command[0].rpartition('/')
        watched = {'path': folder, 'include': [name]}
        entries[f'p{number}'] = {
            'command': shlex.join(command),
            'watch': {'paths': [watched]},
        }
    return json.dumps({'version': '0.5', 'processes': entries})


def better_launch_file(commands: Commands) -> str:
    """Return a launch file of better_launch."""
    return BETTER_LAUNCH.format(commands=commands)


PEERS = (
    Peer(
        'colcon launch',
        'colcon',
        'colcon launch {file}',
        'colcon launch --version',
        watches='--watch',
        arguments='colcon launch -s {file}',
    ),
    Peer(
        'ros2 launch',
        'ros2',
        'ros2 launch {file}',
        # there is no command that prints it
        'python3 -c print(__import__("importlib.metadata").metadata'
        '.version("launch"))',
        arguments='ros2 launch -s {file}',
    ),
    Peer(
        'play_launch',
        'play_launch',
        'play_launch launch {file}',
        'play_launch --version',
        package='play_launch',
    ),
    Peer(
        'better_launch',
        'bl',
        'python3 {file}',
        'bl --version',
        file='benchmark.launch.py',
        write=better_launch_file,
        package='better_launch',
    ),
    Peer(
        'process-compose',
        'process-compose',
        'process-compose up -t=false --no-server -f {file}',
        'process-compose version --short',
        write=process_compose_file,
        release=PROCESS_COMPOSE,
        watches='',
    ),
    Peer(
        'dora',
        'dora',
        'dora run --allow-shell-nodes {file}',
        'dora --version',
        write=dora_file,
        package='dora-rs-cli',
    ),
    Peer(
        'honcho',
        'honcho',
        'honcho -f {file} start',
        'honcho --version',
        file='Procfile',
        write=procfile,
        package='honcho',
    ),
)


def find(peer: Peer, folder: Path) -> Peer:
    """
    Return the launcher with its program, which may be installed for that.

    :raises FailedError: If it is missing and cannot be installed
    """
    where = folder / peer.name
    if peer.program == 'colcon':
        path = Path(sys.executable).with_name('colcon')
    elif found := shutil.which(peer.program):
        path = Path(found)
    elif peer.package:
        path = pip_install(peer.package, where) / peer.program
    elif peer.release:
        path = download(peer.release, peer.program, where)
    else:
        raise FailedError('not available here: not installed')
    return replace(peer, path=path)


def pip_install(package: str, folder: Path) -> Path:
    """Install a package; return the folder with its programs."""
    venv.create(folder, with_pip=True)
    programs = folder / 'bin'
    pip = [str(programs / 'pip'), '--disable-pip-version-check', '-q']
    ended = subprocess.run(
        [*pip, 'install', package], capture_output=True, check=False
    )
    if ended.returncode:
        raise FailedError('not available here: not installed, not on PyPI')
    return programs


def download(address: str, program: str, folder: Path) -> Path:
    """Download a `.tar.gz`; return the program that it contains."""
    folder.mkdir()
    archive = folder / 'archive'
    try:
        with urllib.request.urlopen(address, timeout=PATIENCE) as answer:
            archive.write_bytes(answer.read())
        with tarfile.open(archive) as opened:
            content = opened.extractfile(program)
            assert content is not None
            (folder / program).write_bytes(content.read())
    except (OSError, KeyError, tarfile.TarError) as e:
        text = 'not available here: not installed, no release downloaded'
        raise FailedError(text) from e
    (folder / program).chmod(0o755)
    return folder / program


def version(peer: Peer) -> str:
    """
    Return the version of a launcher that was found.

    :raises FailedError: If it does not start
    """
    ended = subprocess.run(
        peer.words(peer.version),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    if ended.returncode == 0:
        found = re.search(r'\d+\.\d+[\w.]*', ended.stdout)
        return found[0] if found else 'unknown'
    last = (ended.stderr.strip().splitlines() or ['no error message'])[-1]
    # the paths are those of a temporary folder
    reason = re.sub(r'\S*/', '', last)
    raise FailedError(f'installed, but does not start here: {reason}')
