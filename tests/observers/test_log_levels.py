# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The levels of lines."""

from colcon_yamllaunch.observers.log_levels import Level, level_of
import pytest


@pytest.mark.parametrize(
    ('line', 'level'),
    [
        ('[INFO] [1732000000.123456789] [counter]: one', Level.INFO),
        ('\x1b[33m[WARN] [1732000000.1] [a.b]: low\x1b[0m', Level.WARN),
        ('[DEBUG] [1.2] [a]: [ERROR] is only quoted', Level.DEBUG),
        ('\x1b[31m[\x1b[1mERROR\x1b[0m] x', Level.ERROR),
        ('1732000000.1 [FATAL] [a]: x', Level.FATAL),
        ('WARNING: deprecated', Level.WARN),
        ('  ERROR something', Level.ERROR),
        ('[CRITICAL] x', Level.FATAL),
        ('Traceback (most recent call last):', Level.ERROR),
        ("terminate called after throwing an instance of 'x'", Level.ERROR),
        ('WARNINGS are counted', None),
        ('an ERROR in the middle', None),
        ('the [state] is [INFORMED]', None),
        ('[' + 'x' * 200 + '[INFO] too far', None),
        ('', None),
    ],
)
def test_the_level_of_a_line(line, level):
    assert level_of(line.encode()) is level
    assert level_of(line.encode() + b'\n') is level


@pytest.mark.parametrize(
    ('form', 'line', 'level'),
    [
        ('{time} {name} {severity}: {message}', '1.2 a WARN: x', Level.WARN),
        ('{name}|{severity}|{message}', 'a.b|ERROR|x', Level.ERROR),
        ('({severity}) {message}', '(FATAL) x', Level.FATAL),
        ('({severity}) {message}', '\x1b[31m(FATAL) x\x1b[0m', Level.FATAL),
        # without the level, what looks as usual counts
        ('{message}', '[WARN] x', Level.WARN),
        ('{message}', 'x', None),
        ('({severity}) {message}', 'printed', None),
    ],
)
def test_the_level_of_a_line_of_another_form(form, line, level):
    assert level_of(line.encode(), form) is level


@pytest.mark.parametrize('line', ['[a] ' * 20_000, '\x1b[m' * 20_000])
def test_a_line_that_is_almost_of_a_form(line):
    # what tries all places where its fields may end takes for ever
    form = '{a}[{b}] [{c}] [{d}] [{e}] {f}{severity}: {message}'
    assert level_of(line.encode(), form) is None
    assert level_of(b'[1] [2] [3] [4]] [5] x WARN', form) is Level.WARN
