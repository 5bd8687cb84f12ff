# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files as they lie on a disk."""

import codecs
import os

from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.source_text import (
    MAXIMUM_FILE_SIZE,
    read_source,
)
import pytest

TEXT = 'launch: [] # é 漢\n'


def read(tmp_path, data):
    path = tmp_path / 'demo.yaml'
    path.write_bytes(data)
    return read_source(str(path), 'name')


def problem(tmp_path, data):
    with pytest.raises(LaunchError) as raised:
        read(tmp_path, data)
    return raised.value.diagnostics[0]


@pytest.mark.parametrize(
    'data',
    [
        TEXT.encode(),
        codecs.BOM_UTF8 + TEXT.encode(),
        codecs.BOM_UTF16_LE + TEXT.encode('utf-16-le'),
        codecs.BOM_UTF16_BE + TEXT.encode('utf-16-be'),
    ],
)
def test_encodings(tmp_path, data):
    assert read(tmp_path, data).text == TEXT


def test_latin_1_is_an_error(tmp_path):
    diagnostic = problem(tmp_path, 'launch:\n# é\n'.encode('latin-1'))
    assert '0xe9' in diagnostic.message
    assert (diagnostic.position.line, diagnostic.position.column) == (2, 3)
    assert 'UTF-8' in diagnostic.hint


@pytest.mark.parametrize(
    ('text', 'name'),
    [('\0', 'U+0000'), ('\x1b', 'U+001B'), ('\x7f', 'U+007F')],
)
def test_control_characters_are_errors(tmp_path, text, name):
    diagnostic = problem(tmp_path, f'a:\n b{text}'.encode())
    assert name in diagnostic.message
    assert (diagnostic.position.line, diagnostic.position.column) == (2, 3)


@pytest.mark.parametrize('tail', [b'', b'\0', b'\xd8', b'\0\xd8'])
def test_broken_utf_16_is_an_error(tmp_path, tail):
    problem(tmp_path, codecs.BOM_UTF16_LE + b'a\0\0\xd8' + tail)


def test_missing_file(tmp_path):
    with pytest.raises(LaunchError, match=r'cannot read launch file .*nope'):
        read_source(str(tmp_path / 'nope'), 'name')


def test_folder(tmp_path):
    with pytest.raises(LaunchError, match='cannot read launch file'):
        read_source(str(tmp_path), 'name')


def test_too_large_a_file_is_not_read(tmp_path):
    path = tmp_path / 'large.yaml'
    with path.open('wb') as file:
        os.truncate(file.fileno(), MAXIMUM_FILE_SIZE + 1)
    with pytest.raises(LaunchError, match='the limit is'):
        read_source(str(path), 'name')


def test_a_path_that_no_file_can_have():
    with pytest.raises(LaunchError, match='cannot read launch file'):
        read_source('a\0b', 'name')
