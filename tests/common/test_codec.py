# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Dataclasses as JSON and back, and data of others that is refused."""

from collections.abc import Mapping
from dataclasses import dataclass as mutable_dataclass
from dataclasses import field, replace
import json
import math
from typing import Any, Literal, NamedTuple

from colcon_yamllaunch.common.codec import (
    Codec,
    CodecError,
    from_json,
    only,
    read_float,
    to_json,
)
from colcon_yamllaunch.common.frozen import dataclass
from hypothesis import given
from hypothesis import strategies as st
import pytest


class Size(NamedTuple):
    width: int
    height: int = 1


@dataclass(frozen=True, slots=True)
class Leaf:
    name: str


@dataclass(frozen=True, slots=True)
class Node:
    children: 'tuple[Leaf | Node, ...]' = ()


@dataclass(frozen=True, slots=True)
class Everything:
    text: str
    number: int
    ratio: float
    flag: bool
    leaf: Leaf
    anything: Any = None
    maybe: str | None = None
    maybe_leaf: Leaf | None = None
    mixed: str | int | Leaf = ''
    level: Literal['low', 'high', 3] = 'low'
    leaves: tuple[Leaf, ...] = ()
    pair: tuple[str, Leaf] = ('', Leaf(''))
    size: Size = Size(1, 2)
    names: frozenset[str] = frozenset()
    table: Mapping[str, Leaf] = field(default_factory=dict)
    sizes: dict[str, list[Size]] = field(default_factory=dict)
    for_: int = 0


@mutable_dataclass
class Counter:
    count: int = 0


WHOLE = Everything(
    text='a',
    number=1,
    ratio=0.5,
    flag=True,
    leaf=Leaf('b'),
    anything=[1, {'a': None}],
    maybe='c',
    maybe_leaf=Leaf('d'),
    mixed=Leaf('e'),
    level=3,
    leaves=(Leaf('f'), Leaf('g')),
    pair=('h', Leaf('i')),
    size=Size(3, 4),
    names=frozenset('zyx'),
    table={'j': Leaf('k')},
    sizes={'l': [Size(5, 6)]},
    for_=7,
)
TREES = Codec({Leaf: 'leaf', Node: 'node'}, tag='kind')


def test_each_type_of_field_is_written_and_read_again():
    data = to_json(WHOLE)
    assert data == {
        'text': 'a',
        'number': 1,
        'ratio': 0.5,
        'flag': True,
        'leaf': {'name': 'b'},
        'anything': [1, {'a': None}],
        'maybe': 'c',
        'maybe_leaf': {'name': 'd'},
        'mixed': {'name': 'e'},
        'level': 3,
        'leaves': [{'name': 'f'}, {'name': 'g'}],
        'pair': ['h', {'name': 'i'}],
        'size': [3, 4],
        'names': ['x', 'y', 'z'],
        'table': {'j': {'name': 'k'}},
        'sizes': {'l': [[5, 6]]},
        'for': 7,
    }
    assert list(data) == [name.rstrip('_') for name in WHOLE.__slots__]
    assert from_json(Everything, json.loads(json.dumps(data))) == WHOLE


def test_missing_fields_have_their_defaults():
    least = Everything('', 0, 0.0, False, Leaf(''))
    required = ('text', 'number', 'ratio', 'flag', 'leaf')
    data = {name: to_json(least)[name] for name in required}
    assert from_json(Everything, data) == least
    assert from_json(Counter, {}) == Counter()


def test_whole_number_is_read_as_a_float():
    value = from_json(Everything, {**to_json(WHOLE), 'ratio': 2}).ratio
    assert (value, type(value)) == (2.0, float)


@pytest.mark.hostile
@pytest.mark.parametrize(
    ('changes', 'problem'),
    [
        ({'text': 1}, 'it.text is not of the type str'),
        ({'text': None}, 'it.text is not of the type str'),
        ({'number': True}, 'it.number is not of the type int'),
        ({'number': 1.0}, 'it.number is not of the type int'),
        ({'number': 1 << 63}, 'it.number is too large a number'),
        ({'ratio': '1'}, 'it.ratio is not of the type float'),
        ({'ratio': False}, 'it.ratio is not of the type float'),
        ({'ratio': math.nan}, 'it.ratio is not a finite number'),
        ({'ratio': -math.inf}, 'it.ratio is not a finite number'),
        ({'ratio': 10**400}, 'it.ratio is not a finite number'),
        ({'flag': 1}, 'it.flag is not of the type bool'),
        ({'leaf': []}, 'it.leaf is not an object'),
        ({'leaf': {}}, 'it.leaf.name is missing'),
        ({'leaf': {'name': 1}}, 'it.leaf.name is not of the type str'),
        ({'leaf': {'name': '', 'b': 1}}, "it.leaf has an unknown field 'b'"),
        ({'maybe': 1}, 'it.maybe is not of the type str'),
        ({'maybe_leaf': 1}, 'it.maybe_leaf is not an object'),
        ({'mixed': 1.5}, 'it.mixed is not a str or a int or a leaf'),
        ({'level': 'up'}, "it.level is not 'low' or 'high' or 3"),
        ({'level': 3.0}, "it.level is not 'low' or 'high' or 3"),
        ({'level': []}, "it.level is not 'low' or 'high' or 3"),
        ({'leaves': {}}, 'it.leaves is not a list'),
        ({'leaves': [{'name': ''}, 1]}, 'it.leaves[1] is not an object'),
        ({'pair': ['']}, 'it.pair does not have 2 values'),
        ({'pair': ['', 1]}, 'it.pair[1] is not an object'),
        ({'size': []}, 'it.size does not have 2 values'),
        ({'size': [1, 2, 3]}, 'it.size does not have 2 values'),
        ({'names': 'abc'}, 'it.names is not a list'),
        ({'names': [[]]}, 'it.names[0] is not of the type str'),
        ({'table': []}, 'it.table is not an object'),
        ({'table': {'\x1b[2J': 1}}, 'it.table. is not an object'),
        ({'sizes': {'a': [[1, 2], []]}}, 'it.sizes.a[1] does not have 2'),
        ({'\x1b[2Jx': 1}, "it has an unknown field 'x'"),
        ({'for_': 1}, "it has an unknown field 'for_'"),
    ],
)
def test_error_names_the_field(changes: dict[str, Any], problem: str) -> None:
    with pytest.raises(CodecError) as caught:
        from_json(Everything, {**to_json(WHOLE), **changes}, 'it')
    assert str(caught.value).startswith(problem)


@pytest.mark.hostile
@given(
    st.sampled_from(sorted(to_json(WHOLE))),
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
        lambda inner: (
            st.lists(inner) | st.dictionaries(st.text(max_size=4), inner)
        ),
        max_leaves=8,
    ),
)
def test_any_value_is_read_or_refused(name, value):
    data = {**to_json(WHOLE), name: value}
    try:
        read = from_json(Everything, data)
    except CodecError as error:
        assert len(str(error)) < 200
        assert '\x1b' not in str(error)
    else:
        if name != 'anything':
            assert from_json(Everything, to_json(read)) == read


def test_tag_names_the_class_of_one_of_several():
    tree = Node((Leaf('a'), Node((Leaf('b'),))))
    data = TREES.to_json(tree)
    assert data == {
        'kind': 'node',
        'children': [
            {'kind': 'leaf', 'name': 'a'},
            {'kind': 'node', 'children': [{'kind': 'leaf', 'name': 'b'}]},
        ],
    }
    assert TREES.from_json(Node, data) == tree
    for child in ({'kind': 'twig'}, {'kind': []}, {'name': 'a'}, 1, None):
        with pytest.raises(CodecError, match='is not a leaf or a node'):
            TREES.from_json(Node, {'children': [child]})


@pytest.mark.hostile
def test_deep_nesting_is_refused():
    data: dict[str, Any] = {'kind': 'node'}
    for _ in range(5000):
        data = {'kind': 'node', 'children': [data]}
    with pytest.raises(CodecError, match='nested too deeply'):
        TREES.from_json(Node, data)


def test_several_dataclasses_without_tags_are_a_mistake():
    with pytest.raises(TypeError, match='tags'):
        from_json(Node, {})


def test_special_types_are_written_and_read_by_functions():
    def positive(data: object) -> float:
        value = read_float(data)
        if value <= 0:
            raise CodecError('is not positive')
        return value

    codec = Codec(
        special={
            float: (None, positive),
            Leaf: (lambda leaf: leaf.name, lambda d: Leaf(only(str, d))),
        }
    )
    whole = replace(WHOLE, mixed=1)
    data = codec.to_json(whole)
    assert data['leaves'] == ['f', 'g']
    assert codec.from_json(Everything, data) == whole
    with pytest.raises(CodecError, match=r'^ratio is not positive$'):
        codec.from_json(Everything, {**data, 'ratio': 0})


def test_fields_of_a_later_version_are_ignored_if_wanted():
    codec = Codec(accept_unknown=True)
    assert codec.from_json(Leaf, {'name': 'a', 'size': 1}) == Leaf('a')
