# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What others wrote, made fit to be shown."""

import json

from colcon_yamllaunch.common.printable import (
    one_line,
    printable,
    printable_json,
)
import pytest

pytestmark = pytest.mark.hostile


@pytest.mark.parametrize(
    ('text', 'shown', 'in_line'),
    [
        ('plain', 'plain', 'plain'),
        ('ä → 日本', 'ä → 日本', 'ä → 日本'),
        ('a\n\tb', 'a\n\tb', r'a\n b'),
        ('a\r\nb\rc', 'a\ufffd\nb\ufffdc', r'a\nb\nc'),
        # colours, a move of the cursor, a title, half a sequence
        ('\x1b[31mred\x1b[0m', 'red', 'red'),
        ('a\x1b[2A\x1b[Kb', 'ab', 'ab'),
        ('a\x1b]0;title\x07b\x1b]8;;http://x\x1b\\c', 'abc', 'abc'),
        ('a\x1b(B\x1b[m\x1b>\x1b7b', 'ab', 'ab'),
        ('a\x1b[', 'a\ufffd[', 'a\ufffd['),
        ('a\x9b31mb\x7f\0', 'a\ufffd31mb\ufffd\ufffd', None),
        # what changes the order of reading, and other ends of lines
        ('a\u202eb\u2066c\u2069\u061c', 'a\ufffdb\ufffdc\ufffd\ufffd', None),
        ('a\u2028b\u2029c', 'a\ufffdb\ufffdc', None),
        # a byte of a name that is no UTF-8
        ('a\udcff', 'a\ufffd', None),
    ],
)
def test_text(text: str, shown: str, in_line: str | None) -> None:
    assert printable(text) == shown
    assert one_line(text) == (shown if in_line is None else in_line)
    assert printable(shown) == shown.replace('\r', '\ufffd')


def test_values_in_json_are_exact() -> None:
    value = {'ä\x1b\x7f\x9b': '日\u202e\u2028\n\udcff'}
    text = printable_json(json.dumps(value, ensure_ascii=False, indent=2))
    assert json.loads(text) == value
    assert text.replace('\n', '').isprintable()
    assert 'ä' in text
