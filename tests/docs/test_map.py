# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The map that CONTRIBUTING.md opens with leads to what it says."""

from pathlib import Path
import re

import pytest

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / 'CONTRIBUTING.md').read_text(encoding='utf-8')
_SECTIONS = re.split(r'^## ', TEXT, flags=re.MULTILINE)
#: What is asked, a path, and what to search there.
ROWS = re.findall(
    r'^\| (.+\?.*) \| `([^`]+)`(?:: `([^`]+)`)? \|$',
    _SECTIONS[1],
    re.MULTILINE,
)
#: Where the paths may begin.
STARTS = (ROOT / 'colcon_yamllaunch', ROOT)


def test_the_map_comes_first_and_answers_twenty_questions() -> None:
    assert _SECTIONS[1].startswith('Map\n')
    assert len(ROWS) >= 20
    lines = re.findall(r'^\|', _SECTIONS[1], re.MULTILINE)
    assert len(lines) == len(ROWS) + len(['the heading', 'the rule'])


@pytest.mark.parametrize(('question', 'path', 'name'), ROWS)
def test_each_answer_leads_there(question: str, path: str, name: str) -> None:
    found = [start / path for start in STARTS if (start / path).exists()]
    assert found, path
    if name:
        text = found[0].read_text(encoding='utf-8')
        assert re.search(rf'\b{re.escape(name)}\b', text), name
