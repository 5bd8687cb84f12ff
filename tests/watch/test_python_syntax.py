# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Python files that do not compile."""

import os
from pathlib import Path
import sys

from colcon_yamllaunch.watch.python_syntax import compiles, source_error
import pytest

WRONG = b'x = 1\nprint(\n'


@pytest.mark.parametrize(
    ('name', 'text', 'expected'),
    [
        ('a.py', b'print(1)', True),
        ('a.py', WRONG, False),
        ('a.py', b'return', False),
        ('a.py', b'x = "\0"', False),
        ('a.py', b'\xff', False),
        ('a', b'#!/usr/bin/env python3\n' + WRONG, False),
        ('a', f'#!{sys.executable} -u\n'.encode() + WRONG, False),
        # no Python
        ('a', WRONG, True),
        ('a.py', b'#!/bin/sh\n' + WRONG, True),
        ('a.yaml', b'a: [', True),
    ],
)
def test_file_compiles_or_not(
    tmp_path: Path, name: str, text: bytes, expected: bool
) -> None:
    file = tmp_path / name
    file.write_bytes(text)
    assert compiles(str(file)) == expected
    error = source_error(str(file), os.environ)
    assert (error is None) == expected


def test_missing_file_is_no_error(tmp_path: Path) -> None:
    path = str(tmp_path / 'a.py')
    assert compiles(path)
    assert source_error(path, os.environ) is None


def test_syntax_error_has_its_position(tmp_path: Path) -> None:
    file = tmp_path / 'a.py'
    file.write_bytes(WRONG)
    error = source_error(str(file), os.environ)
    assert error is not None
    assert error.position is not None
    assert error.position.line == 2
    assert 'never closed' in error.message or 'EOF' in error.message


def test_python_that_runs_a_file_decides(tmp_path: Path) -> None:
    # one for which all is right
    python = tmp_path / 'python9'
    python.write_text('#!/bin/sh\n')
    python.chmod(0o755)
    file = tmp_path / 'a'
    file.write_bytes(b'#!/usr/bin/env -S python9 -u\n' + WRONG)
    assert not compiles(str(file))
    assert source_error(str(file), {'PATH': str(tmp_path)}) is None
    file.write_bytes(b'#!/usr/bin/env python0\n' + WRONG)
    assert source_error(str(file), {'PATH': str(tmp_path)}) is None
