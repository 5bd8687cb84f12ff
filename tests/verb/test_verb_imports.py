# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""colcon imports the verbs for every command, so that must cost nothing."""

import subprocess
import sys

CODE = """\
import sys
from colcon_core import command
before = set(sys.modules)
import {name}
print(*sorted(set(sys.modules) - before))
"""


def test_importing_the_verbs_imports_nothing_else() -> None:
    name = 'colcon_yamllaunch.verb.extensions'
    done = subprocess.run(
        [sys.executable, '-c', CODE.format(name=name)],
        capture_output=True,
        text=True,
        check=True,
    )
    parts = name.split('.')
    packages = ['.'.join(parts[:end]) for end in range(1, len(parts) + 1)]
    assert done.stdout.split() == sorted(packages)
