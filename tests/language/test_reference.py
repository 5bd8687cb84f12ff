# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The reference page says what the tables say, and reads well."""

from pathlib import Path
import re
import subprocess
import sys

from colcon_yamllaunch.language.syntax.launch_tree import read_launch_file
from colcon_yamllaunch.language.vocabulary.actions import ACTIONS
from launch_files_page import reference_page
from support.language_fixtures import source

ROOT = Path(__file__).parents[2]
PAGE = reference_page()


def test_the_page_in_docs_is_not_stale() -> None:
    page = (ROOT / 'docs' / 'launch_files.md').read_text(encoding='utf-8')
    assert page == PAGE, (
        'run: python tools/launch_files_page.py > docs/launch_files.md'
    )


def test_the_module_writes_the_page() -> None:
    written = subprocess.run(
        [sys.executable, 'tools/launch_files_page.py'],
        cwd=ROOT,
        env={'PYTHONIOENCODING': 'utf-8', 'PYTHONPATH': str(ROOT)},
        stdout=subprocess.PIPE,
        check=True,
    )
    assert written.stdout.decode() == PAGE


def test_every_link_leads_to_a_heading() -> None:
    headings = re.findall(r'^#+ (.*)$', PAGE, re.MULTILINE)
    anchors = {
        re.sub(r'[^\w-]', '', h.lower().replace(' ', '-')) for h in headings
    }
    links = re.findall(r'\]\(#([^)]*)\)', PAGE)
    assert links
    assert set(links) <= anchors
    assert len(headings) == len(set(headings))


def test_every_launch_file_in_it_can_be_read() -> None:
    blocks = re.findall(
        r'^```yaml\n(.*?)^```$', PAGE, re.MULTILINE | re.DOTALL
    )
    assert len(blocks) > len(ACTIONS)
    for block in blocks:
        text = block if block.startswith('launch:') else 'launch:\n' + block
        assert read_launch_file(source(text)).problems == ()


def test_a_table_has_as_many_cells_in_every_row() -> None:
    for table in re.findall(r'(?:^\|.*\n)+', PAGE, re.MULTILINE):
        counts = {row.count(' |') for row in table.splitlines()}
        assert len(counts) == 1, table


def test_there_is_one_sentence_a_line() -> None:
    prose = re.sub(r'```.*?```', '', PAGE, flags=re.DOTALL)
    for line in prose.splitlines():
        if line and line[0] not in '|<#':
            assert not re.search(r'[a-z`)]\. [A-Z]', line), line
