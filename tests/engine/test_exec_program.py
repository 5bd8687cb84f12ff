# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Becoming another program: what it inherits, and why it may fail."""

from collections.abc import Callable
from pathlib import Path
import signal
import subprocess
import sys
from typing import Any

from colcon_yamllaunch.engine.spawn import exec_program, StartError
import pytest

#: Those that the C library keeps for itself; nobody else can change them.
LIBRARY_SIGNALS = 3 << 31
CODE = """\
import os, sys
from colcon_yamllaunch.engine.spawn import exec_program
log = open(os.devnull)
exec_program(sys.argv[1:], os.environ)
"""

Script = Callable[..., Path]


@pytest.fixture
def script(tmp_path: Path) -> Script:
    def write(text: str, mode: int = 0o755) -> Path:
        path = tmp_path / 'node'
        path.write_bytes(text.encode())
        path.chmod(mode)
        return path

    return write


def run(*argv: str, **settings: Any) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, '-c', CODE, *argv]
    settings = {'capture_output': True, 'text': True} | settings
    return subprocess.run(command, check=False, timeout=60, **settings)


def refusal(argv: list[str], path: str = '/usr/bin:/bin') -> str:
    with pytest.raises(StartError) as caught:
        exec_program(argv, {'PATH': path})
    return str(caught.value)


def ignored_signals(status: str) -> int:
    """Return the mask of what a process ignores, from its status file."""
    ignored = status.partition('SigIgn:')[2].split()[0]
    return int(ignored, 16) & ~LIBRARY_SIGNALS


def test_signals_are_as_a_shell_gives_them() -> None:
    assert ignored_signals(run('cat', '/proc/self/status').stdout) == 0


def test_signals_that_the_user_ignores_stay_ignored() -> None:
    code = (
        f'trap \'\' HUP; exec {sys.executable} -c "$0" cat /proc/self/status'
    )
    done = subprocess.run(
        ['sh', '-c', code, CODE], capture_output=True, text=True, check=True
    )
    assert ignored_signals(done.stdout) == 1 << signal.SIGHUP - 1


def test_descriptors_are_those_of_the_user(tmp_path: Path) -> None:
    with (tmp_path / 'file').open('w') as file:
        number = file.fileno()
        done = run('ls', '/proc/self/fd', pass_fds=[number])
    # one more is that of the folder which ls lists
    kept = set(map(int, done.stdout.split())) - {0, 1, 2}
    assert number in kept
    assert len(kept) == 2


def test_env_with_options_is_left_to_env(script: Script) -> None:
    path = script('#!/usr/bin/env -S sh -e\nexit 3\n')
    assert run(str(path)).returncode == 3


def test_first_line_that_names_nothing(script: Script) -> None:
    assert refusal([str(script('#!\nexit 3\n'))])
