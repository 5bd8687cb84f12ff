# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The reference page of launch files, from the tables of the language.

`python tools/launch_files_page.py` writes it to the standard
output; `docs/launch_files.md` is what it wrote.
"""

from collections.abc import Iterable, Sequence
import sys

from colcon_yamllaunch.language.vocabulary.actions import (
    Action,
    ACTIONS,
    ALIASES,
    Attribute,
    by_name,
    COMPONENTS,
    CONDITIONS,
    items_of,
    PARAMETER,
)
from colcon_yamllaunch.language.vocabulary.substitutions import KINDS
from launch_examples import EXAMPLES
from launch_files_text import COMPONENTS as COMPONENTS_TEXT
from launch_files_text import DIFFERENCES, EXPOSED, INTRODUCTION, PARAMETERS

_MARK = (
    '<!-- made by `python tools/launch_files_page.py`: change '
    'the tables that it reads, not this file -->\n'
)


def reference_page() -> str:
    """Return the page in Markdown, one sentence a line."""
    parts = (
        _MARK,
        INTRODUCTION,
        DIFFERENCES,
        *_actions(),
        *_substitutions(),
        '## Actions and substitutions of other packages\n',
        EXPOSED.rstrip('\n'),
        '',
    )
    return '\n'.join(parts)


def _actions() -> Iterable[str]:
    yield '## Actions\n'
    yield (
        'Every action also takes `if` and `unless`: see '
        '[Conditions](#conditions).\n'
    )
    yield _table(
        ('action', 'what it does'),
        (
            (f'[`{action.name}`](#{action.name})', action.help)
            for action in ACTIONS.values()
        ),
    )
    for name, action in ACTIONS.items():
        yield _action(action, EXAMPLES[name])
        if name == 'node':
            yield _parameters()
        elif name == 'node_container':
            yield _components()


def _action(action: Action, example: str) -> str:
    attributes = [a for a in action.attributes if a not in CONDITIONS]
    notes = [_since(action.since)]
    notes += [
        f'`{alias}` is the same.'
        for alias, name in ALIASES.items()
        if name == action.name
    ]
    twin = _twin(action)
    if twin is not None:
        known = by_name(twin.attributes)
        attributes = [
            a
            for a in attributes
            if a.name not in known or a.required > known[a.name].required
        ]
        end = ', and:' if attributes else '.'
        name = twin.name
        notes.append(f'The attributes are those of [`{name}`](#{name}){end}')
    elif not attributes:
        notes.append('It has no attributes: write `{}`.')
    parts = [f'### {action.name}', '', action.help, *notes, '']
    if attributes:
        parts += [_attributes(attributes, action.since)]
    return '\n'.join([*parts, _code(example)])


def _twin(action: Action) -> Action | None:
    """Return the action before this whose attributes it has, too."""
    own = by_name(action.attributes)
    for other in ACTIONS.values():
        if other is action:
            return None
        is_long = len(other.attributes) > len(PARAMETER) + len(CONDITIONS)
        if is_long and by_name(other.attributes).keys() <= own.keys():
            return other
    return None


def _since(release: str) -> str:
    return f'Since {release}.'


def _attributes(attributes: Iterable[Attribute], since: str) -> str:
    return _table(
        ('attribute', 'type', 'default', 'since', 'meaning'),
        (
            (
                f'`{attribute.name}`',
                attribute.type.value,
                _default(attribute),
                attribute.since or since,
                _meaning(attribute),
            )
            for attribute in attributes
        ),
    )


def _default(attribute: Attribute) -> str:
    if attribute.required:
        return 'required'
    return '' if attribute.default is None else f'`{attribute.default}`'


def _meaning(attribute: Attribute) -> str:
    text = attribute.help
    items = items_of(attribute)
    if items is PARAMETER:
        text += ' Items: see [Parameters](#parameters).'
    elif attribute.name in COMPONENTS:
        text += ' Items: see [Components](#components).'
    elif items:
        text += f' Items: {_names(a.name for a in items)}.'
    if attribute.values:
        text += f' One of {_names(attribute.values)}.'
    return text


def _names(names: Iterable[str]) -> str:
    return ', '.join(f'`{name}`' for name in names)


def _parameters() -> str:
    return '\n'.join(
        (
            '#### Parameters',
            '',
            PARAMETERS,
            _attributes(PARAMETER, ACTIONS['node'].since),
        )
    )


def _components() -> str:
    plain, lifecycle = COMPONENTS.values()
    attributes = [a for a in plain.attributes if a not in CONDITIONS]
    more = [a for a in lifecycle.attributes if a not in plain.attributes]
    return '\n'.join(
        (
            '#### Components',
            '',
            COMPONENTS_TEXT,
            _attributes(attributes, plain.since),
            f'An item of `{lifecycle.name}` has these besides:',
            '',
            _attributes(more, lifecycle.since),
        )
    )


def _substitutions() -> Iterable[str]:
    yield '## Substitutions\n'
    yield 'Arguments in brackets may be left out.'
    yield (
        'A condition is `true`, `1`, `yes` or `on`, or `false`, `0`, `no` or '
        '`off`.\n'
    )
    yield _table(
        ('substitution', 'what it comes to', 'since', 'example'),
        (
            (f'`{kind.usage}`', kind.help, kind.since, f'`{kind.example}`')
            for kind in KINDS.values()
        ),
    )


def _code(example: str) -> str:
    return f'```yaml\n{example.rstrip()}\n```\n'


def _table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [header, ['---'] * len(header), *rows]
    return ''.join(f'| {" | ".join(line)} |\n' for line in lines)


if __name__ == '__main__':
    sys.stdout.write(reference_page())
