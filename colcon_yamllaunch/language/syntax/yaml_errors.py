# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a YAML syntax error means, for the person who made it."""

from collections.abc import Callable
from contextlib import suppress
import re

from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.plan.position import Position
import yaml

_ITEM = re.compile(r'\s*-(\s|$)')
_KEY_WITHOUT_SPACE = re.compile(r'(\s*(?:- )?)([\w-]+):[^\s/]')
_BARE_WORD = re.compile(r'\s*(?:- )?(\w+)\s*$')
_NO_BREAK_SPACE = '\u00a0'
_COMMENT_OR_BLANK = re.compile(r'\s*(#|$)')


def explain(problem: yaml.YAMLError, source: Source) -> LaunchError:
    """
    Return the error that a user is shown for a YAML syntax error.

    :param problem: What PyYAML, or libyaml below it, says
    :param source: The file
    """
    mark = getattr(problem, 'problem_mark', None)
    if not isinstance(problem, yaml.MarkedYAMLError) or mark is None:
        return error(f'{source.path} is not YAML: {problem}')
    text = problem.problem or ''
    for words, explanation in _EXPLANATIONS:
        if words in text:
            return explanation(mark, problem.context_mark or mark, source)
    return error(f'not YAML: {text}', _position(source, mark))


def _wrong_character(
    mark: yaml.Mark, _opened: yaml.Mark, source: Source
) -> LaunchError:
    character = _line(source, mark.line)[mark.column : mark.column + 1]
    if character == '\t':
        return error(
            'a tab stands where YAML wants spaces',
            _position(source, mark),
            hint='indent with spaces',
        )
    if not character.strip():
        return error(
            'a value is missing here',
            _position(source, mark),
            hint='is a bracket not closed?',
        )
    return error(
        f"a value cannot start with '{character}'",
        _position(source, mark),
        hint='quote the value',
    )


def _wrong_name_of_anchor(
    _mark: yaml.Mark, opened: yaml.Mark, source: Source
) -> LaunchError:
    return _wrong_character(opened, opened, source)


def _missing_colon(
    _mark: yaml.Mark, opened: yaml.Mark, source: Source
) -> LaunchError:
    return error(
        "there is no ':' in this line",
        _position(source, opened),
        hint="write 'name: value', or indent the line deeper if it goes on "
        'with the value before it',
    )


def _wrong_indentation(
    mark: yaml.Mark, _opened: yaml.Mark, source: Source
) -> LaunchError:
    line = _line(source, mark.line)
    if line[: mark.column].strip() not in ('', '-'):
        return _late_quote(mark, source) or error(
            'the value ended before this text',
            _position(source, mark),
            hint='quote the whole value',
        )
    is_item = _ITEM.match(line, mark.column) is not None
    what = 'list item' if is_item else 'line'
    neighbour = _neighbour(source, mark.line, mark.column, is_item)
    if neighbour is None:
        return error(
            f'this {what} does not belong to anything before it',
            _position(source, mark),
            hint='check its indentation',
        )
    number, column = neighbour
    before = 'the item' if is_item else 'the line'
    return error(
        f'this {what} is indented by {_spaces(mark.column)}, but {before} '
        f'before it (line {number + 1}) by {_spaces(column)}',
        _position(source, mark),
        hint='indent both by the same number of spaces',
    )


def _neighbour(
    source: Source, number: int, column: int, is_item: bool
) -> tuple[int, int] | None:
    """Find the line whose indentation this line was meant to have."""
    deeper: tuple[int, int] | None = None
    for other in range(number - 1, -1, -1):
        line = _line(source, other)
        if _COMMENT_OR_BLANK.match(line):
            continue
        indent = len(line) - len(line.lstrip(' '))
        alike = bool(_ITEM.match(line)) == is_item
        if not alike and not is_item and _ITEM.match(line):
            # the key behind the dash of a list item
            indent += len(line) - indent - len(line[indent + 1 :].lstrip())
            alike = True
        if alike and indent > column:
            if deeper is None or indent < deeper[1]:
                deeper = (other, indent)
        elif deeper is not None and indent <= column:
            break
        elif alike and indent < column:
            return (other, indent)
    return deeper


def _misplaced_colon(
    mark: yaml.Mark, _opened: yaml.Mark, source: Source
) -> LaunchError:
    line = _line(source, mark.line)
    if re.search(r'[\w\'"]:\s', line[: mark.column]):
        return _late_quote(mark, source) or error(
            "a value with ': ' in it must be quoted",
            _position(source, mark),
        )
    for number in range(mark.line - 1, -1, -1):
        before = _line(source, number)
        if _COMMENT_OR_BLANK.match(before):
            continue
        glued = _KEY_WITHOUT_SPACE.match(before)
        if glued:
            return error(
                f"there is no space after '{glued[2]}:'",
                source.position(number, glued.end(2)),
            )
        if _NO_BREAK_SPACE in before:
            return error(
                'a no-break space stands here, which is no space for YAML',
                source.position(number, before.index(_NO_BREAK_SPACE)),
                hint='type it anew as a space',
            )
        bare = _BARE_WORD.match(before)
        if bare and _depth(before) < _depth(line):
            return error(
                f"there is no ':' behind '{bare[1]}'",
                source.position(number, bare.start(1)),
                hint=f"write '{bare[1]}:'",
                length=len(bare[1]),
            )
        if _depth(before) == _depth(line) and ':' not in before:
            return error(
                "there is no ':' in this line",
                source.position(number, _depth(before)),
                hint="write 'name: value'",
            )
        break
    indent = len(line) - len(line.lstrip())
    return error(
        f'this line is indented by {_spaces(indent)}, deeper than the lines '
        'that it belongs with',
        source.position(mark.line, indent),
        hint='indent it as the line before',
    )


def _unclosed_bracket(
    mark: yaml.Mark, opened: yaml.Mark, source: Source
) -> LaunchError:
    bracket = _line(source, opened.line)[opened.column : opened.column + 1]
    closing = '}' if bracket == '{' else ']'
    if mark.line >= source.text.count('\n') or mark.line != opened.line:
        return _late_quote(mark, source) or error(
            f"this '{bracket}' is not closed",
            _position(source, opened),
            hint=f"add the '{closing}', or quote the value if '{bracket}' "
            'belongs to it',
        )
    return error(
        f"'{closing}' or ',' is missing before this",
        _position(source, mark),
        hint='quote the value if this belongs to it',
    )


def _unclosed_quote(
    _mark: yaml.Mark, opened: yaml.Mark, source: Source
) -> LaunchError:
    return error('this quote is not closed', _position(source, opened))


def _late_quote(mark: yaml.Mark, source: Source) -> LaunchError | None:
    """
    Find the quote that ends in a later line, with more text behind it.

    One that was forgotten is closed by that which opens the next.
    """
    with suppress(yaml.YAMLError):
        for token in yaml.scan(source.text):
            opened, ended = token.start_mark, token.end_mark
            if ended.line > mark.line:
                break
            is_quoted = isinstance(token, yaml.ScalarToken) and token.style
            if not is_quoted or not opened.line < ended.line == mark.line:
                continue
            more = _line(source, ended.line)[ended.column :].lstrip()
            if more and more[0] not in ',]}:#':
                return error(
                    f'this quote ends only in line {ended.line + 1}, where '
                    'other text follows it',
                    _position(source, opened),
                    hint='close it where its value ends',
                )
    return None


def _unknown_escape(
    mark: yaml.Mark, opened: yaml.Mark, source: Source
) -> LaunchError:
    if _line(source, mark.line)[mark.column :] == '\\':
        return _unclosed_quote(mark, opened, source)
    return error(
        "YAML does not know this '\\' in double quotes",
        _position(source, mark),
        hint="use single quotes, or double the backslash: '\\\\'",
    )


_EXPLANATIONS: tuple[
    tuple[str, Callable[[yaml.Mark, yaml.Mark, Source], LaunchError]], ...
] = (
    ('cannot start any token', _wrong_character),
    ('node content', _wrong_character),
    ('alphabetic or numeric character', _wrong_name_of_anchor),
    ("could not find expected ':'", _missing_colon),
    ('did not find expected key', _wrong_indentation),
    ("did not find expected '-'", _wrong_indentation),
    ('expected <block end>', _wrong_indentation),
    ('mapping values are not allowed', _misplaced_colon),
    ("expected ',' or", _unclosed_bracket),
    ('unexpected end of stream', _unclosed_quote),
    ('unknown escape character', _unknown_escape),
    ('expected hexdecimal number', _unknown_escape),
    ('hexadecimal numbers', _unknown_escape),
)


def _position(source: Source, mark: yaml.Mark) -> Position:
    if mark.line > source.text.count('\n'):
        # libyaml sees a line end that is not there behind the last line
        return source.position_at(len(source.text))
    return source.position(mark.line, mark.column)


def _line(source: Source, number: int) -> str:
    lines = source.text.split('\n')
    return lines[number] if number < len(lines) else ''


def _depth(line: str) -> int:
    """Return the column of the key or value in a line."""
    item = _ITEM.match(line)
    start = item.end() if item else 0
    return start + len(line[start:]) - len(line[start:].lstrip())


def _spaces(count: int) -> str:
    return '1 space' if count == 1 else f'{count} spaces'
