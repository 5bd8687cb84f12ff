# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The verbs where the shell has closed standard input or output."""

import subprocess

import pytest
from support.user import DEADLINE, User

#: Runs a command with a stream of its own closed.
CLOSED = 'exec "$@" {closed}'
LAUNCH = 'launch: [executable: {cmd: echo hello}]'


@pytest.mark.parametrize('closed', ['<&-', '>&-', '<&- >&-'])
@pytest.mark.parametrize(
    'words',
    [('launch', 'demo.yaml'), ('launch', '--help'), ('create', '--help')],
)
def test_a_closed_stream_is_no_harm(
    user: User, words: tuple[str, ...], closed: str
) -> None:
    user.write('demo.yaml', LAUNCH)
    done = subprocess.run(
        ['bash', '-c', CLOSED.format(closed=closed), 'bash', 'colcon', *words],
        cwd=user.root,
        env=user.environment,
        capture_output=True,
        text=True,
        timeout=DEADLINE,
    )
    assert done.returncode == 0
    assert done.stderr == ''
    assert bool(done.stdout) == ('>' not in closed)
