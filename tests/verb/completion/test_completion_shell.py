# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Tab in a real bash or fish, switched on as the documentation says."""

from collections.abc import Callable, Iterator
from pathlib import Path
import re
import shutil

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


@pytest.fixture
def fish(user: User) -> Callable[[str], list[str]]:
    """Return what fish offers behind a line."""
    program = shutil.which('fish')
    if program is None:
        pytest.skip('needs fish')
    user.package('alpha', LAUNCH)
    (command,) = re.findall(
        r'^    (register-.*fish .*)$', DOCUMENT.read_text(), re.M
    )

    def offered(line: str) -> list[str]:
        script = f'{command}; complete -C $argv[1]'
        shown = user.start(program, '--no-config', '-c', script, line)
        assert shown.end() == 0, shown.output
        return sorted(
            found
            for found in shown.output.splitlines()
            if not found.startswith('--mixin')
        )

    return offered


def test_fish_completes_each_word(fish: Callable[[str], list[str]]) -> None:
    assert fish('colcon launch ') == ['alpha']
    assert fish('colcon launch alpha ') == ['alpha.yaml']
    (argument,) = fish('colcon launch alpha alpha.yaml ')
    assert argument.startswith('mode:=\t')
    assert fish('colcon launch alpha alpha.yaml mode:=') == [
        *('mode:=fast', 'mode:=slow')
    ]
    (option,) = fish('colcon launch alpha alpha.yaml --no-bu')
    assert option.startswith('--no-build\t')


def test_line_is_typed_with_tab_in_fish(
    user: User, fish: Callable[[str], list[str]]
) -> None:
    home = Path(user.environment['HOME'])
    configuration = home / '.config/fish/config.fish'
    configuration.parent.mkdir(parents=True)
    text = DOCUMENT.read_text()
    (command,) = re.findall(r'^    (register-.*fish .*)$', text, re.M)
    configuration.write_text(
        f"{command}\nfunction fish_prompt; echo -n 'ready> '; end\n"
    )
    environment = user.environment | {
        'TERM': 'xterm',
        'XDG_CONFIG_HOME': str(home / '.config'),
        'XDG_DATA_HOME': str(home / '.local'),
    }
    terminal = Terminal(['fish', '-i'], user.root, environment, 100)
    try:
        terminal.shows('ready> ')
        terminal.types('colcon launch al\t').shows('alpha ')
        terminal.types('\t').shows('alpha.yaml')
        terminal.types('m\ts\t --show-args\r').shows("'mode':")
        terminal.types('exit\r')
        assert terminal.ends() == 0
    finally:
        terminal.close()
