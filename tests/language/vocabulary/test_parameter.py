# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Parameter values: what a text is taken for, and what a node reads."""

import math

from colcon_yamllaunch.language.vocabulary.parameter import (
    coerce,
    infer,
    Parameter,
    parameter_file,
    ParameterTypeError,
    to_yaml,
)
from colcon_yamllaunch.plan.position import Position
from hypothesis import given
from hypothesis import strategies as st
import pytest
import yaml

# what YAML can say at all; a surrogate is no character
TEXTS = st.text(st.characters(exclude_categories=['Cs']))
INTS = st.integers(-(2**63), 2**63 - 1)
FLOATS = st.floats()
SCALARS = st.one_of(TEXTS, INTS, FLOATS, st.booleans())
LISTS = st.one_of(
    *(st.lists(kind) for kind in (TEXTS, INTS, FLOATS, st.booleans()))
)


def is_same(found, expected):
    if isinstance(expected, list):
        return len(found) == len(expected) and all(
            map(is_same, found, expected)
        )
    if type(found) is not type(expected):
        return False
    if isinstance(expected, float) and math.isnan(expected):
        return math.isnan(found)
    return found == expected


def content(value):
    return tuple(value) if isinstance(value, list) else value


def set_to(name, value):
    position = Position('launch.yaml', 1, 1)
    return Parameter(name, content(value), position).as_set()


@given(st.one_of(SCALARS, LISTS))
def test_a_value_comes_back(value):
    assert is_same(yaml.safe_load(to_yaml(content(value))), value)


@given(st.dictionaries(TEXTS, st.one_of(SCALARS, LISTS), max_size=5), TEXTS)
def test_a_file_of_parameters_comes_back(values, pattern):
    parameters = [set_to(n, v) for n, v in values.items()]
    loaded = yaml.safe_load(parameter_file(pattern, parameters).content)
    assert list(loaded) == [pattern]
    found = loaded[pattern]['ros__parameters'] or {}
    assert list(found) == list(values)
    assert all(is_same(found[name], values[name]) for name in values)


def test_of_two_values_the_last_counts():
    file = parameter_file('/**', [set_to('a', 1), set_to('a', 2)])
    loaded = yaml.safe_load(file.content)
    assert loaded == {'/**': {'ros__parameters': {'a': 2}}}


@pytest.mark.parametrize(
    ('value', 'expected'),
    [
        # a node's parser would take these for something else unquoted
        ('1e-3', '"1e-3"'),
        ('on', '"on"'),
        ('0x10', '"0x10"'),
        ('', '""'),
        ('a"b\\', '"a\\"b\\\\"'),
        ('é漢', '"é漢"'),
        ('\x85\u2028\ufeff', '"\\u0085\\u2028\\ufeff"'),
        ('\U000e0001', '"\\U000e0001"'),
        (True, 'true'),
        (1, '1'),
        (1.0, '1.0'),
        (1e300, '1.0e+300'),
        (1e-7, '1.0e-07'),
        (float('-inf'), '-.inf'),
        (float('nan'), '.nan'),
        ((1, 2), '[1, 2]'),
        (('a', 'b'), '["a", "b"]'),
        ((), '[]'),
    ],
)
def test_to_yaml(value, expected):
    assert to_yaml(value) == expected


@pytest.mark.parametrize(
    ('text', 'expected'),
    [
        ('a', 'a'),
        ('', ''),
        (' ', None),
        ('a b', 'a b'),
        ('5', 5),
        (' 5 ', 5),
        ('010', 8),
        ('1.5', 1.5),
        ('1e-3', '1e-3'),
        ('.5', 0.5),
        ('true', True),
        ('Yes', True),
        ('"5"', '5'),
        ("'a: b'", 'a: b'),
        ('[1, 2]', (1, 2)),
        ('[a, b]', ('a', 'b')),
        ('[true, no]', (True, False)),
        ('[]', ()),
        ('text\n', 'text'),
        ('/ns/topic', '/ns/topic'),
        ('http://x:8080/y', 'http://x:8080/y'),
        ('a#b', 'a#b'),
        ('[1, 2.0]', None),
        ('[1, a]', None),
        ('[[1]]', None),
        ('[~]', None),
        ('{a: 1}', None),
        ('a: b', None),
        ('~', None),
        ('2020-01-01', None),
        ('[1', None),
        ('\ta', None),
        ('@a', None),
        ('*a', None),
        ('[' * 1000, None),
    ],
)
def test_infer(text, expected):
    if expected is None:
        with pytest.raises(ParameterTypeError):
            infer(text)
        return
    found = infer(text)
    assert found == expected
    assert type(found) is type(expected)


# PyYAML takes the line ends of Unicode for white space; here they stay
@given(st.text(st.characters(exclude_categories=['Cs', 'Zl', 'Zp', 'Cc'])))
def test_infer_agrees_with_yaml(text):
    try:
        loaded = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError):
        # PyYAML has a type for '=', but no value; here it is a text
        loaded = '=' if text == '=' else None
    try:
        found = infer(text)
    except ParameterTypeError:
        # a mapping, a date, nothing, or a list of them
        assert not isinstance(loaded, str | int | float | bool)
        return
    if isinstance(found, tuple):
        found = list(found)
    # nothing at all stays a text, as in ROS 2
    assert is_same(found, loaded if text else '')


@pytest.mark.parametrize(
    ('text', 'kind', 'expected'),
    [
        ('5', 'str', '5'),
        (' a: b\n', 'str', ' a: b\n'),
        ('5', 'int', 5),
        (' 5\n', 'int', 5),
        ('5.0', 'int', None),
        ('a', 'int', None),
        ('5', 'float', 5.0),
        ('1e-3', 'float', 0.001),
        ('inf', 'float', float('inf')),
        ('a', 'float', None),
        ('1', 'bool', True),
        ('off', 'bool', False),
        ('2', 'bool', None),
        ('', 'bool', None),
        ('5', 'yaml', 5),
        ('[a]', 'yaml', ('a',)),
        ('{', 'yaml', None),
    ],
)
def test_coerce(text, kind, expected):
    if expected is None:
        with pytest.raises(ParameterTypeError):
            coerce(text, kind)
        return
    found = coerce(text, kind)
    assert found == expected
    assert type(found) is type(expected)


def test_long_values_are_shown_in_part():
    with pytest.raises(ParameterTypeError) as raised:
        coerce('x' * 500, 'int')
    assert len(str(raised.value)) < 100
