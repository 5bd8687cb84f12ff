# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""docs/terminal.md has the keys that the terminal's own help has."""

from pathlib import Path
import re

from colcon_yamllaunch.terminal.keys import help_lines

PAGE = Path(__file__).parents[2] / 'docs/terminal.md'
TEXT = PAGE.read_text(encoding='utf-8')
#: Those with a row in the page: first what follows a process's key, then what
#: is for all.
DOCUMENTED = re.findall(r'^\| `(.)` \|', TEXT.split('\n## Keys\n')[1], re.M)
#: Those with a line in the help, some with several.
HELPED = {
    key
    for line in help_lines()
    for key in re.split(r'  +', line.strip())[0].split()
}


def test_the_page_has_the_keys() -> None:
    assert {'s', 'i', '/', 'q'} <= set(DOCUMENTED)
    assert set(DOCUMENTED) <= HELPED


def test_the_help_has_no_other_keys() -> None:
    letters = {key for key in HELPED if len(key) == 1 and key not in '1…Z'}
    assert {key for key in letters if f'`{key}`' not in TEXT} == set()
