# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What the tests of the host program share.

Its modules import one another from their folder.
"""

from collections.abc import Callable
from pathlib import Path
import sys
import textwrap

from colcon_yamllaunch import python_launch
import pytest
from support.talking_host import HEAD
from support.talking_host import Message
from support.talking_host import TalkingHost

FOLDER = Path(next(iter(python_launch.__path__)), 'worker')

# at the end: no other test is to find anything there
sys.path.append(str(FOLDER))


@pytest.fixture
def launch(
    talking_host: TalkingHost, tmp_path: Path
) -> Callable[[str], list[Message]]:
    """Return what visits a launch file, given what makes its description."""
    path = tmp_path / 'demo.launch.py'

    def launch(text: str) -> list[Message]:
        path.write_text(HEAD + textwrap.dedent(text))
        told = talking_host.visit(path)
        told += talking_host.ask('finish')
        return told

    return launch
