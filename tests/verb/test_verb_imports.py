# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""colcon imports the verb for every command, so that must cost nothing."""

import subprocess
import sys

import pytest

CODE = """\
import sys
from colcon_core import command
before = set(sys.modules)
import {name}
print(*sorted(set(sys.modules) - before))
"""


@pytest.mark.parametrize(
    'module',
    [
        'create',
        'environment_variables',
        'launch',
        'run',
        'sweep',
        'argv',
    ],
)
def test_importing_the_verb_imports_nothing_else(module: str) -> None:
    name = f'colcon_yamllaunch.verb.{module}'
    done = subprocess.run(
        [sys.executable, '-c', CODE.format(name=name)],
        capture_output=True,
        text=True,
        check=True,
    )
    parts = name.split('.')
    packages = ['.'.join(parts[:end]) for end in range(1, len(parts) + 1)]
    base = {'colcon_yamllaunch.verb.options_verb'}
    assert set(done.stdout.split()) - base == set(packages)
