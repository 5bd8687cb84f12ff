# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a user installs first has what all documented commands need."""

import configparser
from pathlib import Path
import re

import pytest

ROOT = Path(__file__).parents[2]
#: A command that installs this project, and its extras.
COMMAND = re.compile(
    r"pip install (?:--user )?'path/to/[\w-]+(?:/folder)?(?:\[(.*?)\])?'"
    r"|PIP_INSTALL\).* '\.\[(.*?)\]'"
)


@pytest.mark.parametrize(
    'name', ['README.md', 'docs/guide.md', 'docs/ci.md', 'Makefile']
)
def test_each_command_installs_the_common_extensions(name: str) -> None:
    text = (ROOT / name).read_text(encoding='utf-8')
    found = [a or b for a, b in COMMAND.findall(text)]
    # further commands of the Makefile add what tests and the site use
    commands = [extras for extras in found if extras not in ('test', 'docs')]
    assert commands
    for extras in commands:
        assert 'common' in extras.split(','), extras


def test_watch_and_ui_need_no_extra() -> None:
    configuration = configparser.ConfigParser()
    configuration.read(ROOT / 'setup.cfg', encoding='utf-8')
    required = configuration['options']['install_requires']
    names = set(re.findall(r'^[\w-]+', required, re.M))
    assert {'textual', 'watchfiles'} <= names


def test_entry_points_are_sorted() -> None:
    configuration = configparser.ConfigParser()
    configuration.read(ROOT / 'setup.cfg', encoding='utf-8')
    groups = dict(configuration['options.entry_points'])
    assert list(groups) == sorted(groups)
    for entries in groups.values():
        lines = entries.strip().splitlines()
        assert lines == sorted(lines)
