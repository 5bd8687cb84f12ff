# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""colcon imports the verb for every command, so that must cost nothing."""

import subprocess
import sys

CODE = """\
import sys
from colcon_core import command
before = set(sys.modules)
import colcon_yamllaunch.verb.launch
print(*sorted(set(sys.modules) - before))
"""


def test_importing_the_verb_imports_nothing_else() -> None:
    done = subprocess.run(
        [sys.executable, '-c', CODE],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == [
        'colcon_yamllaunch',
        'colcon_yamllaunch.verb',
        'colcon_yamllaunch.verb.launch',
    ]
