# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Where elements and attributes stand, and what malformed XML is told."""

from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.source_text import read_source, Source
from colcon_yamllaunch.language.syntax.xml_reader import (
    MAXIMUM_ELEMENT_DEPTH,
    read_xml,
)
import pytest
from support.language_fixtures import Marked


def source(text, path='demo.launch.xml'):
    return Source(path, f'/share/{path}', text)


def malformed(text):
    with pytest.raises(LaunchError) as caught:
        read_xml(source(text))
    (problem,) = caught.value.diagnostics
    return problem


@pytest.mark.parametrize(
    ('path', 'text', 'expected'),
    [
        ('a.xml', '', True),
        ('a.launch', '\n <launch/>', True),
        ('a.yaml', '<launch/>', True),
        ('a.launch', 'launch: []', False),
        ('a.yaml', 'launch: []', False),
    ],
)
def test_which_files_are_xml(path, text, expected):
    assert source(text, path).is_xml is expected


def test_elements_and_attributes():
    root = read_xml(
        source(
            '<?xml version="1.0"?><!-- a --><launch>\n'
            ' <a b=\'1\' c="&lt;2&#x20;"/><?ignored?><d><![CDATA[ ]]></d>\n'
            '</launch>\n'
        )
    )
    assert root.name.text == 'launch'
    first, second = root.children
    assert (first.name.text, second.name.text) == ('a', 'd')
    values = {
        name: value.text for name, (_, value) in first.attributes.items()
    }
    assert values == {'b': '1', 'c': '<2 '}
    assert second.text is None


@pytest.mark.parametrize(
    'marked',
    [
        '<launch><node a="«x»"/></launch>',
        "<launch>\n\t<node\n  b='1'\n  a = '«x»' /></launch>",
        '<launch é="ü"><node b="é" a="«x»"/></launch>',
        '<launch>\r\n<node b="&amp;\r\n" a="«x»"/></launch>',
        '<launch><node aa="a=" b=\'a="y"\' a="«x»"/></launch>',
        '<launch><node a="«»"/></launch>',
    ],
)
def test_position_of_a_value(marked):
    mark = Marked.of(marked)
    (node,) = read_xml(source(mark.text)).children
    key, value = node.attributes['a']
    position = value.position
    assert (position.line, position.column) == (mark.line, mark.column)
    assert value.text == marked.partition('«')[2].partition('»')[0]
    lines = mark.text.split('\n')
    assert lines[key.line][key.column] == 'a'


@pytest.mark.parametrize(
    ('written', 'index', 'before'),
    [
        ('abc', 2, 'ab'),
        ('&amp;&#233;bc', 2, '&amp;&#233;'),
        ('a&quot;c', 1, 'a'),
        ('a\r\nc', 2, 'a\r\n'),
    ],
)
def test_place_of_a_character(written, index, before):
    text = f'<launch a="{written}"/>'
    value = read_xml(source(text)).attributes['a'][1]
    assert value.locate(index) == text.index(written) + len(before)


def test_positions_after_a_byte_order_mark(tmp_path):
    path = tmp_path / 'a.xml'
    path.write_text('<launch é="1" a="b"/>', encoding='utf-8-sig')
    root = read_xml(read_source(str(path), str(path)))
    assert root.attributes['a'][1].position.column == 18


@pytest.mark.parametrize(
    ('encoding', 'declared'),
    [
        ('utf-8', 'UTF-8'),
        ('iso-8859-1', 'ISO-8859-1'),
        ('windows-1252', 'windows-1252'),
        ('utf-16', 'UTF-16'),
    ],
)
def test_encodings(tmp_path, encoding, declared):
    path = tmp_path / 'a.xml'
    text = f'<?xml version="1.0" encoding="{declared}"?><launch a="é"/>'
    path.write_text(text, encoding=encoding)
    root = read_xml(read_source(str(path), str(path)))
    assert root.attributes['a'][1].text == 'é'


@pytest.mark.parametrize(
    ('encoding', 'text', 'message'),
    [
        ('utf-8', '<?xml version="1.0" encoding="rot13"?><launch/>', 'rot13'),
        (
            'utf-8',
            '<?xml version="1.0" encoding="iso-8859-12"?><launch/>',
            'iso-8859-12',
        ),
        (
            'utf-8',
            '<?xml version="1.0" encoding="us-ascii"?><launch a="é"/>',
            'is not us-ascii text',
        ),
        ('iso-8859-1', '<launch a="é"/>', 'is not UTF-8 text'),
    ],
)
def test_wrong_encodings(tmp_path, encoding, text, message):
    path = tmp_path / 'a.xml'
    path.write_text(text, encoding=encoding)
    with pytest.raises(LaunchError, match=message):
        read_source(str(path), str(path))


@pytest.mark.parametrize(
    ('marked', 'message', 'hint'),
    [
        ('«', 'has no element', '<launch> … </launch>'),
        ('«<!-- nothing -->', 'has no element', '<launch> … </launch>'),
        ('«l»aunch: []', 'starts with <launch>', None),
        ('<«launch»>', "'launch' is never closed", '</launch>'),
        (
            '<launch>\n<group>\n</«launch»>',
            "'launch' is closed here, but 'group' from line 2 is open",
            "end the tag in line 2 with '/>'",
        ),
        ('<launch><node a="1" «a»="2"/></launch>', "'a' stands twice", None),
        ('<launch/>«x»', 'behind the end', 'the one <launch>'),
        ('<launch/>\n«<»launch/>', 'behind the end', 'the one <launch>'),
        ('<launch>«&»foo;</launch>', 'not XML: undefined entity', None),
        ('\n«<»?xml version="1.0"?><launch/>', 'behind the start', 'remove'),
        ('<launch>«<!--» a', 'comment is never closed', "'-->'"),
        ('<launch><![CDATA[ a«', 'not XML: unclosed CDATA', None),
        ('<launch>\n«<»node a="1"', 'tag is never closed', "'/>'"),
        ('<launch>\n<node a=«"»1', 'quote is never closed', None),
        (
            '<launch>\n<node a=«"»1>\n<node b="2"/></launch>',
            "has a '<' in it",
            'close the quote',
        ),
        ('<launch><a b=«"»<"/></launch>', "has a '<' in it", '&lt;'),
        ('<launch><a b=«foo»/></launch>', 'no quotes', 'b="foo"'),
        ('<launch><a «b»/></launch>', "'b' has no value", 'b="…"'),
        ('<launch><a «b» c="1"/></launch>', "'b' has no value", 'b="…"'),
        (
            '<launch><a b="1"«c»="2"/></launch>',
            "the value of 'b' ends before this",
            'a space between',
        ),
        (
            '<launch><a b="$(eval "«1»+1")"/></launch>',
            "the value of 'b' ends before this",
            '&quot;',
        ),
        ('<launch><a b="1" «"»/></launch>', 'cannot stand here', None),
        ('<launch>a «&» b</launch>', "'&' starts", '&amp;'),
        ('<launch a="x «&» y"/>', "'&' starts", '&amp;'),
        ('<launch a="x «&»y z"/>', "'&' starts", '&amp;'),
        ('<launch><« »node/></launch>', 'cannot stand here', None),
        ('<launch><!-- a «--» b --></launch>', "cannot have '--'", "'-->'"),
        ('<launch>]]«>»</launch>', 'cannot stand here', None),
    ],
)
def test_malformed(marked, message, hint):
    mark = Marked.of(marked)
    problem = malformed(mark.text)
    mark.check(problem)
    assert message in problem.message
    if hint is not None:
        assert hint in problem.hint


@pytest.mark.parametrize(
    'text',
    [
        '«<!DOCTYPE» launch><launch/>',
        '<!-- <!DOCTYPE -->\n«<!DOCTYPE» launch [\n'
        '<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;">]>\n'
        '<launch a="&b;"/>',
        '«<!DOCTYPE» launch SYSTEM "file:///etc/passwd"><launch/>',
    ],
)
def test_document_types_are_refused(text):
    mark = Marked.of(text)
    problem = malformed(mark.text)
    mark.check(problem)
    assert 'no document type' in problem.message


def test_nesting_has_a_limit():
    depth = MAXIMUM_ELEMENT_DEPTH
    root = read_xml(source('<a>' * depth + '</a>' * depth))
    assert root.name.text == 'a'
    problem = malformed('<a>' * (depth + 1) + '</a>' * (depth + 1))
    assert f'more than {depth} levels' in problem.message
    assert problem.position.column == 3 * depth + 2
