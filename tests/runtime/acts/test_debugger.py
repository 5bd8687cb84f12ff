# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which debugger a process is started under, and how."""

import sys

from colcon_yamllaunch.runtime.acts.debugger import debugged
from colcon_yamllaunch.runtime.core.tasks import RefusedError
import pytest


@pytest.fixture
def programs(tmp_path):
    """Return a folder with a gdb and some programs, which is PATH."""

    def write(name, first):
        (tmp_path / name).write_text(f'{first}\n')
        (tmp_path / name).chmod(0o755)

    write('gdb', '#!/bin/sh')
    write('python3', '#!/bin/sh')
    write('node', '#!/bin/sh')
    write('script', f'#!{sys.executable}')
    write('linked', '#!/usr/bin/env python3')
    return tmp_path


def argv_of(programs, process, *argv):
    made = process('a', *argv, cwd=str(programs))
    result = debugged(made, {'PATH': str(programs)})
    assert result.emulate_tty
    return [str(word).removeprefix(f'{programs}/') for word in result.argv]


def test_a_program_runs_under_gdb(programs, process):
    words = argv_of(programs, process, './node', '--flag')
    assert words == ['gdb', '-q', '--args', './node', '--flag']
    words = argv_of(programs, process, 'nothing')
    assert words == ['gdb', '-q', '--args', 'nothing']


@pytest.mark.parametrize(
    ('argv', 'expected'),
    [
        (['script', 'x'], [sys.executable, '-m', 'pdb', 'script', 'x']),
        (['./linked'], ['python3', '-m', 'pdb', './linked']),
        (['python3', 'x.py'], ['python3', '-m', 'pdb', 'x.py']),
        (['python3', '-m', 'x'], ['python3', '-m', 'pdb', '-m', 'x']),
    ],
)
def test_a_program_in_python_runs_under_pdb(programs, process, argv, expected):
    (programs / 'gdb').unlink()
    assert argv_of(programs, process, *argv) == expected


def test_options_of_python_are_for_gdb(programs, process):
    words = argv_of(programs, process, 'python3', '-c', 'pass')
    assert words == ['gdb', '-q', '--args', 'python3', '-c', 'pass']


def test_who_has_no_gdb_is_told_how_to_get_it(programs, process):
    (programs / 'gdb').unlink()
    with pytest.raises(RefusedError, match='a needs gdb') as caught:
        argv_of(programs, process, './node')
    assert str(caught.value).endswith(': sudo apt install gdb')
