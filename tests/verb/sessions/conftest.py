# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A user's further terminals, and nobody else's launches."""

from collections.abc import Callable, Iterator
import os
import signal

from colcon_yamllaunch.control.client import running_launches
import pytest
from support.terminal import Terminal
from support.user import User


@pytest.fixture
def second(user: User) -> Iterator[User]:
    """Return a user who sees no launches but those of this test."""
    user.environment['TMPDIR'] = str(user.root.parent)
    yield user
    # also one that was left running, whatever became of the test
    for launch in running_launches(user.environment, print):
        os.kill(launch.pid, signal.SIGTERM)
        launch.close()


@pytest.fixture
def terminal(second: User) -> Iterator[Callable[..., Terminal]]:
    """Return a function that runs `colcon launch` in a terminal."""
    terminals: list[Terminal] = []

    def start(*words: str) -> Terminal:
        size = {'TERM': 'xterm', 'COLUMNS': '100', 'LINES': '24'}
        # in a job there is no status block
        environment = second.environment | size | {'CI': ''}
        argv = ['colcon', 'launch', *words]
        terminals.append(Terminal(argv, second.root, environment))
        return terminals[-1]

    yield start
    for one in terminals:
        one.close()
