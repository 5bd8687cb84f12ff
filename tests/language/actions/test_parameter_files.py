# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The sections of files with parameters."""

import json
import os
import re

from colcon_yamllaunch.language.actions.parameter_files import (
    parameters_of,
    read_sections,
    Section,
)
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.vocabulary.parameter import to_json
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.position import Position
from hypothesis import given
from hypothesis import strategies as st
import pytest
from support.language_fixtures import source
import yaml

names = st.lists(st.sampled_from('ab'), min_size=1, max_size=4)
patterns = st.lists(
    st.sampled_from(['a', 'b', '*', '**']), min_size=1, max_size=4
)


def applies(pattern: str, node: str | None) -> bool:
    return Section(pattern, (), Position('', 1, 1)).applies_to(node)


@given(patterns, names)
def test_patterns_are_those_of_rclcpp(
    pattern: list[str], name: list[str]
) -> None:
    written = '/' + '/'.join(pattern)
    # rclcpp's parameter_map.cpp: "/*" is any part, "/**" any number of them
    expression = written.replace('/*', r'(/\w+)')
    wanted = re.fullmatch(expression, '/' + '/'.join(name)) is not None
    assert applies(written, '/' + '/'.join(name)) == wanted


@pytest.mark.parametrize(
    ('pattern', 'is_for_it'),
    [('/**', True), ('/*', False), ('/**/a', False), ('/a', False)],
)
def test_a_node_that_names_itself(pattern: str, is_for_it: bool) -> None:
    assert applies(pattern, None) == is_for_it


def test_a_file_without_sections_is_for_every_node() -> None:
    read = read_sections(source('a: 1\nb: {c: x}\n'))
    found = [(p.name, p.value) for p in read.parameters_of('/n')]
    assert found == [('a', 1), ('b.c', 'x')]
    assert read_sections(source('')).sections == ()


def test_aliases_and_merges() -> None:
    text = (
        'a: &a {ros__parameters: &p {x: 1, y: 2}}\nb: *a\n'
        'c: {ros__parameters: {<<: *p, y: 3}}\n'
    )
    read = read_sections(source(text))
    for name in 'ab':
        found = {p.name: p.value for p in read.parameters_of(f'/{name}')}
        assert found == {'x': 1, 'y': 2}
    found = {p.name: p.value for p in read.parameters_of('/c')}
    assert found == {'x': 1, 'y': 3}


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.text(max_size=3), inner, max_size=3)
    ),
    max_leaves=8,
)


@given(values)
def test_any_value_is_read_or_refused(value: object) -> None:
    text = yaml.safe_dump({'/**': {'ros__parameters': {'x': value}}})
    try:
        read = read_sections(source(text))
    except LaunchError as e:
        assert e.diagnostics[0].message
        return
    for parameter in read.parameters_of('/a/b'):
        assert parameter.name.startswith('x')
        assert parameter.value is not None
        text = to_json(parameter.value)
        if '.inf' not in text and '.nan' not in text:
            # none of them is taken for another type
            back = json.loads(text)
            assert repr(back) == repr(
                [*parameter.value]
                if isinstance(parameter.value, tuple)
                else parameter.value
            )


@given(st.text('/*:{}[],&< \nab1"-', max_size=40))
def test_any_text_is_read_or_refused(text: str) -> None:
    try:
        read = read_sections(source(text))
    except LaunchError as e:
        assert e.diagnostics[0].message
    else:
        for section in read.sections:
            assert section.applies_to('/a') in (True, False)


def test_a_limit_of_the_files_that_are_read(tmp_path):
    text = '/**: {ros__parameters: {%s: 1}}\n'
    for name in ('one', 'two', 'three'):
        (tmp_path / name).write_text(text % name)
    (tmp_path / 'big').write_text(text % 'big' + ' ' * 99)
    os.mkfifo(tmp_path / 'pipe')
    names = ('pipe', 'one', 'big', 'two', 'none', 'three')
    options = [word for name in names for word in ('--params-file', name)]
    process = Process(
        label='a',
        argv=('a', '--ros-args', *options),
        cwd=str(tmp_path),
        position=Position('/ws/demo.yaml', 1, 1),
    )

    def found(*limit):
        return [p.name for p in parameters_of(process, *limit)]

    assert found() == ['one', 'big', 'two', 'three']
    assert found(2 * len(text % 'two')) == ['one', 'two']
