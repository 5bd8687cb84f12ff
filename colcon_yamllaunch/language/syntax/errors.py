# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a syntax error in YAML or XML means, for the person who made it."""

from collections.abc import Callable, Mapping, Sequence
import re
from typing import NamedTuple
from xml.parsers.expat import errors as codes
from xml.parsers.expat import ErrorString

from colcon_yamllaunch.language.syntax.diagnostics import error, LaunchError
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar
import yaml


class _Explanation(NamedTuple):
    """
    What is wrong in a text.

    :param at: The index where it starts
    :param length: How many characters are wrong
    """

    at: int
    message: str
    hint: str | None = None
    length: int = 1

    def in_source(self, source: Source) -> LaunchError:
        """Return the error of the file that has this text."""
        at = source.position_at(self.at)
        return error(self.message, at, hint=self.hint, length=self.length)


def explain_yaml(problem: yaml.YAMLError, source: Source) -> LaunchError:
    """
    Return the error that a user is shown for a YAML syntax error.

    :param problem: The error of PyYAML, or of libyaml below it
    :param source: The file
    """
    mark = getattr(problem, 'problem_mark', None)
    if not isinstance(problem, yaml.MarkedYAMLError) or mark is None:
        return error(f'{source.path} is not YAML: {problem}')
    text, context = problem.problem or '', problem.context_mark or mark
    at, opened = (source.index_of(m.line, m.column) for m in (mark, context))
    found = _Explanation(at, f'not YAML: {text}')
    for words, explain in _YAML_EXPLANATIONS:
        if words in text:
            found = explain(source.text, at, opened)
            break
    return found.in_source(source)


def _wrong_character(text: str, _at: int, at: int) -> _Explanation:
    character = text[at : at + 1]
    message, hint = (
        f"a value cannot start with '{character}'",
        'quote the value',
    )
    if character == '\t':
        message = 'a tab stands where YAML wants spaces'
        hint = 'indent with spaces'
    elif not character.strip():
        message, hint = 'a value is missing here', 'is a bracket not closed?'
    return _Explanation(at, message, hint)


def _missing_colon(_text: str, _at: int, opened: int) -> _Explanation:
    return _Explanation(
        opened,
        "there is no ':' in this line",
        "write 'name: value', or indent the line deeper if it goes on with "
        'the value before it',
    )


def _wrong_indentation(text: str, at: int, _opened: int) -> _Explanation:
    start = text.rfind('\n', 0, at) + 1
    if text[start:at].strip(' -'):
        return _Explanation(
            at,
            'the value ended before this text',
            'quote the whole value, or close the quote before it',
        )
    is_item = text.startswith('-', at)
    what = 'list item' if is_item else 'line'
    alike = r'^( *)-\s' if is_item else r'^( *)[^\s#-]'
    before = [*re.finditer(alike, text[:start], re.M)]
    message = f'this {what} is indented by {_spaces(at - start)}'
    if before:
        line = text.count('\n', 0, before[-1].start()) + 1
        indent = _spaces(len(before[-1][1]))
        message += f', but the {what} before it (line {line}) by {indent}'
    hint = 'indent both by the same number of spaces'
    return _Explanation(at, message, hint)


def _misplaced_colon(text: str, at: int, _opened: int) -> _Explanation:
    lines = text[:at].split('\n')
    line, before = lines.pop(), ''
    if re.search(r'[\w\'"]:\s', line):
        return _Explanation(at, "a value with ': ' in it must be quoted")
    start = at - len(line)
    while lines and not before:
        start -= len(lines[-1]) + 1
        before = re.sub(r'^\s*#.*', '', lines.pop()).rstrip()
    name = re.match(r'\s*(?:- +)?', before)
    start += name.end() if name else 0
    glued = re.match(r'[\w-]+(?=:[^\s/])', before.lstrip(' -'))
    if glued:
        message = f"there is no space after '{glued[0]}:'"
        return _Explanation(start + glued.end(), message)
    if before and ':' not in before:
        return _missing_colon(text, at, start)
    indent = len(line) - len(line.lstrip())
    return _Explanation(
        at - len(line) + indent,
        f'this line is indented by {_spaces(indent)}, deeper than the lines '
        'that it belongs with',
        'indent it as the line before',
    )


def _unclosed_bracket(text: str, at: int, opened: int) -> _Explanation:
    bracket = text[opened : opened + 1]
    closing = '}' if bracket == '{' else ']'
    if at >= len(text) or '\n' in text[opened:at]:
        return _Explanation(
            opened,
            f"this '{bracket}' is not closed",
            f"add the '{closing}', or quote the value if '{bracket}' belongs "
            'to it',
        )
    return _Explanation(
        at,
        f"'{closing}' or ',' is missing before this",
        'quote the value if this belongs to it',
    )


def _unclosed_quote(_text: str, _at: int, opened: int) -> _Explanation:
    return _Explanation(opened, 'this quote is not closed')


def _unknown_escape(_text: str, at: int, _opened: int) -> _Explanation:
    return _Explanation(
        at,
        "YAML does not know this '\\' in double quotes",
        "use single quotes, or double the backslash: '\\\\'",
    )


# what is said if these words are in the message of the YAML parser
_YAML_EXPLANATIONS: tuple[
    tuple[str, Callable[[str, int, int], _Explanation]], ...
] = (
    ('cannot start any token', _wrong_character),
    ('node content', _wrong_character),
    ('alphabetic or numeric character', _wrong_character),
    ("could not find expected ':'", _missing_colon),
    ('did not find expected key', _wrong_indentation),
    ("did not find expected '-'", _wrong_indentation),
    ('expected <block end>', _wrong_indentation),
    ('mapping values are not allowed', _misplaced_colon),
    ("expected ',' or", _unclosed_bracket),
    ('unexpected end of stream', _unclosed_quote),
    ('unknown escape character', _unknown_escape),
    ('decimal number', _unknown_escape),
)


def _spaces(count: int) -> str:
    return '1 space' if count == 1 else f'{count} spaces'


_SPACE = '[ \\t\\r\\n]*'
_NAME = r'[^\s<>/="\'&]+'
# a tag up to the first attribute that is not well-formed
_TAG = (
    rf'<{_NAME}(?:{_SPACE}(?P<name>{_NAME}){_SPACE}={_SPACE}'
    r'(?:"[^"]*"|\'[^\']*\'))*'
)
_UNFINISHED = (
    rf'{_SPACE}(?P<name>{_NAME}){_SPACE}(?P<equals>=?){_SPACE}'
    r'(?P<rest>[^\s<>/]*)'
)


def explain_xml(
    code: int, index: int, tags: Sequence[Scalar], source: Source
) -> LaunchError:
    """
    Return the error that a user is shown for an XML syntax error.

    :param code: The number of expat's error
    :param index: The index of the character where expat noticed it
    :param tags: The names of the elements that are open there, outer ones
      first
    :param source: The file
    """
    message = ErrorString(code) or 'it is malformed'
    found = _Explanation(index, f'not XML: {message}')
    if message in _XML_EXPLANATIONS:
        found = _XML_EXPLANATIONS[message](source.text, index)
    elif message == codes.XML_ERROR_NO_ELEMENTS:
        found = _unclosed_element(source, tags)
    elif message == codes.XML_ERROR_TAG_MISMATCH:
        found = _mismatch(source.text, index, tags)
    return found.in_source(source)


def _unclosed_element(source: Source, tags: Sequence[Scalar]) -> _Explanation:
    if not tags:
        hint = 'a launch file is <launch> … </launch>'
        return _Explanation(0, 'the launch file has no element in it', hint)
    tag = tags[-1]
    return _Explanation(
        source.index_of(tag.line, tag.column),
        f"'{tag.text}' is never closed",
        f"write </{tag.text}> where it ends, or end its tag with '/>'",
        len(tag.text),
    )


def _mismatch(text: str, index: int, tags: Sequence[Scalar]) -> _Explanation:
    name, tag = _name_at(text, index), tags[-1].text
    line = tags[-1].line + 1
    hint = f"write </{tag}> before it, or end the tag in line {line} with '/>'"
    message = f"'{name}' is closed here, but '{tag}' from line {line} is open"
    return _Explanation(index, message, hint, len(name))


def _duplicate(text: str, index: int) -> _Explanation:
    name = _name_at(text, index)
    message = f"the attribute '{name}' stands twice in this element"
    return _Explanation(index, message, 'remove one', len(name))


def _name_at(text: str, index: int) -> str:
    name = re.compile(_NAME).match(text, index)
    return name[0] if name else text[index : index + 1]


def _behind_the_end(_text: str, index: int) -> _Explanation:
    message = 'this stands behind the end of the launch file'
    hint = 'everything stands inside of the one <launch>'
    return _Explanation(index, message, hint)


def _before_the_start(text: str, index: int) -> _Explanation:
    message = 'a launch file in XML starts with <launch>'
    if text.startswith('<?xml', index):
        message = "'<?xml …?>' stands behind the start of the file"
    hint = 'remove what is before it, empty lines too'
    return _Explanation(index, message, hint)


def _unclosed(text: str, start: int) -> _Explanation:
    if text.startswith('<!--', start):
        message, hint = 'the comment is never closed', "write '-->' at its end"
        return _Explanation(start, message, hint, len('<!--'))
    quote = _open_quote(text, start, len(text))
    if quote is not None:
        hint = 'write the same quote where the value ends'
        return _Explanation(quote, 'the quote is never closed', hint)
    hint = "write '>' or '/>' where it ends"
    return _Explanation(start, 'the tag is never closed', hint)


def _invalid_token(text: str, index: int) -> _Explanation:
    start = text.rfind('<', 0, index)
    ampersand = text.rfind('&', 0, index + 1)
    if start >= 0 and text.startswith('<!--', start):
        return _Explanation(
            text.rfind('--', start, index + 1),
            "a comment cannot have '--' in it",
            "comments end at '-->' and cannot be nested",
            len('--'),
        )
    if ampersand >= 0 and re.fullmatch(r'&[\w#.-]*', text[ampersand:index]):
        message = "'&' starts a character's name in XML"
        return _Explanation(ampersand, message, "write &amp; for a '&'")
    return _wrong_attribute(text, index, start)


def _wrong_attribute(text: str, index: int, start: int) -> _Explanation:
    """Explain what is wrong with the tag that starts at `start`."""
    quote = _open_quote(text, start, index)
    if quote is not None and text.startswith('<', index):
        message = "the value that starts here has a '<' in it"
        hint = "write &lt; for a '<', or close the quote before it"
        return _Explanation(quote, message, hint)
    tag = re.compile(_TAG).match(text, start, index)
    found = tag and re.compile(_UNFINISHED).match(text, tag.end())
    if tag and tag.end() == index and tag['name']:
        return _Explanation(
            index,
            f"the value of '{tag['name']}' ends before this",
            'put a space between attributes; within a value in double '
            "quotes write ' or &quot;",
        )
    if found and not found['equals']:
        at, name = found.start('name'), found['name']
        message, hint = f"'{name}' has no value", f'write {name}="…"'
        return _Explanation(at, message, hint, len(name))
    if found:
        rest, at = found['rest'], found.start('rest')
        message = f"the value of '{found['name']}' has no quotes"
        hint = f'write {found["name"]}="{rest}"'
        return _Explanation(at, message, hint, max(1, len(rest)))
    return _Explanation(index, 'this cannot stand here in XML')


def _open_quote(text: str, start: int, end: int) -> int | None:
    """Return the index of the quote in a tag that is not closed before end."""
    tag = re.compile(_TAG).match(text, start, end)
    found = tag and re.compile(_UNFINISHED).match(text, tag.end())
    if found and found['rest'][:1] in ('"', "'"):
        return found.start('rest')
    return None


_XML_EXPLANATIONS: Mapping[str, Callable[[str, int], _Explanation]] = {
    codes.XML_ERROR_INVALID_TOKEN: _invalid_token,
    codes.XML_ERROR_UNCLOSED_TOKEN: _unclosed,
    codes.XML_ERROR_DUPLICATE_ATTRIBUTE: _duplicate,
    codes.XML_ERROR_JUNK_AFTER_DOC_ELEMENT: _behind_the_end,
    codes.XML_ERROR_MISPLACED_XML_PI: _before_the_start,
    codes.XML_ERROR_SYNTAX: _before_the_start,
}
