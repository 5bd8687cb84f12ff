# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Mistakes in XML launch files, and where they are shown."""

from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.language.syntax.diagnostics import render
from colcon_yamllaunch.language.syntax.yaml_reader import MAXIMUM_VALUES
from hypothesis import given
from hypothesis import strategies as st
import pytest
from support.language_fixtures import Marked

NODE = '<node pkg="alpha" exec="talker">'


def error(launcher, marked):
    mark = Marked.of(marked)
    errors = launcher.evaluate(mark.text).errors
    assert len(errors) == 1, errors
    mark.check(errors[0])
    return errors[0]


@pytest.mark.parametrize(
    ('marked', 'message', 'hint'),
    [
        ('<«robot» name="x"/>', "root element is 'robot'", '<launch>'),
        ('<launch «depracated»="x"/>', "no attribute 'dep", "'deprecated'?"),
        ('<launch>\n  <«nod»/></launch>', "action 'nod'", "'node'?"),
        ('<launch><«gz_server»/></launch>', "'gz_server'", 'the nearest are'),
        ('<launch><«log»/></launch>', "needs the attribute 'message'", None),
        (
            '<launch><log message="a" «mesage»="b"/></launch>',
            "'log' has no attribute 'mesage'",
            "'message'?",
        ),
        (
            '<launch><log message="a" if="1" unless="«0»"/></launch>',
            'exclude one another',
            '$(and …',
        ),
        (
            '<launch><arg name="a" default="1"><«choise» value="1"/></arg>'
            '</launch>',
            "'arg' has no element 'choise'",
            "'choice'?",
        ),
        (
            '<launch><let name="a" value="1"><«value»>2</value></let>'
            '</launch>',
            "'let' has no element 'value'",
            'value="…"',
        ),
        (
            f'<launch>{NODE}<«log» message="a"/></node></launch>',
            "'node' has no element 'log'",
            "'/>'",
        ),
        (
            '<launch><node pkg="alpha" exec="talker" «param»="a"/></launch>',
            "'param' is no attribute in XML",
            '<param …/>',
        ),
        (
            '<launch><group «children»="a"/></launch>',
            "'children' is no attribute in XML",
            'inside of <group>',
        ),
        (
            '<launch><log message="a" «children»="a"/></launch>',
            "'log' has no attribute 'children'",
            None,
        ),
        (
            '<launch><include file="a"><«arg» name="b"/></include></launch>',
            "'arg' needs the attribute 'value'",
            None,
        ),
        (
            '<launch><node exec="a"><param «period»="0.5"/></node></launch>',
            "'param' has no attribute 'period'",
            'write name="period" value="0.5"',
        ),
        (
            '<launch><«lifecycle_node» pkg="a" exec="b"/></launch>',
            "'lifecycle_node' needs the attribute 'name'",
            None,
        ),
        (
            '<launch><«load_composable_node» target="a"/></launch>',
            "'load_composable_node' has nothing to load",
            "'composable_node'",
        ),
        (
            '<launch><«composable_node» pkg="a"/></launch>',
            "'composable_node' is no action of its own",
            "'load_composable_node'",
        ),
        (
            '<launch><node_container pkg="alpha" exec="talker" name="a"\n'
            'namespace="b"><«composable_node» pkg="a"/></node_container>'
            '</launch>',
            "'composable_node' needs the attribute 'plugin'",
            None,
        ),
    ],
)
def test_structure(launcher, marked, message, hint):
    problem = error(launcher, marked)
    assert message in problem.message
    if hint is not None:
        assert hint in problem.hint


@pytest.mark.parametrize(
    ('attributes', 'message', 'hint'),
    [
        ('name="a" value="«2»" type="bool"', 'is no bool', None),
        ('name="a" value="«x»" type="int"', 'is no int', None),
        ('name="a" value="1" type="«integer»"', "cannot be 'integer'", None),
        ('name="a" value="«{b: c}»"', 'a mapping', 'type="str"'),
        ('name="a" value="«b: c»"', 'a mapping', 'type="str"'),
        ('name="a" value="«null"', 'cannot be null', "''"),
        ('name="a" value="«2020-01-01"', 'a date', 'quote it'),
        ('name="a" value="«[1, b]"', 'have one type', None),
        ('name="a" value="[1, «[2]]"', 'scalars in it', None),
        ('name="a" value="«a»" type="list_of_str"', 'no list', None),
        ('name="a" value="«a;b" value-sep=";" type="int"', 'a list', None),
        ('name="a" value="a" value-sep="«"', 'is empty', "';'"),
        ('from="b" «value-sep»=","', "no attribute 'value-sep'", None),
    ],
)
def test_parameters(launcher, attributes, message, hint):
    marked = f'<launch>{NODE}<param {attributes}/></node></launch>'
    problem = error(launcher, marked)
    assert message in problem.message
    if hint is not None:
        assert hint in problem.hint


@pytest.mark.parametrize(
    ('attributes', 'message'),
    [
        ('value="a"', "needs 'name'"),
        ('name="a"', "needs a 'value'"),
        ('name="a" from="b"', "takes no 'name'"),
    ],
)
def test_attributes_of_parameters(launcher, attributes, message):
    text = f'<launch>{NODE}<«param {attributes}/></node></launch>'
    assert message in error(launcher, text).message


@pytest.mark.parametrize(
    'value',
    [
        '«$(vra a)»',
        'a &amp; b «$(vra» a)',
        '&lt;é&#233;«$(vra» a)',
        'x\r\n\ty «$(vra» a)',
        'x $(env UNSET $(env UNSET «$(vra» a)))',
    ],
)
def test_substitutions_are_shown_where_they_stand(launcher, value):
    text = f'<launch>\n  <let name="a"\n       value="{value}"/>\n</launch>'
    mark = Marked.of(text.replace('«$(vra a)»', '«$(vra» a)'))
    (problem,) = launcher.evaluate(mark.text.encode()).errors
    mark.check(problem)
    assert "unknown substitution 'vra'" in problem.message


@pytest.mark.parametrize(
    'value',
    [
        '«$(var» b)',
        '[1, «$(var» b)]',
        "[1, '$(env SET) &amp; «$(var» b)']",
        "'a «$(var» b)'",
    ],
)
def test_substitutions_in_parameters(launcher, value):
    text = f'<launch>\n{NODE}<param name="a" value="{value}"/></node></launch>'
    mark = Marked.of(text.replace('»', ''))
    (problem,) = launcher.evaluate(mark.text).errors
    mark.check(problem)
    assert "launch configuration 'b' does not exist" in problem.message


@pytest.mark.parametrize(
    'marked',
    [
        '<launch>\n «stray»\n</launch>',
        '<launch><log message="a"/>«b»</launch>',
        '<launch><![CDATA[«x»]]></launch>',
    ],
)
def test_text_between_elements_is_ignored_with_a_warning(launcher, marked):
    mark = Marked.of(marked)
    (warning,) = launcher.evaluate(mark.text).diagnostics
    mark.check(warning)
    assert warning.severity == 'warning'
    assert 'text stands inside' in warning.message
    assert 'name="value"' in warning.hint


def test_an_empty_text_is_a_parameter(launcher):
    text = f'<launch>{NODE}<param name="a" value=""/></node></launch>'
    evaluation = launcher.evaluate(text)
    assert not evaluation.diagnostics
    (process,) = evaluation.plan.processes()
    (file,) = [a for a in process.argv if not isinstance(a, str)]
    assert [(p.name, p.value) for p in file.parameters] == [('a', '""')]


def test_all_mistakes_of_a_file_show_at_once_and_in_order(launcher):
    text = """<launch>
  <nod/>
  text
  <group unless="$(vra a)">
    <log messag="a">b</log>
  </group>
  <load_composable_node/>
</launch>"""
    errors = launcher.evaluate(text).errors
    lines = [e.position.line for e in errors]
    assert lines == [2, 4, 5, 7]


def test_the_excerpt_and_the_way_there(launcher):
    launcher.write('in.launch.xml', '<launch>\n<log mesage="é"/></launch>')
    evaluation = launcher.evaluate(
        '<launch>\n\n<include file="in.launch.xml"/></launch>'
    )
    shown = render(evaluation.errors, str(launcher.folder)).splitlines()
    assert shown[:3] == [
        "in.launch.xml:2:6: error: 'log' has no attribute 'mesage'",
        '  2 | <log mesage="é"/></launch>',
        '    |      ^^^^^^',
    ]
    assert '  included from main.yaml:3:16' in shown


def test_a_list_of_too_many_values(launcher):
    values = '1;' * MAXIMUM_VALUES
    text = (
        f'<launch>{NODE}<param name="a" value="{values}" value-sep=";"/>'
        '</node></launch>'
    )
    (problem,) = launcher.evaluate(text).errors
    assert f'no more than {MAXIMUM_VALUES}' in problem.message


def test_deprecated(launcher):
    (warning,) = launcher.evaluate('<launch deprecated="use b"/>').diagnostics
    assert warning.message == 'this launch file is deprecated: use b'


def test_choices_are_texts(launcher):
    text = (
        '<launch><arg name="a" default="yes"><choice value="yes"/></arg>'
        '<log message="$(var a)" if="$(equals $(var a) yes)"/></launch>'
    )
    (entry,) = launcher.good(text).plan.entries
    assert entry.text == 'yes'


FRAGMENTS = [
    '<launch>',
    '</launch>',
    '<launch deprecated="a">',
    '<group scoped="0">',
    '</group>',
    NODE,
    '</node>',
    '<param name="a" value="[1, $(env SET)]"/>',
    '<param name="a" value="1;2" value-sep=";">',
    '</param>',
    '<param name="a" value="',
    '<log message="é&amp;$(env SET)"/>',
    '<arg name="a" default="1"/>',
    '<include file="main.yaml"/>',
    '<let name="a" value="$(var a)"/>',
    '<timer period="1">',
    '</timer>',
    '<!-- a -->',
    '<!DOCTYPE a [<!ENTITY b "c">]>',
    '<![CDATA[',
    ']]>',
    '<?xml version="1.0" encoding="UTF-8"?>',
    '&b;',
    '&',
    '<',
    '/>',
    '"',
    "'",
    '\r\n',
    'x',
    'é𝄞',
]


def survives(launcher, data):
    evaluation = launcher.evaluate(data)
    assert isinstance(evaluation, Evaluation)
    shown = render(evaluation.diagnostics, str(launcher.folder))
    lines = data.decode(errors='replace').count('\n') + 1
    for diagnostic in evaluation.diagnostics:
        position = diagnostic.position
        assert position is None or 1 <= position.line <= lines
    assert bool(evaluation.diagnostics) == bool(shown)


@given(st.lists(st.sampled_from(FRAGMENTS), max_size=12).map(''.join))
def test_any_fragments(shared_launcher, text):
    survives(shared_launcher, f'<launch>{text}</launch>'.encode())
    survives(shared_launcher, f'<{text}'.encode())


@given(st.binary(max_size=60))
def test_any_bytes(shared_launcher, data):
    survives(shared_launcher, b'<' + data)
    survives(shared_launcher, b'<launch a="' + data)
