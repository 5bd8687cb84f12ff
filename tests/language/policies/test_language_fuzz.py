# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Whatever is in a launch file, the user gets diagnostics and no traceback.

`HYPOTHESIS_PROFILE=long` tries many more examples.
"""

import json
from pathlib import Path

from colcon_yamllaunch.language.policies.check import check, find_declarations
from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.language.reports import (
    as_github,
    as_json,
    as_sarif,
    as_text,
    show_arguments,
)
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError, render
from colcon_yamllaunch.language.syntax.text import (
    parse_template,
    split_command_line,
    TemplateSyntaxError,
    UnclosedQuoteError,
)
from colcon_yamllaunch.language.vocabulary.actions import (
    Action,
    ACTIONS,
    Attribute,
    items_of,
    Type,
)
from colcon_yamllaunch.language.vocabulary.substitutions import KINDS
from hypothesis import assume, given
from hypothesis import strategies as st
from support.language_fixtures import Launcher
import yaml

CASES = [
    path.read_text(encoding='utf-8')
    for path in sorted(
        (Path(__file__).parents[2] / 'conformance' / 'cases').glob('*.yaml')
    )
]
#: Substitutions that run what the text says.
DANGEROUS = ('command', 'eval')

NAMES = sorted(set(KINDS) - {*DANGEROUS})
TOKENS = ['$(', ')', ' ', "'", '"', '\\', '$', '(', 'a', '1', 'é', '\n']
SUBSTITUTIONS = st.lists(
    st.sampled_from([*TOKENS, *(f'$({name} ' for name in NAMES)]), max_size=20
).map(''.join)

FRAGMENTS = [
    'launch:',
    '- node:',
    '- node: {pkg: alpha, exec: talker}',
    '- group:',
    '- executable: {cmd: echo $(var a)}',
    '- arg: {name: a, default: b}',
    '- let: {name: a, value: "$(env SET)"}',
    '- set_parameter: {name: a, value: [1, 2]}',
    '- timer: {period: 1, children: []}',
    '- for: {len: 3, name: i, children: [log: {message: $(index i)}]}',
    '- include: {file: other.yaml}',
    'pkg: alpha',
    'exec: talker',
    'param:',
    '- {name: p, value: 1.5}',
    'children:',
    'if: $(equals 1 1)',
    'scoped: no',
    '&a',
    '*a',
    '<<: *a',
    'value: |',
    '$(dirname)',
    '!!int',
    '{',
    '}',
    ']',
    '"',
    "'",
    '#',
    ':',
    '-',
    '? ',
    '---',
    '\t',
    '\u2028',
    '漢',
    '',
]
LINES = st.tuples(
    st.integers(0, 8), st.lists(st.sampled_from(FRAGMENTS), max_size=3)
)
YAMLISH = st.lists(LINES, max_size=12).map(
    lambda lines: '\n'.join(' ' * n + ' '.join(them) for n, them in lines)
)


def is_harmless(text: str | bytes) -> bool:
    if isinstance(text, bytes):
        text = text.decode('latin-1').replace('\0', '')
    return not any(word in text for word in DANGEROUS)


def look_over(launcher: Launcher, text: str | bytes) -> None:
    """Check a text, list its arguments, and write all reports of it."""
    request, cwd = launcher.request(text), str(launcher.folder)
    result = check(request, portable=True)
    as_github(result, cwd)
    as_text(result, cwd)
    shown = json.loads(as_json(result, cwd))['diagnostics']
    (run,) = json.loads(as_sarif(result, cwd))['runs']
    assert len(shown) == len(run['results']) == len(result.diagnostics)
    try:
        declarations = find_declarations(request)
    except LaunchError:
        return
    assert show_arguments(declarations, cwd).startswith('Arguments')


def examine(launcher: Launcher, text: str | bytes) -> Evaluation:
    """Evaluate and check a text, and show all that a user would see."""
    launcher.write('other.yaml', 'launch: [log: {message: other}]')
    look_over(launcher, text)
    assume(is_harmless(text))
    evaluation = launcher.evaluate(text)
    shown = render(evaluation.diagnostics, str(launcher.folder))
    assert bool(shown) == bool(evaluation.diagnostics)
    for diagnostic in evaluation.diagnostics:
        position = diagnostic.position
        if position is not None:
            assert position.line >= 1
            assert position.column >= 1
            assert Path(position.path).is_file()
    assert evaluation.errors or evaluation.files
    return evaluation


@given(data=st.binary())
def test_bytes(shared_launcher, data):
    examine(shared_launcher, data)


@given(text=st.text(), tail=st.text())
def test_text(shared_launcher, text, tail):
    examine(
        shared_launcher, f'{text}launch: {tail}'.encode('utf-8', 'replace')
    )


@given(text=YAMLISH)
def test_lines_like_those_of_a_launch_file(shared_launcher, text):
    examine(shared_launcher, text)


@given(
    text=st.sampled_from(
        [
            'launch:\n    - node: {pkg: alpha, exec: talker}\n',
            'launch:\n- group:\n  - let:\n      name: a\n      value: "b"\n',
            'launch: {children: [executable: {cmd: [echo, $(var a b)]}]}',
            *CASES,
        ]
    ),
    place=st.integers(0, 400),
    count=st.integers(0, 5),
    new=st.sampled_from([*FRAGMENTS, '\n', '\n  ', '\x00', '\ud7ff', ', ']),
)
def test_a_launch_file_with_one_slip(shared_launcher, text, place, count, new):
    examine(shared_launcher, text[:place] + new + text[place + count :])


@given(text=SUBSTITUTIONS)
def test_substitutions(shared_launcher, text):
    launch = [{'executable': {'cmd': ['echo', text]}}]
    examine(shared_launcher, yaml.dump({'launch': launch}))


@given(text=st.one_of(SUBSTITUTIONS, st.text()))
def test_grammar(text):
    try:
        template = parse_template(text)
    except TemplateSyntaxError as e:
        assert 0 <= e.index <= len(text)
        assert e.message
        return
    try:
        split_command_line(template)
    except UnclosedQuoteError as e:
        assert str(e) in ('"', "'")


TEXTS = st.sampled_from(
    [
        'a',
        'b c',
        '',
        '/a/b',
        '1',
        '2.5',
        'true',
        'echo a',
        'alpha',
        'talker',
        'other.yaml',
        'nowhere.yaml',
        '$(var a)',
        '$(var b x)',
        '$(env SET)',
        '$(dirname)/other.yaml',
        '$(not $(var a true))',
        '$(equals 1 1)',
        '$(find-pkg-share alpha)',
        '$(index a)',
        '{a: 1};{a: 2}',
        '$(if true 2 3)',
        "$(eval '1 / 0')",
        '$(command $(var a))',
        "'open",
        'a\0b',
        'a=b',
        '日本',
    ]
)
SCALARS = {
    Type.TEXT: TEXTS,
    Type.NAME: TEXTS,
    Type.PLAIN: TEXTS.filter(lambda text: '$' not in text),
    Type.BOOLEAN: st.one_of(st.booleans(), TEXTS),
    Type.INTEGER: st.one_of(st.integers(-2, 5), TEXTS),
    Type.SECONDS: st.one_of(st.floats(-1, 9), st.integers(0, 9), TEXTS),
    Type.COMMAND: st.one_of(TEXTS, st.lists(TEXTS, max_size=3)),
    Type.VALUE: st.one_of(
        TEXTS,
        st.integers(),
        st.floats(),
        st.booleans(),
        st.lists(st.one_of(TEXTS, st.integers()), max_size=3),
    ),
}


def values(attribute: Attribute, depth: int) -> st.SearchStrategy[object]:
    if attribute.values:
        return st.sampled_from(attribute.values)
    if attribute.type is Type.ACTIONS:
        return actions(depth - 1)
    if attribute.type is Type.ITEMS:
        inner = items_of(attribute)
        if depth <= 0:
            inner = tuple(a for a in inner if a.type is not Type.ITEMS)
        return st.lists(mappings(inner, depth - 1), min_size=1, max_size=2)
    return SCALARS.get(attribute.type, TEXTS)


def mappings(
    attributes: tuple[Attribute, ...], depth: int
) -> st.SearchStrategy[dict[str, object]]:
    return st.fixed_dictionaries(
        {a.name: values(a, depth) for a in attributes if a.required},
        optional={
            a.name: values(a, depth)
            for a in attributes
            # two conditions at once would never be valid
            if not a.required and a.name != 'unless'
        },
    )


def action(entry: Action, depth: int) -> st.SearchStrategy[object]:
    return mappings(entry.attributes, depth).map(
        lambda attributes: {entry.name: attributes}
    )


def actions(depth: int) -> st.SearchStrategy[list[object]]:
    usable = [a for a in ACTIONS.values() if depth > 0 or not a.has_children]
    return st.lists(
        st.sampled_from(usable).flatmap(lambda entry: action(entry, depth)),
        max_size=3,
    )


@given(launch=actions(2))
def test_every_action_with_any_attributes(shared_launcher, launch):
    text = yaml.dump({'launch': launch}, allow_unicode=True)
    evaluation = examine(shared_launcher, text)
    assert shared_launcher.evaluate(text) == evaluation
