# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The problems that a check found, for people and for programs.

`as_github` is for the log of a GitHub workflow, `as_sarif` for what reads
SARIF 2.1.0 (code scanning, editors), `as_json` for everything else, and
`show_arguments` for the launch arguments that it found.
"""

from collections.abc import Iterator, Mapping, Sequence
import json
import os
from pathlib import Path
from typing import Any, TYPE_CHECKING
from urllib.parse import quote

from colcon_yamllaunch import __version__
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.language.evaluation.findings import (
    CheckResult,
    DeclaredArgument,
)
from colcon_yamllaunch.language.syntax.diagnostics import (
    Diagnostic,
    render,
    Severity,
)
from colcon_yamllaunch.plan.position import (
    Position,
    shown_path,
    shown_position,
)

if TYPE_CHECKING:
    from colcon_yamllaunch.language.policies.check import Declarations


def annotation(diagnostic: Diagnostic, root: str) -> str:
    """
    Return the line that makes GitHub show a problem beside its source.

    :param diagnostic: The problem
    :param root: The root of the repository, which paths are relative to
    """
    properties = []
    position = diagnostic.position
    if position is not None:
        path = shown_path(position.path, root)
        properties = [
            f'file={_escape_property(path)}',
            f'line={position.line}',
            f'col={position.column}',
            f'endColumn={position.column + diagnostic.length}',
        ]
    command = f'{diagnostic.severity} {",".join(properties)}'.rstrip()
    return f'::{command}::{_escape_data(with_hint(diagnostic))}'


def with_hint(diagnostic: Diagnostic) -> str:
    """Return what is wrong and, in a second line, the way out."""
    if diagnostic.hint is None:
        return diagnostic.message
    return f'{diagnostic.message}\nhelp: {diagnostic.hint}'


def _escape_data(text: str) -> str:
    # as the toolkit of GitHub Actions does (escapeData in its command.ts)
    return text.replace('%', '%25').replace('\r', '%0D').replace('\n', '%0A')


def _escape_property(text: str) -> str:
    return _escape_data(text).replace(':', '%3A').replace(',', '%2C')


#: The version of what `as_json` returns: greater when a member is renamed or
#: removed or means something else; new members do not change it.
JSON_VERSION = 1

_SARIF_SCHEMA = 'https://json.schemastore.org/sarif-2.1.0.json'
_RULES: Mapping[Severity, tuple[str, str]] = {
    'error': ('launch-error', 'The launch file cannot be launched as it is.'),
    'warning': ('launch-warning', 'The launch file may not do what is meant.'),
}


def as_text(checked: CheckResult, cwd: str) -> str:
    """
    Lay the problems out as a compiler does, with their number at the end.

    :param cwd: The folder that paths are shown relative to
    """
    parts = [render(checked.diagnostics, cwd), _summary(checked)]
    return '\n'.join(part for part in parts if part)


def as_json(checked: CheckResult, cwd: str) -> str:
    """
    Return the problems as a JSON object.

    Its members are `version` (see :data:`JSON_VERSION`), `files` (the launch
    files that were read, the given one first) and `diagnostics`, in the order
    found. Each of these has `severity` (`error` or `warning`), `message`,
    `help` (the way out, or null), `path`, `line` and `column` (counted from 1;
    all three null for the command line), `length` (in characters) and
    `includes`: `path`, `line` and `column` of each include that led there,
    innermost first.

    :param cwd: The folder that paths below it are relative to
    """
    document = {
        'version': JSON_VERSION,
        'files': [shown_path(file.path, cwd) for file in checked.files],
        'diagnostics': [_json(d, cwd) for d in checked.diagnostics],
    }
    return json.dumps(document, indent=2, ensure_ascii=False)


def as_github(checked: CheckResult, cwd: str) -> str:
    """
    Return the problems as GitHub's workflow commands, one a line.

    GitHub shows them beside the lines of a pull request.

    :param cwd: The root of the repository, which paths are relative to
    """
    return '\n'.join(
        [*(annotation(d, cwd) for d in checked.diagnostics), _summary(checked)]
    )


def as_sarif(checked: CheckResult, cwd: str) -> str:
    """
    Return the problems as a log of SARIF 2.1.0 (OASIS).

    :param cwd: The root of the repository, which paths are relative to
    """
    driver = {
        'name': 'colcon-yamllaunch',
        'version': __version__,
        'rules': [
            {'id': rule, 'shortDescription': {'text': text}}
            for rule, text in _RULES.values()
        ],
    }
    root = f'{_uri(cwd)}/' if cwd != '/' else 'file:///'
    run = {
        'tool': {'driver': driver},
        'columnKind': 'unicodeCodePoints',
        'originalUriBaseIds': {'SRCROOT': {'uri': root}},
        'results': [_sarif(d, cwd) for d in checked.diagnostics],
    }
    log = {'$schema': _SARIF_SCHEMA, 'version': '2.1.0', 'runs': [run]}
    return json.dumps(log, indent=2, ensure_ascii=False)


def _summary(checked: CheckResult) -> str:
    counts = dict.fromkeys(_RULES, 0)
    for diagnostic in checked.diagnostics:
        counts[diagnostic.severity] += 1
    found = [_count(n, name) for name, n in counts.items() if n]
    files = _count(len(checked.files), 'launch file')
    return f'{", ".join(found) or "no problems"} in {files}'


def _count(number: int, name: str) -> str:
    return f'{number} {name}' if number == 1 else f'{number} {name}s'


def _json(diagnostic: Diagnostic, cwd: str) -> dict[str, Any]:
    return {
        'severity': diagnostic.severity,
        'message': diagnostic.message,
        'help': diagnostic.hint,
        **_json_place(diagnostic.position, cwd),
        'length': diagnostic.length,
        'includes': [_json_place(p, cwd) for p in diagnostic.includes],
    }


def _json_place(position: Position | None, cwd: str) -> dict[str, Any]:
    if position is None:
        return {'path': None, 'line': None, 'column': None}
    return {
        'path': shown_path(position.path, cwd),
        'line': position.line,
        'column': position.column,
    }


def _sarif(diagnostic: Diagnostic, cwd: str) -> dict[str, Any]:
    names: Sequence[Severity] = list(_RULES)
    result: dict[str, Any] = {
        'ruleId': _RULES[diagnostic.severity][0],
        'ruleIndex': names.index(diagnostic.severity),
        'level': diagnostic.severity,
        'message': {'text': with_hint(diagnostic)},
    }
    position = diagnostic.position
    if position is not None:
        place = _sarif_place(position, cwd, diagnostic.length)
        result['locations'] = [{'physicalLocation': place}]
    if diagnostic.includes:
        result['relatedLocations'] = [
            {
                'physicalLocation': _sarif_place(include, cwd),
                'message': {'text': 'included from here'},
            }
            for include in diagnostic.includes
        ]
    return result


def _sarif_place(
    position: Position, cwd: str, length: int | None = None
) -> dict[str, Any]:
    path = shown_path(position.path, cwd)
    artifact = {'uri': quote(path), 'uriBaseId': 'SRCROOT'}
    if os.path.isabs(path):
        artifact = {'uri': _uri(path)}
    region = {'startLine': position.line, 'startColumn': position.column}
    if length is not None:
        region['endColumn'] = position.column + length
    return {'artifactLocation': artifact, 'region': region}


def _uri(path: str) -> str:
    return Path(path).as_uri()


_INDENT = ' ' * 8


def show_arguments(declarations: 'Declarations', cwd: str) -> str:
    """
    Lay the launch arguments of a launch file out.

    The layout is that of `ros2 launch --show-args`, with more lines in it:
    where each argument is declared, and which includes could not be followed.
    There is no line end after the last line.

    :param cwd: The folder that paths are shown relative to
    """
    return '\n'.join(_lines(declarations, cwd))


def _lines(declarations: 'Declarations', cwd: str) -> Iterator[str]:
    arguments = declarations.arguments
    yield "Arguments (pass arguments as '<name>:=<value>'):"
    for argument in arguments:
        yield ''
        yield from _argument(argument, cwd)
    if not arguments:
        yield ''
        yield '  No arguments.'
    if any(argument.is_conditional for argument in arguments):
        yield ''
        yield (
            '* argument(s) which are only used if specific conditions occur'
        )
    if declarations.not_followed:
        yield ''
        yield 'Includes that may have more arguments:'
        for position, reason in declarations.not_followed.items():
            yield ''
            yield f'    {shown_position(position, cwd)}:'
            yield _indented(reason)


def _argument(argument: DeclaredArgument, cwd: str) -> Iterator[str]:
    mark = '*' if argument.is_conditional else ''
    yield f"    '{one_line(argument.name)}':{mark}"
    yield _indented(_description(argument))
    if argument.default is None:
        yield f'{_INDENT}(required)'
    else:
        yield _indented(f"(default: '{argument.default}')")
    yield f'{_INDENT}(declared at {shown_position(argument.position, cwd)})'
    if argument.set_at is not None:
        place = shown_position(argument.set_at, cwd)
        yield f'{_INDENT}(always set at {place})'


def _description(argument: DeclaredArgument) -> str:
    # the words are ROS 2's (DeclareLaunchArgument)
    choices = ', '.join(f"'{choice}'" for choice in argument.choices)
    if argument.description is None:
        return f'One of: [{choices}]' if choices else 'no description given'
    if not choices:
        return argument.description
    stop = '' if argument.description.endswith('.') else '.'
    return f'{argument.description}{stop} Valid choices are: [{choices}]'


def _indented(text: str) -> str:
    lines = text.rstrip('\n').split('\n')
    return '\n'.join(f'{_INDENT}{line}'.rstrip() for line in lines)
