# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import errno
import os
from pathlib import Path
import signal
import subprocess
import sys

from colcon_yamllaunch.engine.spawn import (
    find_program,
    spawn_process,
    StartError,
)
import pytest


@pytest.fixture
def start(tmp_path):
    """Return a function that runs a program and returns its output."""

    def run(argv, environment=None, cwd=tmp_path):
        output = tmp_path / 'output'
        null = os.open(os.devnull, os.O_RDONLY)
        file = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        try:
            pid = spawn_process(
                argv,
                {'PATH': os.environ['PATH'], **(environment or {})},
                str(cwd),
                (null, file, file),
            )
        finally:
            os.close(null)
            os.close(file)
        assert os.waitpid(pid, 0)[1] == 0
        return output.read_text()

    return run


@pytest.fixture
def script(tmp_path):
    """Return a function that writes an executable file."""

    def write(content, mode=0o755, name='script'):
        path = tmp_path / name
        path.write_bytes(content)
        path.chmod(mode)
        return path

    return write


def test_signals_have_their_default_effect(start):
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGUSR1])
    try:
        text = start(['cat', '/proc/self/status'])
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGUSR1])
        signal.signal(signal.SIGINT, before)
    masks = dict(
        line.split(':\t') for line in text.splitlines() if 'Sig' in line
    )
    # 32 and 33 are the C library's own
    assert int(masks['SigIgn'], 16) & ~(3 << 31) == 0
    assert int(masks['SigBlk'], 16) == 0


def test_a_program_is_looked_up_in_the_path_of_the_process(start, script):
    path = script(b'#!/bin/sh\necho found\n', name='remote_only')
    folders = {'PATH': f'/nowhere:{path.parent}:/bin'}
    assert start([path.name], folders) == 'found\n'


def test_a_relative_program_is_relative_to_the_working_directory(
    start, script, tmp_path
):
    (tmp_path / 'sub').mkdir()
    script(b'#!/bin/sh\necho "$0"\n', name='sub/tool')
    assert start(['sub/tool']) == 'sub/tool\n'


def test_a_file_that_is_not_executable_does_not_hide_one_that_is(
    script, tmp_path
):
    for name in ('a', 'b'):
        (tmp_path / name).mkdir()
    script(b'', 0o644, 'a/tool')
    good = script(b'', 0o755, 'b/tool')
    path = f'{tmp_path}/a:{tmp_path}/b'
    assert find_program('tool', path) == str(good)


def refusal(start, *arguments, **more):
    with pytest.raises(StartError) as caught:
        start(*arguments, **more)
    text = str(caught.value)
    assert '\n' not in text
    return text


#: The content of a script, and what its refusal contains.
REFUSED_SCRIPTS = [
    (b'#!/no/such/python3 -u\n', ["'/no/such/python3'", 'first line']),
    (
        b'#!/usr/bin/env python9\n',
        ['first line of ', "'python9', which is not in the folders of PATH"],
    ),
    (b'print("hello")\n', ['#!/usr/bin/env python3']),
    (b'', ['is empty']),
    (b'\x7fELF' + b'\0' * 60, ['another kind of machine']),
]


@pytest.mark.parametrize(('content', 'expected'), REFUSED_SCRIPTS)
def test_refused_script_is_explained(start, script, content, expected):
    text = refusal(start, [str(script(content))])
    assert all(part in text for part in expected)


@pytest.mark.parametrize(
    ('argv', 'more', 'expected'),
    [
        (['no_such_program'], {}, 'PATH'),
        (['/no/such'], {}, '/no/such'),
        ([''], {}, 'empty'),
        (['/'], {}, 'folder'),
        (['true'], {'cwd': '/no/such/folder'}, "directory '/no/such/folder'"),
        (['echo', 'a\0b'], {}, 'arguments'),
        (['echo'], {'environment': {'A=B': 'x'}}, 'environment'),
    ],
)
def test_refused_command_is_explained(start, argv, more, expected):
    assert expected in refusal(start, argv, **more)
    assert Path.cwd().exists()


def test_a_script_that_is_not_executable(start, script):
    path = script(b'#!/bin/sh\n', 0o644)
    assert f'chmod +x {path}' in refusal(start, [str(path)])
    assert f'chmod +x {path}' in refusal(
        start, [path.name], {'PATH': str(path.parent)}
    )


@pytest.mark.parametrize('program', [b'/bin/sh', b'/usr/bin/env sh'])
def test_a_script_with_windows_line_ends(start, script, program):
    path = script(b'#!' + program + b'\r\necho\r\n')
    link = path.with_name('link')
    link.symlink_to(path)
    message = refusal(start, [str(link)])
    assert 'Windows' in message
    assert message.endswith(f"convert it: sed -i 's/\\r$//' {path}")


def test_refusal_names_what_an_installed_script_links_to(start, script):
    path = script(b'#!/usr/bin/env python9\n')
    installed = path.with_name('installed')
    installed.symlink_to(path)
    assert f"first line of '{path}'" in refusal(start, [str(installed)])


def test_a_program_without_its_loader(start, script, tmp_path):
    data = Path(sys.executable).resolve().read_bytes()
    loader = data[data.index(b'/lib') :].partition(b'\0')[0]
    broken = data.replace(loader, b'/nix' + loader[4:], 1)
    path = script(broken)
    assert 'loader' in refusal(start, [str(path)])


def test_a_dangling_link(start, tmp_path):
    (tmp_path / 'link').symlink_to('/no/such/target')
    assert 'a link' in refusal(start, ['./link'])


def test_other_errors_are_named_as_the_system_does(tmp_path):
    def spawn(*_, **__):
        raise OSError(errno.EAGAIN, 'Resource temporarily unavailable')

    with pytest.raises(StartError, match='temporarily unavailable'):
        spawn_process(['true'], {}, '/', (0, 1, 2), spawn)


def test_a_closed_standard_stream_does_not_confuse_anything(tmp_path):
    code = (
        'import os\n'
        'from colcon_yamllaunch.engine.spawn import close_on_exec_all\n'
        'os.close(0); os.close(1)\n'
        'close_on_exec_all()\n'
        'assert min(os.pipe()) > 2\n'
        'assert os.get_inheritable(0) and os.get_inheritable(1)\n'
    )
    subprocess.run([sys.executable, '-c', code], check=True)
