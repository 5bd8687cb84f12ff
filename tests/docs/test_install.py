# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a user installs first has what all options need."""

from pathlib import Path
import re

import pytest

ROOT = Path(__file__).parents[2]
#: A command that installs this project, and its extras.
COMMAND = re.compile(
    r"pip install '?path/to/[\w-]+(?:/folder)?(?:\[(.*?)\])?"
    r"|PIP_INSTALL\).* '\.\[(.*?)\]'"
)


@pytest.mark.parametrize('name', ['README.md', 'docs/guide.md', 'Makefile'])
def test_the_first_command_brings_what_watch_and_ui_need(name: str) -> None:
    found = COMMAND.search((ROOT / name).read_text(encoding='utf-8'))
    assert found is not None
    extras = (found[1] or found[2] or '').split(',')
    assert {'watch', 'ui'} <= set(extras), found[0]
