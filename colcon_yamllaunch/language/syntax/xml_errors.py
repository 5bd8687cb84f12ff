# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What an XML syntax error means, for the person who made it."""

from collections.abc import Callable
from collections.abc import Mapping
from collections.abc import Sequence
import re
from typing import NamedTuple
from xml.parsers.expat import errors
from xml.parsers.expat import ErrorString

from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar

_SPACE = '[ \\t\\r\\n]*'
_NAME = re.compile(r'[^\s<>/="\'&]+')
_ATTRIBUTE = re.compile(
    rf'{_SPACE}(?P<name>[^\s<>/="\'&]+){_SPACE}='
    rf'{_SPACE}(?P<value>"[^"]*"|\'[^\']*\')'
)
_UNFINISHED = re.compile(
    rf'{_SPACE}(?P<name>[^\s<>/="\'&]+){_SPACE}(?P<equals>=?)'
    rf'{_SPACE}(?P<rest>[^\s<>/]*)'
)


class _Explanation(NamedTuple):
    """
    What is said of a problem.

    :param at: Where in the text
    :param length: How many characters are meant
    """

    at: int
    message: str
    hint: str | None = None
    length: int = 1


def explain(
    code: int, index: int, tags: Sequence[Scalar], source: Source
) -> LaunchError:
    """
    Return the error that a user is shown for an XML syntax error.

    :param code: What kind of problem expat sees
    :param index: The index of the character where it noticed
    :param tags: The names of the elements that are open there, outer ones
      first
    :param source: The file
    """
    message = ErrorString(code) or 'it is malformed'
    if message in _TEXTS:
        found = _Explanation(index, *_TEXTS[message])
    elif message in _EXPLANATIONS:
        found = _EXPLANATIONS[message](source.text, index)
    elif message == errors.XML_ERROR_NO_ELEMENTS:
        found = _unfinished(source, tags)
    elif message == errors.XML_ERROR_TAG_MISMATCH:
        found = _mismatch(source.text, index, tags)
    else:
        found = _Explanation(index, f'not XML: {message}')
    return error(
        found.message,
        source.position_at(found.at),
        hint=found.hint,
        length=found.length,
    )


def _unfinished(source: Source, tags: Sequence[Scalar]) -> _Explanation:
    if not tags:
        is_empty = not source.text.strip()
        what = 'is empty' if is_empty else 'has no element in it'
        hint = 'a launch file is <launch> … </launch>'
        return _Explanation(0, f'the launch file {what}', hint)
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
    if name not in {other.text for other in tags}:
        hint = did_you_mean(name, [tag]) or f'write </{tag}>'
    message = f"'{name}' is closed here, but '{tag}' from line {line} is open"
    return _Explanation(index, message, hint, len(name))


def _duplicate(text: str, index: int) -> _Explanation:
    name = _name_at(text, index)
    message = f"the attribute '{name}' stands twice in this element"
    return _Explanation(index, message, 'remove one', len(name))


def _behind_the_end(text: str, index: int) -> _Explanation:
    message = 'text stands behind the end of the launch file'
    if text.startswith('<', index):
        message = 'a second root element starts here'
    hint = 'everything stands inside of the one <launch>'
    return _Explanation(index, message, hint)


def _undefined_entity(text: str, index: int) -> _Explanation:
    # inside of a value expat names the start of the tag
    start = text.find('&', index)
    known = ('&amp;', '&lt;', '&gt;', '&quot;', '&apos;')
    while text.startswith((*known, '&#'), start):
        start = text.find('&', start + 1)
    start = index if start < 0 else start
    end = text.find(';', start) + 1
    return _Explanation(
        start,
        f"XML does not know '{text[start:end]}'",
        f"it knows {', '.join(known)}; write &amp; for a '&'",
        end - start,
    )


def _unclosed_section(text: str, index: int) -> _Explanation:
    return _unclosed(text, text.rfind('<![CDATA[', 0, index))


def _unclosed(text: str, start: int) -> _Explanation:
    for opening, what, closing in (
        ('<!--', 'comment', '-->'),
        ('<![CDATA[', 'CDATA section', ']]>'),
        ('<?', 'processing instruction', '?>'),
    ):
        if text.startswith(opening, start):
            message = f'the {what} is never closed'
            hint = f"write '{closing}' where it ends"
            return _Explanation(start, message, hint, len(opening))
    at, _ = _read_tag(text, start)
    quote = _open_quote(text, at)
    if quote is not None:
        return _unclosed_quote(quote)
    hint = "write '>' or '/>' where it ends"
    return _Explanation(start, 'the tag is never closed', hint)


def _invalid_token(text: str, index: int) -> _Explanation:
    start = text.rfind('<', 0, index)
    if start >= 0 and text.startswith('<!--', start):
        return _Explanation(
            text.rfind('--', start, index + 1),
            "a comment cannot have '--' in it",
            "comments end at '-->' and cannot be nested",
            len('--'),
        )
    if _is_bare_ampersand(text, index):
        return _Explanation(
            text.rfind('&', 0, index + 1),
            "'&' starts a character's name in XML",
            "write &amp; for a '&'",
        )
    if 0 <= start == index - 1:
        message = "'<' starts a tag in XML, and no name follows"
        return _Explanation(start, message, "write &lt; for a '<'")
    if start < 0 or '>' in _without_values(text[start:index]):
        return _Explanation(index, 'this cannot stand here in XML')
    return _wrong_attribute(text, index, start)


def _wrong_attribute(text: str, index: int, start: int) -> _Explanation:
    """Explain what is wrong with the tag that starts there."""
    at, last = _read_tag(text, start, index)
    quote = _open_quote(text, at)
    if quote is not None and quote <= index and text[index] == '<':
        if '\n' in text[quote:index]:
            return _unclosed_quote(quote)
        hint = "write &lt; for a '<', or close the quote before it"
        return _Explanation(index, "a '<' stands in a value", hint)
    if at == index and last is not None:
        return _Explanation(
            index,
            f"the value of '{last}' ends before this",
            'put a space between attributes; within a value in double '
            "quotes write ' or &quot;",
        )
    unfinished = _UNFINISHED.match(text, at)
    if unfinished is None:
        return _Explanation(
            index,
            'an attribute or the end of the tag is missing here',
            "write name=\"value\", and '>' or '/>' at the end",
        )
    name, rest = unfinished['name'], unfinished['rest']
    if not unfinished['equals']:
        at, hint = unfinished.start('name'), f'write {name}="…"'
        return _Explanation(at, f"'{name}' has no value", hint, len(name))
    return _Explanation(
        unfinished.start('rest'),
        f"the value of '{name}' has no quotes",
        f'write {name}="{rest}"',
        max(1, len(rest)),
    )


def _unclosed_quote(quote: int) -> _Explanation:
    hint = 'write the same quote where the value ends'
    return _Explanation(quote, 'the quote is never closed', hint)


def _read_tag(
    text: str, start: int, end: int | None = None
) -> tuple[int, str | None]:
    """
    Return where the attributes of a tag that are in order end, and the last.

    :param start: The index of the tag's `<`
    :param end: The index that attributes have to end at or before
    """
    name = _NAME.match(text, start + 1)
    at = name.end() if name else start + 1
    last = None
    while attribute := _ATTRIBUTE.match(text, at):
        if end is not None and attribute.end() > end:
            break
        at, last = attribute.end(), attribute['name']
    return at, last


def _open_quote(text: str, at: int) -> int | None:
    """Return the index of the quote that the next attribute starts with."""
    unfinished = _UNFINISHED.match(text, at)
    if unfinished is None or unfinished['rest'][:1] not in ('"', "'"):
        return None
    return unfinished.start('rest')


def _is_bare_ampersand(text: str, index: int) -> bool:
    at = text.rfind('&', 0, index + 1)
    return at >= 0 and re.fullmatch(r'&[\w#.-]*', text[at:index]) is not None


def _without_values(text: str) -> str:
    return re.sub(r'"[^"]*(?:"|$)|\'[^\']*(?:\'|$)', '', text)


def _name_at(text: str, index: int) -> str:
    name = _NAME.match(text, index)
    return name[0] if name else text[index : index + 1]


# what is said wherever the problem is: the message, the hint and the length.
_TEXTS: Mapping[str, tuple[str, str, int]] = {
    errors.XML_ERROR_BAD_CHAR_REF: (
        'there is no character with this number in XML',
        'write &#NUMBER; with the number of a character',
        1,
    ),
    errors.XML_ERROR_MISPLACED_XML_PI: (
        "'<?xml …?>' stands behind the start of the file",
        'remove what is before it, empty lines too',
        len('<?xml'),
    ),
    errors.XML_ERROR_SYNTAX: (
        'a launch file in XML starts with <launch>',
        'remove what is before it',
        1,
    ),
    errors.XML_ERROR_XML_DECL: (
        "the '<?xml …?>' at the start is malformed",
        'write <?xml version="1.0" encoding="UTF-8"?>, or nothing',
        1,
    ),
}
_EXPLANATIONS: Mapping[str, Callable[[str, int], _Explanation]] = {
    errors.XML_ERROR_INVALID_TOKEN: _invalid_token,
    errors.XML_ERROR_UNCLOSED_TOKEN: _unclosed,
    errors.XML_ERROR_UNCLOSED_CDATA_SECTION: _unclosed_section,
    errors.XML_ERROR_DUPLICATE_ATTRIBUTE: _duplicate,
    errors.XML_ERROR_JUNK_AFTER_DOC_ELEMENT: _behind_the_end,
    errors.XML_ERROR_UNDEFINED_ENTITY: _undefined_entity,
}
