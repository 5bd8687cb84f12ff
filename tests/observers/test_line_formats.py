# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import io

from colcon_yamllaunch.engine.events import Output
from colcon_yamllaunch.engine.writer import TextWriter
from colcon_yamllaunch.observers.log_files import Logs
from colcon_yamllaunch.observers.screen import (
    Layout,
    layout_of,
    Screen,
    SCREEN_FORMAT,
)
from hypothesis import given
from hypothesis import strategies as st
import pytest


def laid_out(value):
    """Return the layout for a value of the variable, and the complaints."""
    complaints = []
    environment = {SCREEN_FORMAT: value}
    return layout_of(SCREEN_FORMAT, environment, complaints.append), complaints


@pytest.mark.parametrize(
    ('text', 'line'),
    [
        ('[{levelname}] [{name}]: {msg}', '[INFO] [launch]: hello'),
        ('{message}', 'hello'),
        ('{created:.3f} {message}', '1732000000.250 hello'),
        ('{msecs:03.0f} {levelno} {message:>7}', '250 20   hello'),
        ('{name!r:.4} {{{message}}}', "'lau {hello}"),
        ('%s {message}', '%s hello'),
    ],
)
def test_format_has_the_fields_of_a_log_record(text, line):
    layout = Layout(text, now=lambda: 1732000000.25)
    assert layout('launch', 'INFO', 'hello') == line


def test_backslash_escapes_are_replaced():
    layout, complaints = laid_out(r'\x1b[1m{message}\033[0m\t\u2192 ä→')
    assert complaints == []
    assert layout('n', 'INFO', 'm') == '\x1b[1mm\x1b[0m\t→ ä→'


def test_alias_has_a_time_stamp():
    layout, complaints = laid_out('default_with_timestamp')
    assert complaints == []
    stamp, _, rest = layout('launch', 'ERROR', 'text').partition(' ')
    assert float(stamp) > 1e9
    assert rest == '[ERROR] [launch]: text'


@pytest.mark.parametrize('value', ['', 'default', None])
def test_default_needs_no_layout(value):
    assert laid_out(value) == (None, [])


@pytest.mark.parametrize(
    'value',
    [
        *('{message', 'message}', '{no_such_field}', '{created:d}'),
        *('{message.no_such}', '{}', '{0}', '%(message)s', 'no field'),
        *('open escape \\', '\\xZZ {message}'),
    ],
)
def test_invalid_format_is_ignored_with_warning(value):
    layout, (complaint,) = laid_out(value)
    assert layout is None
    assert SCREEN_FORMAT in complaint
    assert value in complaint
    assert '\n' not in complaint


PIECES = ['{message}', '{name}', '{', '}', '{{', '{msecs:', '!r', ':>9', '[0]']


@given(st.lists(st.sampled_from([*PIECES, '.a', 'ä', '%s', '\\', 'x41', ' '])))
def test_any_text_makes_a_layout_or_a_warning(pieces):
    text = ''.join(pieces)
    layout, complaints = laid_out(text)
    if text:
        assert (layout is None) == (len(complaints) == 1)
    if layout is not None:
        assert isinstance(layout('launch', 'INFO', 'text'), str)


@pytest.mark.parametrize(
    ('layout', 'name'), [(None, 'kitchen'), (Layout('{message}'), 'talker-1')]
)
def test_layout_uses_the_names_of_ros_2(process, tmp_path, layout, name):
    kitchen = process('kitchen', name='talker-1')
    said = Output(kitchen, 'stdout', b'hello\n')
    stream = io.StringIO()
    writer = TextWriter(stream)
    screen = Screen(
        writer, [kitchen], color=False, terminal=False, layout=layout
    )
    screen.handle(said)
    writer.flush()
    assert stream.getvalue().startswith(f'[{name}] ')
    logs = Logs(tmp_path, [kitchen], pytest.fail, layout=layout)
    logs.handle(said)
    logs.close()
    text = (tmp_path / 'launch.log').read_text()
    assert text.endswith(f' [{name}] hello\n')
