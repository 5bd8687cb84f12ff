# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The help of `colcon launch` on a terminal of 80 columns."""

from pathlib import Path
import re

import pytest
from support.user import User

PAGE = Path(__file__).parents[2] / 'docs/options.md'
DAILY = {
    'positional arguments': [],
    'options': ['--help', '--version', '--help-all', '--demo'],
    'Looking without running': ['--show-args', '--check', '--plan'],
    'Building': ['--no-build'],
    'Watching files': ['--watch'],
    'Ending by itself, as in CI': ['--until'],
    'Running launches': ['--status', '--stop', '--restart', '--logs'],
}
TITLES = [
    'positional arguments',
    'options',
    'Looking without running',
    'Building',
    'What is shown and kept',
    'Running',
    'Watching files',
    'Other machines',
    'Start at boot',
    'Ending by itself, as in CI',
    'Running launches',
]


def shown(user: User, *words: str) -> dict[str, list[str]]:
    """Return the options below each title, those of other plug-ins too."""
    user.environment['COLUMNS'] = '80'
    text = user.launch(*words)
    assert max(map(len, text.splitlines())) <= 80
    _, *parts = re.split(r'^(\w.*):$', text, flags=re.MULTILINE)
    found = dict(zip(parts[::2], parts[1::2], strict=True))
    examples = found.pop('examples').split('\n')[1:-1]
    assert examples[0] == '  colcon launch my_pkg demo.yaml'
    assert all(line.startswith('  colcon launch ') for line in examples)
    return {
        title: re.findall(r'^  (?:-\w(?: \w+)?, )?(--[\w-]+)', part, re.M)
        for title, part in found.items()
    }


@pytest.mark.parametrize('words', [('--help',), ('pkg', 'file', '-h')])
def test_help_shows_daily_options_in_groups(
    user: User, words: tuple[str, ...]
) -> None:
    found = shown(user, *words)
    assert {title: found[title] for title in DAILY} == DAILY
    assert list(found)[: len(DAILY)] == list(DAILY)


@pytest.mark.parametrize('words', [('--help-all',), ('pkg', '--help-all')])
def test_help_all_shows_all_options(
    user: User, words: tuple[str, ...]
) -> None:
    before = list(user.root.iterdir())
    found = shown(user, *words)
    assert list(found)[: len(TITLES)] == TITLES
    page = PAGE.read_text(encoding='utf-8')
    documented = page.split('## colcon ')[2]
    assert [o for title in TITLES for o in found[title]] == re.findall(
        r'^\| [^`]*`(?:-\w, )?(--[\w-]+)', documented, re.M
    )
    assert list(user.root.iterdir()) == before
