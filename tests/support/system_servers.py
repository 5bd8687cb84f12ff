# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Servers of the system that tests start for themselves."""

from collections.abc import Mapping, Sequence
import os
from pathlib import Path
import shutil
import socket
import subprocess

#: Seconds; a loaded machine needs some.
_DEADLINE = 60


def program(name: str) -> str | None:
    """Return the path of a program that users may not have on PATH."""
    path = os.pathsep.join([os.environ['PATH'], '/usr/sbin', '/sbin'])
    return shutil.which(name, path=path)


def start_server(
    argv: Sequence[str | Path],
    environment: Mapping[str, str] | None = None,
    output: Path | None = None,
) -> 'subprocess.Popen[bytes]':
    """
    Start a server in a session of its own.

    It ends with the tests even if they are killed, where `setpriv` is there.

    :param output: A file for what it prints
    """
    tied = shutil.which('setpriv')
    prefix = [tied, '--pdeathsig', 'KILL'] if tied else []
    with (output or Path(os.devnull)).open('ab') as file:
        return subprocess.Popen(
            [*prefix, *argv],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=file,
            start_new_session=True,
        )


def run_quietly(
    words: Sequence[str | Path],
    environment: Mapping[str, str] | None = None,
    cwd: Path | None = None,
) -> 'subprocess.CompletedProcess[str]':
    """Run a command that asks nothing, and return what it printed."""
    return subprocess.run(
        words,
        cwd=cwd,
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=_DEADLINE,
        check=False,
    )


def reserved_port() -> socket.socket:
    """
    Return a socket whose port nobody else gets, but who asks for that one.

    It does not listen, so that a server may bind it as well (both have
    SO_REUSEADDR).
    """
    own = socket.socket()
    own.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    own.bind(('127.0.0.1', 0))
    return own
