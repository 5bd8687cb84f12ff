# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from colcon_yamllaunch.engine import limits, lines
from hypothesis import given
from hypothesis import strategies as st
import pytest

CHUNKS = st.lists(
    st.text(alphabet='ab\r\n', max_size=6).map(str.encode).filter(bool)
)


def test_a_progress_display_is_passed_on_as_it_comes():
    buffer = lines.LineBuffer()
    assert buffer.feed(b' 10%\r 20%') == b' 10%\r'
    assert buffer.feed(b'\r') == b''
    assert buffer.feed(b' 30%') == b' 20%\r'


def test_a_line_without_end_is_passed_on_in_pieces():
    buffer = lines.LineBuffer()
    chunk = b'x' * (1024 * 1024)
    passed = sum(len(buffer.feed(chunk)) for _ in range(40))
    assert passed >= 40 * len(chunk) - limits.LINE_BYTES


@given(CHUNKS)
def test_no_byte_is_lost_or_added(chunks):
    buffer = lines.LineBuffer()
    parts = [buffer.feed(c) for c in chunks]
    assert b''.join((*parts, buffer.flush())) == b''.join(chunks)
    assert all(p[-1:] in (b'', b'\n', b'\r') for p in parts)


@given(CHUNKS)
def test_lines_are_the_same_however_they_arrive(chunks):
    buffer = lines.LineBuffer()
    parts = [buffer.feed(c) for c in chunks]
    whole = b''.join(chunks)
    pieces = b''.join(
        lines.normalised(p) for p in (*parts, buffer.flush()) if p
    )
    assert pieces == lines.normalised(whole)


@pytest.mark.parametrize(
    ('data', 'expected'),
    [
        (b'a\nb\n', b'a\nb\n'),
        (b'a\r\nb\r\n', b'a\nb\n'),
        (b'a\r\r\n', b'a\n'),
        (b' 10%\r 20%\r\n', b' 10%\n 20%\n'),
        (b'\r 10%\r', b' 10%\n'),
        (b'\r', b''),
    ],
)
def test_each_line_ends_with_a_line_feed(data, expected):
    assert lines.normalised(data) == expected


@pytest.mark.parametrize('terminal', [True, False])
def test_invalid_bytes_are_shown_as_replacement_characters(terminal):
    assert lines.legible(b'a\xffb\n', terminal) == 'a\ufffdb\n'.encode()
    text = 'ä→日本\n'.encode()
    assert lines.legible(text, terminal) == text


@pytest.mark.parametrize(
    ('data', 'expected'),
    [
        (b'\x1b[1;31mred\x1b[0m\n', b'\x1b[1;31mred\x1b[0m\n'),
        (b'\x1b[2J\x1b[Hcleared\n', b'cleared\n'),
        (b'\x1b[?1049hscreen\n', b'screen\n'),
        (b'\x1b]0;title\x07text\n', b'text\n'),
        (b'\x1b]0;unfinished\n', '\ufffd]0;unfinished\n'.encode()),
        (b'\x0etab\there\x07\n', '\ufffdtab\there\ufffd\n'.encode()),
        ('\x9b2J\n'.encode(), '\ufffd2J\n'.encode()),
    ],
)
def test_a_terminal_gets_colours_but_nothing_that_harms_it(data, expected):
    assert lines.legible(data, True) == expected


def test_what_is_no_terminal_gets_what_was_written():
    data = b'\x1b[2J\x07\n'
    assert lines.legible(data, False) == data


def test_bare_text_has_no_colours():
    assert lines.bare(b'\x1b[31mred\x1b[0m \xff\r\n') == 'red \ufffd\n'


def test_each_line_gets_the_prefix():
    assert lines.prefixed(b'a\nb\n', b'[x] ') == b'[x] a\n[x] b\n'
    assert lines.prefixed(b'a\n\nb', b'[x] ') == b'[x] a\n[x] \n[x] b\n'
    assert lines.prefixed(b'\n', b'[x] ') == b'[x] \n'
    assert lines.prefixed(b'', b'[x] ') == b''


def test_a_line_with_colours_does_not_colour_the_next():
    assert lines.prefixed(b'\x1b[31ma\nb\n', b'- ', reset=True) == (
        b'- \x1b[31ma\x1b[0m\n- b\x1b[0m\n'
    )
    assert lines.prefixed(b'a\n', b'- ', reset=True) == b'- a\n'
