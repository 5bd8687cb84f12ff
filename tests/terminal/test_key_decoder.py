# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Keys of the bytes of terminals."""

from colcon_yamllaunch.terminal.keyboard import KeyDecoder
from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

# what is likely to be part of something
PIECES = st.one_of(
    st.binary(max_size=4),
    st.sampled_from([b'\x1b', b'\x1b[', b'\x1bO', b'1;5', b'~', b'A', b'3']),
    st.text(max_size=3).map(str.encode),
)


def keys_of(*pieces):
    decoder = KeyDecoder()
    keys = []
    for piece in pieces:
        keys += decoder.feed(piece)
    return decoder, keys


@pytest.mark.parametrize(
    ('data', 'keys'),
    [
        ('aZ7/', ['a', 'Z', '7', '/']),
        ('äπ漢', ['ä', 'π', '漢']),
        ('\r\n\t', ['enter', 'enter', 'tab']),
        ('\x01\x05\x1d', ['ctrl-a', 'ctrl-e', 'ctrl-]']),
        ('\x7f\x08', ['backspace', 'backspace']),
        ('\x1b[A\x1bOB\x1b[H\x1b[4~', ['up', 'down', 'home', 'end']),
        ('\x1b[3~\x1b[1;5C\x1b[1;3D', ['delete', 'ctrl-right', 'ctrl-left']),
        ('\x1b[1;2C', ['right']),
        ('\x1bb\x1b\x7f', ['alt-b', 'alt-backspace']),
        ('\x1b\x1b[A', ['esc', 'up']),
        # no keys here: the mouse, a function key, focus, a paste's marks
        ('\x1b[<0;3;4M\x1b[15~\x1b[I\x1b[200~x\x1b[201~', ['x']),
        ('\x9b\ufeff\x00', ['ctrl-@']),
    ],
)
def test_bytes_are_decoded_into_keys(data, keys):
    assert keys_of(data.encode())[1] == keys


def test_lone_escape_is_a_key_after_settle():
    decoder, keys = keys_of(b'\x1b')
    assert keys == []
    assert decoder.is_waiting
    assert list(decoder.settle()) == ['esc']
    assert not decoder.is_waiting
    assert list(decoder.settle()) == []


@settings(max_examples=40, deadline=None)
@given(st.lists(PIECES, max_size=12))
def test_split_bytes_decode_into_the_same_keys(pieces):
    whole, keys = keys_of(b''.join(pieces))
    split, same = keys_of(*pieces)
    assert keys == same
    assert list(whole.settle()) == list(split.settle())
    assert all(keys)
