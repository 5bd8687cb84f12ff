# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""YAML 1.1, with the position of every value."""

from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.yaml_reader import (
    Mapping,
    MAXIMUM_DEPTH,
    read_yaml,
    Scalar,
    Sequence,
)
from hypothesis import given
from hypothesis import strategies as st
import pytest
from support.language_fixtures import Marked, source
import yaml


def read(text):
    return read_yaml(source(text))


def plain(value):
    """Return a value as `yaml.safe_load` does."""
    if isinstance(value, Scalar):
        return value.value
    if isinstance(value, Sequence):
        return [plain(item) for item in value.items]
    assert isinstance(value, Mapping)
    return {key.value: plain(item) for key, item in value.pairs.values()}


def places(value):
    """Return the (line, column) of a value and all in it, in order."""
    inner = []
    if isinstance(value, Sequence):
        inner = value.items
    elif isinstance(value, Mapping):
        inner = [part for pair in value.pairs.values() for part in pair]
    position = value.position
    found = [(position.line, position.column)]
    for item in inner:
        found += places(item)
    return found


def test_positions():
    text = (
        'launch:\n'
        '  - node:\n'
        "      é: 'ü' # comment\n"
        '  - {a: b, 漢: [c, "d" ]}\n'
    )
    assert places(read(text)) == [
        (1, 1),
        (1, 1),
        (2, 3),
        (2, 5),
        (2, 5),
        (3, 7),
        (3, 7),
        (3, 10),
        (4, 5),
        (4, 6),
        (4, 9),
        (4, 12),
        (4, 15),
        (4, 16),
        (4, 19),
    ]


def test_positions_in_lines_that_end_as_on_windows():
    assert places(read('a:\r\n- b\r\n- c\r\n')) == [
        (1, 1),
        (1, 1),
        (2, 1),
        (2, 3),
        (3, 3),
    ]


@pytest.mark.parametrize(
    ('text', 'kind', 'value'),
    [
        ('text', 'str', 'text'),
        ('"1"', 'str', '1'),
        ("'true'", 'str', 'true'),
        ('! 5', 'str', '5'),
        ('!!str 5', 'str', '5'),
        ('1', 'int', 1),
        ('-1_000', 'int', -1000),
        ('010', 'int', 8),
        ('0x1F', 'int', 31),
        ('0b101', 'int', 5),
        ('1:30', 'int', 90),
        ('08', 'str', '08'),
        ('!!int "7"', 'int', 7),
        ('1.5', 'float', 1.5),
        ('1.0e-3', 'float', 0.001),
        ('1e-3', 'str', '1e-3'),
        ('.inf', 'float', float('inf')),
        ('!!float 1', 'float', 1.0),
        ('yes', 'bool', True),
        ('Off', 'bool', False),
        ('y', 'str', 'y'),
        ('~', 'null', None),
        ('null', 'null', None),
        ('', 'null', None),
        ('2020-01-01', 'timestamp', '2020-01-01'),
        ('|\n  text', 'str', 'text\n'),
        ('>-\n  1', 'str', '1'),
    ],
)
def test_kinds(text, kind, value):
    scalar = read(f'key: {text}\n').pairs['key'][1]
    assert scalar.kind == kind
    assert scalar.value == value
    assert type(scalar.value) is type(value)


@pytest.mark.parametrize(
    'text',
    [
        'a: &x {b: 1}\nc: *x\n',
        'a: &x 1\nb: [*x, *x]\n',
        '- &x\n  a: 1\n  b: 2\n- <<: *x\n  a: 3\n',
        '- &x {a: 1}\n- &y {a: 2, b: 2}\n- {<<: [*x, *y], c: 3}\n',
        '- &x {a: 1}\n- &y {<<: *x, b: 2}\n- {<<: *y}\n',
        '%YAML 1.2\n---\na: 1\n...\n',
        '# only the comment\n--- \na: 1\n',
        'a: {}\nb: []\nc:\n',
        '"quoted": 1\n2: x\ntrue: y\n',
        '? a\n: b\n',
        '{"a":1, b: 2}\n',
        '[a, {b: c}, [d]]\n',
        'a: b\n  c\n\n  d\n',
    ],
)
def test_values_are_those_of_pyyaml(text):
    assert plain(read(text)) == yaml.safe_load(text)


def test_of_two_anchors_with_one_name_the_last_counts():
    assert plain(read('[&x 1, *x, &x 2, *x]')) == [1, 1, 2, 2]


def test_a_merge_key_that_is_quoted_is_a_key():
    assert plain(read('"<<": 1\n')) == {'<<': 1}


@pytest.mark.parametrize('text', ['', ' \n', '# comment\n', '---\n'])
def test_no_document(text):
    document = read(text)
    assert document is None or document.kind == 'null'


SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(allow_nan=False),
    st.text(st.characters(exclude_categories=['Cs', 'Cc', 'Cn'])),
)
DOCUMENTS = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4),
        st.dictionaries(st.text('ab é', min_size=1), inner, max_size=4),
    ),
    max_leaves=12,
)


@given(DOCUMENTS, st.sampled_from([None, '"', "'"]), st.booleans())
def test_what_pyyaml_writes_is_read(document, style, flow):
    text = yaml.dump(
        document,
        default_style=style,
        default_flow_style=flow,
        allow_unicode=True,
    )
    assert plain(read(text)) == document


@pytest.mark.parametrize(
    ('marked', 'message'),
    [
        ('a: 1\nb: 2\n«a»: 3\n', "'a' stands twice .* in line 1"),
        ('- {a: 1, «"a": 2}\n', "'a' stands twice"),
        ('a: &x {b: 1, «b»: 2}\n', "'b' stands twice"),
        ('a: 1\n«---»\nb: 2\n', 'one YAML document'),
        ('a: «*b»\n', "alias '\\*b' names no anchor"),
        ('a: «*b»\nc: &b 1\n', "alias '\\*b' names no anchor"),
        ('a: &b [«*b»]\n', 'inside of what it names'),
        ('? «[a]\n: b\n', 'where a name is meant'),
        ('«{a: b}: c\n', 'where a name is meant'),
        ('a: {<<: «1}\n', 'takes a mapping'),
        ('a: &x [«1]\n<<: *x\n', 'takes a mapping'),
        ('a: «!!set {b}\n', 'tag .* not known'),
        ('a: «!mine [b]\n', 'tag .* not known'),
    ],
)
def test_errors(marked, message):
    mark = Marked.of(marked)
    with pytest.raises(LaunchError, match=message) as raised:
        read(mark.text)
    (diagnostic,) = raised.value.diagnostics
    mark.check(diagnostic)


@pytest.mark.parametrize(
    'text', ['!mine x', '!!binary x', '!!int x', '!!float x', '!!bool x']
)
def test_a_tag_that_does_not_fit_is_an_error(text):
    scalar = read(f'a: {text}\n').pairs['a'][1]
    with pytest.raises(LaunchError, match='tag') as raised:
        scalar.kind  # noqa: B018
    position = raised.value.diagnostics[0].position
    assert (position.line, position.column) == (1, 4)


@pytest.mark.parametrize(('opening', 'closing'), [('[', ']'), ('{a: ', '}')])
def test_depth_has_a_limit(opening, closing):
    read(opening * MAXIMUM_DEPTH + closing * MAXIMUM_DEPTH)
    with pytest.raises(LaunchError, match='nested more than'):
        read(opening * (MAXIMUM_DEPTH + 1) + closing * (MAXIMUM_DEPTH + 1))


def test_aliases_cannot_make_a_file_enormous():
    lines = ['a0: &a0 [x, x, x, x, x, x, x, x, x, x]']
    lines += [
        f'a{n}: &a{n} [{", ".join([f"*a{n - 1}"] * 10)}]' for n in range(1, 9)
    ]
    with pytest.raises(LaunchError, match='once its aliases are expanded'):
        read('\n'.join(lines))
