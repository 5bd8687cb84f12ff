# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What an XML syntax error means, for the person who made it."""

from collections.abc import Callable
from collections.abc import Sequence
from dataclasses import replace
import re
from xml.parsers.expat import errors
from xml.parsers.expat import ErrorString

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.position import Position
from colcon_yamllaunch.language.syntax.source_text import Source

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


@dataclass(frozen=True, slots=True)
class Tag:
    """The start tag of an element that is not closed yet."""

    name: str
    position: Position


@dataclass(frozen=True, slots=True)
class ExpatProblem:
    """
    What expat says.

    :param code: What kind of problem
    :param index: The index of the character where it noticed
    :param tags: The elements that are open there, outer ones first
    :param is_empty: Whether there is no element before it
    """

    code: int
    index: int
    tags: Sequence[Tag]
    is_empty: bool


def explain(problem: ExpatProblem, source: Source) -> LaunchError:
    """
    Return the error that a user is shown for an XML syntax error.

    :param problem: What expat says
    :param source: The file
    """
    message = ErrorString(problem.code) or 'it is malformed'
    explanation = _EXPLANATIONS.get(message)
    if explanation is None:
        return error(f'not XML: {message}', source.position_at(problem.index))
    return explanation(problem, source)


def _unfinished(problem: ExpatProblem, source: Source) -> LaunchError:
    if problem.is_empty and not source.text.strip():
        return error(
            'the launch file is empty',
            source.position(0, 0),
            hint='a launch file is <launch> … </launch>',
        )
    if not problem.tags:
        return error(
            'the launch file has no element in it',
            source.position(0, 0),
            hint='a launch file is <launch> … </launch>',
        )
    tag = problem.tags[-1]
    return error(
        f"'{tag.name}' is never closed",
        tag.position,
        hint=f"write </{tag.name}> where it ends, or end its tag with '/>'",
        length=len(tag.name),
    )


def _mismatch(problem: ExpatProblem, source: Source) -> LaunchError:
    name = _name_at(source, problem.index)
    tag = problem.tags[-1]
    line = tag.position.line
    hint = (
        f'write </{tag.name}> before it, or end the tag in line {line} '
        "with '/>'"
    )
    if name not in {other.name for other in problem.tags}:
        hint = did_you_mean(name, [tag.name]) or f'write </{tag.name}>'
    return error(
        f"'{name}' is closed here, but '{tag.name}' from line {line} is open",
        source.position_at(problem.index),
        hint=hint,
        length=len(name),
    )


def _duplicate(problem: ExpatProblem, source: Source) -> LaunchError:
    name = _name_at(source, problem.index)
    return error(
        f"the attribute '{name}' stands twice in this element",
        source.position_at(problem.index),
        hint='remove one',
        length=len(name),
    )


def _behind_the_end(problem: ExpatProblem, source: Source) -> LaunchError:
    is_tag = source.text.startswith('<', problem.index)
    return error(
        'a second root element starts here'
        if is_tag
        else 'text stands behind the end of the launch file',
        source.position_at(problem.index),
        hint='everything stands inside of the one <launch>',
    )


def _undefined_entity(problem: ExpatProblem, source: Source) -> LaunchError:
    text = source.text
    # inside of a value expat names the start of the tag
    start = text.find('&', problem.index)
    known = ('&amp;', '&lt;', '&gt;', '&quot;', '&apos;')
    while text.startswith((*known, '&#'), start):
        start = text.find('&', start + 1)
    start = problem.index if start < 0 else start
    end = text.find(';', start) + 1
    return error(
        f"XML does not know '{text[start:end]}'",
        source.position_at(start),
        hint=f"it knows {', '.join(known)}; write &amp; for a '&'",
        length=end - start,
    )


def _bad_reference(problem: ExpatProblem, source: Source) -> LaunchError:
    return error(
        'there is no character with this number in XML',
        source.position_at(max(problem.index, 0)),
        hint='write &#NUMBER; with the number of a character',
    )


def _misplaced_declaration(
    problem: ExpatProblem, source: Source
) -> LaunchError:
    return error(
        "'<?xml …?>' stands behind the start of the file",
        source.position_at(problem.index),
        hint='remove what is before it, empty lines too',
        length=len('<?xml'),
    )


def _wrong_start(problem: ExpatProblem, source: Source) -> LaunchError:
    return error(
        'a launch file in XML starts with <launch>',
        source.position_at(problem.index),
        hint='remove what is before it',
    )


def _wrong_declaration(problem: ExpatProblem, source: Source) -> LaunchError:
    return error(
        "the '<?xml …?>' at the start is malformed",
        source.position_at(problem.index),
        hint='write <?xml version="1.0" encoding="UTF-8"?>, or nothing',
    )


def _unclosed_section(problem: ExpatProblem, source: Source) -> LaunchError:
    start = source.text.rfind('<![CDATA[', 0, problem.index)
    return _unclosed(replace(problem, index=start), source)


def _unclosed(problem: ExpatProblem, source: Source) -> LaunchError:
    text = source.text
    start = problem.index
    for opening, what, closing in (
        ('<!--', 'comment', '-->'),
        ('<![CDATA[', 'CDATA section', ']]>'),
        ('<?', 'processing instruction', '?>'),
    ):
        if text.startswith(opening, start):
            return error(
                f'the {what} is never closed',
                source.position_at(start),
                hint=f"write '{closing}' where it ends",
                length=len(opening),
            )
    at, _ = _read_tag(text, start)
    open_quote = _open_quote(text, at)
    if open_quote is not None:
        return _unclosed_quote(open_quote, source)
    return error(
        'the tag is never closed',
        source.position_at(start),
        hint="write '>' or '/>' where it ends",
    )


def _invalid_token(problem: ExpatProblem, source: Source) -> LaunchError:
    text, index = source.text, problem.index
    position = source.position_at(index)
    start = text.rfind('<', 0, index)
    if start >= 0 and text.startswith('<!--', start):
        return error(
            "a comment cannot have '--' in it",
            source.position_at(text.rfind('--', start, index + 1)),
            hint="comments end at '-->' and cannot be nested",
            length=len('--'),
        )
    if _is_bare_ampersand(text, index):
        at = text.rfind('&', 0, index + 1)
        return error(
            "'&' starts a character's name in XML",
            source.position_at(at),
            hint="write &amp; for a '&'",
        )
    if 0 <= start == index - 1:
        return error(
            "'<' starts a tag in XML, and no name follows",
            source.position_at(start),
            hint="write &lt; for a '<'",
        )
    if start < 0 or '>' in _without_values(text[start:index]):
        return error('this cannot stand here in XML', position)
    return _wrong_attribute(index, start, source)


def _wrong_attribute(index: int, start: int, source: Source) -> LaunchError:
    """Explain what is wrong with the tag that starts there."""
    text = source.text
    at, last = _read_tag(text, start, index)
    quote = _open_quote(text, at)
    if quote is not None and quote <= index and text[index] == '<':
        if '\n' in text[quote:index]:
            return _unclosed_quote(quote, source)
        return error(
            "a '<' stands in a value",
            source.position_at(index),
            hint="write &lt; for a '<', or close the quote before it",
        )
    if at == index and last is not None:
        return error(
            f"the value of '{last}' ends before this",
            source.position_at(index),
            hint='put a space between attributes; within a value in double '
            "quotes write ' or &quot;",
        )
    unfinished = _UNFINISHED.match(text, at)
    if unfinished is None:
        return error(
            'an attribute or the end of the tag is missing here',
            source.position_at(index),
            hint="write name=\"value\", and '>' or '/>' at the end",
        )
    name, rest = unfinished['name'], unfinished['rest']
    if not unfinished['equals']:
        return error(
            f"'{name}' has no value",
            source.position_at(unfinished.start('name')),
            hint=f'write {name}="…"',
            length=len(name),
        )
    return error(
        f"the value of '{name}' has no quotes",
        source.position_at(unfinished.start('rest')),
        hint=f'write {name}="{rest}"',
        length=max(1, len(rest)),
    )


def _unclosed_quote(quote: int, source: Source) -> LaunchError:
    return error(
        'the quote is never closed',
        source.position_at(quote),
        hint='write the same quote where the value ends',
    )


def _read_tag(
    text: str, start: int, end: int | None = None
) -> tuple[int, str | None]:
    """
    Read the attributes of a tag as far as they are in order.

    :param start: The index of the tag's `<`
    :param end: The index that attributes have to end at or before
    :returns: Where they end, and the name of the last one
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


def _name_at(source: Source, index: int) -> str:
    name = _NAME.match(source.text, index)
    return name[0] if name else source.text[index : index + 1]


_EXPLANATIONS: dict[str, Callable[[ExpatProblem, Source], LaunchError]] = {
    errors.XML_ERROR_NO_ELEMENTS: _unfinished,
    errors.XML_ERROR_INVALID_TOKEN: _invalid_token,
    errors.XML_ERROR_UNCLOSED_TOKEN: _unclosed,
    errors.XML_ERROR_UNCLOSED_CDATA_SECTION: _unclosed_section,
    errors.XML_ERROR_TAG_MISMATCH: _mismatch,
    errors.XML_ERROR_DUPLICATE_ATTRIBUTE: _duplicate,
    errors.XML_ERROR_JUNK_AFTER_DOC_ELEMENT: _behind_the_end,
    errors.XML_ERROR_UNDEFINED_ENTITY: _undefined_entity,
    errors.XML_ERROR_BAD_CHAR_REF: _bad_reference,
    errors.XML_ERROR_MISPLACED_XML_PI: _misplaced_declaration,
    errors.XML_ERROR_SYNTAX: _wrong_start,
    errors.XML_ERROR_XML_DECL: _wrong_declaration,
}
