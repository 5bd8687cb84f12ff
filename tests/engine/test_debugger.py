# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which debugger a process is started under, and how."""

import sys

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.engine.debugging import debugged
import pytest

PDB = ('-m', 'pdb')


@pytest.fixture
def programs(tmp_path):
    """Return a folder with a gdb and some programs, which is PATH."""

    def write(name, first):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(f'{first}\n')
        (tmp_path / name).chmod(0o755)

    write('gdb', '#!/bin/sh')
    write('python3', '\x7fELF')
    write('node', '\x7fELF')
    write('shim/python3', '#!/usr/bin/env bash')
    write('bash', '\x7fELF')
    write('wrapper', '#!/usr/bin/env bash')
    write('script', f'#!{sys.executable}')
    write('linked', '#!/usr/bin/env python3')
    return tmp_path


def argv_of(programs, process, *argv, path=''):
    made = process('a', *argv, cwd=str(programs))
    result = debugged(made, {'PATH': f'{path}{programs}'})
    assert result.emulate_tty
    words = [str(word).removeprefix(f'{programs}/') for word in result.argv]
    if 'gdb' in words:
        # its answers come before its next prompt
        assert words[:3] == ['sh', '-c', 'exec "$0" "$@" 2>&1']
        del words[:3]
    return words


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
        (['python3', '-S', 'x'], ['python3', '-S', '-m', 'pdb', 'x']),
        (
            ['python3', '-u', '-X', 'dev', '-Wce', '-m', 'x', '-c'],
            [*('python3', '-u', '-X', 'dev', '-Wce'), *PDB, '-m', 'x', '-c'],
        ),
    ],
)
def test_a_program_in_python_runs_under_pdb(programs, process, argv, expected):
    (programs / 'gdb').unlink()
    assert argv_of(programs, process, *argv) == expected


@pytest.mark.parametrize(
    'options', [['-c', 'pass'], ['-Sc', 'pass'], ['-mx'], ['-'], []]
)
def test_options_of_python_are_for_gdb(programs, process, options):
    words = argv_of(programs, process, 'python3', *options)
    assert words == ['gdb', '-q', '--args', 'python3', *options]


def test_gdb_gets_the_program_that_a_script_needs(programs, process):
    words = argv_of(programs, process, './wrapper', 'x')
    assert words == ['gdb', '-q', '--args', 'bash', './wrapper', 'x']
    shim = f'{programs}/shim:'
    words = argv_of(programs, process, 'python3', '-c', 'pass', path=shim)
    assert words[3:] == ['bash', 'shim/python3', '-c', 'pass']
    # pdb does without
    words = argv_of(programs, process, 'python3', 'x.py', path=shim)
    assert words == ['python3', '-m', 'pdb', 'x.py']


def test_who_has_no_gdb_is_told_how_to_get_it(programs, process):
    (programs / 'gdb').unlink()
    with pytest.raises(RefusedError, match='a needs gdb') as caught:
        argv_of(programs, process, './node')
    assert str(caught.value).endswith(': sudo apt install gdb')
