# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Programs whose output goes through a buffer show a line when it ends."""

import os
import shutil
import struct
import sys

from colcon_yamllaunch.engine import events, limits, line_buffering
from colcon_yamllaunch.engine.line_buffering import (
    Elf,
    LineBuffering,
    read_elf,
    SilenceWatch,
)
from colcon_yamllaunch.engine.outcome import Outcome
import pytest
from support.test_loop import TestLoop

NEEDED = ('libstdc++.so.6', 'libc.so.6')
HERE, ELSEWHERE = b'here', b'elsewhere'
LIBRARY = '/usr/libexec/coreutils/libstdbuf.so'
BUFFERED = {'LD_PRELOAD': LIBRARY, '_STDBUF_O': 'L'}


@pytest.fixture
def files(monkeypatch):
    """Return compiled files by their paths, which is all that there is."""
    found = {
        LIBRARY: Elf(HERE, ('libc.so.6',)),
        '/lib/node': Elf(HERE, NEEDED),
        '/lib/sane': Elf(HERE, ('libasan.so.8', *NEEDED)),
        '/lib/alpine': Elf(HERE, ('libstdc++.so.6', 'libc.musl-x86_64.so.1')),
        '/lib/wide': Elf(ELSEWHERE, NEEDED),
        '/lib/static': Elf(HERE, ()),
        '/usr/bin/nice': Elf(HERE, ('libc.so.6',)),
    }
    programs = {'stdbuf': '/usr/bin/stdbuf', 'nice': '/usr/bin/nice'}

    def find(name, _path):
        if name not in programs:
            raise line_buffering.StartError(name)
        return programs[name]

    monkeypatch.setattr(line_buffering, 'read_elf', found.get)
    monkeypatch.setattr(line_buffering, 'find_program', find)
    monkeypatch.setattr(os.path, 'realpath', os.path.normpath)
    return found


@pytest.fixture
def variables(files, process):
    """Return a function that tells what a process gets, and what is held."""
    buffering = LineBuffering('/usr/bin')

    def tell(*argv, terminal=False, **environment):
        one = process('a', *argv, emulate_tty=terminal)
        found = buffering.variables(one, argv, environment)
        return found, buffering.holds_back(one), buffering.is_cpp(one)

    return tell


NOTHING = {}, False, False
HELD = {}, True, True


@pytest.mark.parametrize(
    ('argv', 'environment', 'expected'),
    [
        (['/lib/node'], {}, (BUFFERED, False, False)),
        (['nice', '/lib/node', '-x'], {}, (BUFFERED, False, False)),
        (['/lib/node'], {'LD_PRELOAD': ''}, (BUFFERED, False, False)),
        # they may hold lines back
        (['/lib/sane'], {}, HELD),
        (['nice', '/lib/sane'], {}, HELD),
        (['/lib/alpine'], {}, HELD),
        (['/lib/wide'], {}, HELD),
        # a library of the user stays alone
        (['/lib/node'], {'LD_PRELOAD': '/x.so'}, HELD),
        (['nice', 'x'], {'LD_PRELOAD': '/x.so'}, ({}, True, False)),
        # they need nothing
        (['/lib/script.py'], {}, NOTHING),
        (['/lib/static'], {}, NOTHING),
        (['missing'], {}, NOTHING),
        (['/lib/node'], {'terminal': True}, NOTHING),
        (['/lib/node'], {'COLCON_LAUNCH_LINE_BUFFERED': '0'}, NOTHING),
    ],
)
def test_programs_that_can_be_are_line_buffered(
    variables, argv, environment, expected
):
    assert variables(*argv, **environment) == expected


def test_without_the_library_lines_may_be_held_back(files, variables):
    del files[LIBRARY]
    assert variables('/lib/node') == ({}, True, True)


def test_a_library_that_cannot_be_named_is_none(files, variables):
    files['/usr/bin/../a b/libstdbuf.so'] = files.pop(LIBRARY)
    assert variables('/lib/node') == ({}, True, True)


def test_a_process_that_is_started_again_is_looked_at_again(files, variables):
    files['/lib/node'], before = files['/lib/sane'], files['/lib/node']
    assert variables('/lib/node') == ({}, True, True)
    files['/lib/node'] = before
    assert variables('/lib/node') == (BUFFERED, False, False)


def program(*, wide, order, names):
    """Return the start of a compiled program that needs libraries."""
    word = 'Q' if wide else 'I'
    strings = b'\0' + b''.join(name.encode() + b'\0' for name in names)
    places = [(1, strings.index(name.encode())) for name in names]
    entries = [(5, 0x4000), *places, (0, 0)]
    pack = struct.Struct(f'{order}2{word}').pack
    dynamic = b''.join(pack(*entry) for entry in entries)
    size = 56 if wide else 32
    start = 64
    body = start + 2 * size
    head = b'\x7fELF' + bytes([2 if wide else 1, 1 if order == '<' else 2])
    head = head.ljust(16, b'\0') + struct.pack(f'{order}HHI', 3, 62, 1)
    head += struct.pack(f'{order}3{word}I', 0, start, 0, 0)
    head += struct.pack(f'{order}3H', 52, size, 2)

    def segment(kind, offset, address, length):
        numbers = (offset, address, address, length, length)
        if wide:
            return struct.pack(f'{order}II6Q', kind, 0, *numbers, 8)
        return struct.pack(f'{order}8I', kind, *numbers, 0, 8)

    segments = segment(1, body, 0x4000, len(strings))
    segments += segment(2, body + len(strings), 0x5000, len(dynamic))
    return head.ljust(start, b'\0') + segments + strings + dynamic


@pytest.mark.parametrize('wide', [True, False])
@pytest.mark.parametrize('order', '<>')
def test_a_program_says_what_it_needs(tmp_path, wide, order):
    data = program(wide=wide, order=order, names=NEEDED)
    path = tmp_path / 'node'
    path.write_bytes(data)
    found = read_elf(str(path))
    assert found is not None
    assert found.needed == NEEDED
    # whatever is cut off, nothing goes wrong
    for length in range(0, len(data), 11):
        path.write_bytes(data[:length])
        read_elf(str(path))


def test_the_interpreter_is_read():
    found = read_elf(os.path.realpath(sys.executable))
    assert found is not None
    assert any(name.startswith('libc.') for name in found.needed)


def test_what_is_no_program_says_nothing(tmp_path):
    os.mkfifo(tmp_path / 'pipe')
    (tmp_path / 'text').write_text('#!/bin/sh\n')
    for name in ('pipe', 'text', 'missing', '.', 'nul\0'):
        assert read_elf(f'{tmp_path}/{name}') is None


def test_silence_is_reported_once(process):
    loop = TestLoop()
    told = []
    watch = SilenceWatch(lambda p: p.label in 'abc', loop, told.append)
    a, b, c, d = map(process, 'abcd')
    for one in (a, b, c, d):
        watch.handle(events.Started(one, 1))
    watch.handle(events.Output(a, 'stderr', b'text\n'))
    watch.handle(events.Exited(b, 1, Outcome(code=0), 1.0, False, False))
    loop.pass_time(limits.SILENCE_WARNING_DELAY)
    (silent,) = told
    assert silent == events.Silent(c, limits.SILENCE_WARNING_DELAY)
    assert '--tty' in silent.lines()[0]
    watch.handle(events.Started(b, 1))
    loop.pass_time(2 * limits.SILENCE_WARNING_DELAY)
    assert told == [silent]


@pytest.mark.skipif(
    not shutil.which('stdbuf'), reason='there is no stdbuf of coreutils'
)
def test_output_of_programs_in_c_shows_at_once(launch, sh):
    filtered = '(echo now; exec sleep 99) | cut -c1-'
    one = launch(
        sh('a', filtered),
        sh('b', filtered, environment={'COLCON_LAUNCH_LINE_BUFFERED': '0'}),
        sh('c', 'echo "$LD_PRELOAD|$_STDBUF_O"', emulate_tty=True),
    )
    one.shows('[a]      now').shows('[c]      |\n')
    assert '[b]      now' not in one.screen
