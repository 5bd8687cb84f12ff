# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Tab in a real interactive bash, switched on as the documentation says."""

from collections.abc import Iterator
from pathlib import Path
import re

import pytest
from support.terminal import Terminal
from support.user import User

DOCUMENT = Path(__file__).parents[3] / 'docs' / 'completion.md'
LAUNCH = """\
launch:
  - arg: {name: mode, default: fast, choice: [{value: fast}, {value: slow}]}
  - executable: {cmd: echo}
"""


@pytest.fixture
def bash(user: User) -> Iterator[Terminal]:
    user.package('alpha', LAUNCH)
    found = re.search(r'^    (eval .*)$', DOCUMENT.read_text(), re.M)
    assert found is not None
    environment = user.environment | {'PS1': 'ready> ', 'TERM': 'dumb'}
    terminal = Terminal(
        ['bash', '--norc', '--noprofile', '-i'], user.root, environment
    )
    try:
        terminal.shows('ready> ').types(f'{found[1]}\n').shows('ready> ', 2)
        yield terminal
    finally:
        terminal.close()


def test_a_line_is_typed_with_tab(bash: Terminal) -> None:
    bash.types('colcon launch al\t').shows('launch alpha ')
    bash.types('\t').shows('launch alpha alpha.yaml ')
    # no space behind it, and nothing twice
    bash.types('m\t').shows('alpha.yaml mode:=')
    bash.types('s\t').shows('mode:=slow ')
    bash.types('--no-bu\t').shows('mode:=slow --no-build ')
    bash.types('\x15exit\n')
    assert bash.ends() == 0


def test_choices_are_listed(bash: Terminal) -> None:
    bash.types('colcon launch alpha alpha mode:=\t\t').shows('fast  slow')
    bash.types('\x15exit\n')
    assert bash.ends() == 0
