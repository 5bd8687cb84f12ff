# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a program looks at is told, and all else it does is refused."""

import json
from pathlib import Path
import subprocess
import sys

from colcon_yamllaunch.workspace.environment import traced_python
import pytest

pytestmark = pytest.mark.full


def run(folder: Path, text: str) -> 'subprocess.CompletedProcess[str]':
    """Run a program in the folder `folder`."""
    program = folder / 'program.py'
    program.write_text(text)
    return subprocess.run(
        [sys.executable, traced_python.__file__, program, 'an argument'],
        capture_output=True,
        text=True,
    )


LOOKS = (
    'open(path)',
    'os.path.exists(path)',
    'os.path.isfile(path)',
    'os.path.isdir(path)',
    'os.path.islink(path)',
    'os.path.getsize(path)',
    'os.path.realpath(path)',
    'Path(path).exists()',
    'Path(path).is_file()',
    'Path(path).is_dir()',
    'Path(path).read_text()',
    'Path(path).read_bytes()',
    'Path(path).stat()',
    'list(Path(path).iterdir())',
)


@pytest.mark.parametrize('kind', ['file', 'folder', 'nothing'])
def test_each_way_to_look_is_told(tmp_path: Path, kind: str) -> None:
    text = 'import os\nfrom pathlib import Path\nimport sys\n'
    looked_at = [tmp_path / f'thing {n}' for n in range(len(LOOKS))]
    for path, look in zip(looked_at, LOOKS, strict=True):
        if kind == 'file':
            path.write_text('content')
        elif kind == 'folder':
            path.mkdir()
        text += f'path = {str(path)!r}\n'
        text += f'try:\n    {look}\nexcept OSError:\n    pass\n'
    done = run(tmp_path, f'{text}print(sys.argv[1:])\n')
    assert done.returncode == 0, done.stderr
    paths, printed = json.loads(done.stdout)
    assert [p for p in map(str, looked_at) if p not in paths] == []
    assert printed == "['an argument']\n"


@pytest.mark.parametrize(
    'text',
    [
        'import time\nprint(time.time())',
        'import random',
        'from datetime import datetime',
        'import subprocess',
        'from os import getpid',
        'import os\nprint(os.getpid())',
        'import os\nos.system("true")',
        'import os\nos.stat("/")',
        '__import__("socket")',
        'open("/proc/self/stat")',
        'open("relative")',
        'open(0)',
        'open("/tmp/new", "a")',
        'from pathlib import Path\nPath("/nowhere/x").mkdir()',
        'from pathlib import Path\nPath("/nowhere/x").touch()',
        'import sys\nsys.exit(1)',
        'boom = 1 / 0',
        'if',
    ],
)
def test_program_that_does_more_is_refused(tmp_path: Path, text: str) -> None:

    assert run(tmp_path, text).returncode != 0


def test_modules_are_those_that_the_program_would_find(tmp_path: Path) -> None:
    (tmp_path / 'argparse.py').write_text('NAME = "own"\n')
    done = run(tmp_path, 'import argparse\nprint(argparse.NAME)\n')
    assert json.loads(done.stdout)[1] == 'own\n'
