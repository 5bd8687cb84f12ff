# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The page about the options says what the parsers know."""

from importlib.metadata import entry_points
from pathlib import Path
import re
import subprocess
import sys

import pytest

ROOT = Path(__file__).parents[3]
COMMAND = 'python tools/options_page.py'


@pytest.fixture(scope='module')
def page() -> str:
    done = subprocess.run(
        [sys.executable, *COMMAND.split()[1:]],
        cwd=ROOT,
        env={'PYTHONIOENCODING': 'utf-8', 'COLUMNS': '30'},
        stdout=subprocess.PIPE,
        check=True,
    )
    return done.stdout.decode()


def test_the_page_in_docs_is_not_stale(page: str) -> None:
    stored = (ROOT / 'docs/options.md').read_text(encoding='utf-8')
    assert stored == page, f'run: {COMMAND} > docs/options.md'


def test_every_verb_of_ours_is_described(page: str) -> None:
    ours = {
        entry.name
        for entry in entry_points(group='colcon_core.verb')
        if entry.value.startswith('colcon_yamllaunch.')
    }
    assert 'launch' in ours
    found = re.findall(r'^## colcon (\w+)$', page, re.MULTILINE)
    assert found == sorted(ours)


def test_options_are_described_as_they_are_written(page: str) -> None:
    assert '[`-s, --show-args`](#launch-show-args) | Show the laun' in page
    assert '[`--until REGEX`](#launch-until) | End with success' in page
    assert '[`--check [FORMAT]`](#launch-check) | ' in page


def test_each_option_has_an_anchor_of_its_own(page: str) -> None:
    anchors = re.findall(r'^\| <a id="([\w-]+)"></a>', page, re.MULTILINE)
    assert len(anchors) == len(re.findall(r'^\| .*`.*\|$', page, re.MULTILINE))
    assert len(anchors) == len(set(anchors))
    assert {'launch-watch', 'run-prefix', 'sweep-jobs'} <= set(anchors)


def test_a_table_has_as_many_cells_in_every_row(page: str) -> None:
    for table in re.findall(r'(?:^\|.*\n)+', page, re.MULTILINE):
        counts = {len(re.findall(r'(?<!\\)\|', r)) for r in table.splitlines()}
        assert counts == {3}, table
