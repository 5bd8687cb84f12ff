# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The JSON Schema of launch files in YAML, from the table of actions.

It is a draft-07 schema: that draft is what editors' YAML support knows best.
VS Code's (yaml-language-server) validates by it in every version, by later
drafts only since 2025 and in part.
"""

from collections.abc import Mapping
import json
import re

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
    RELEASES,
    Type,
)

Schema = dict[str, object]

#: The draft of JSON Schema that the schema is written in.
DRAFT = 'http://json-schema.org/draft-07/schema#'

# a text whose value shows only when it is evaluated: it has a substitution,
# or a backslash, which evaluating takes away
_OPEN = r'\$\(|\\'
_SCALARS = ['string', 'number', 'boolean']
_NUMBER = r'[+-]?([0-9][0-9_]*\.?[0-9_]*|\.[0-9][0-9_]*)([eE][+-]?[0-9]+)?'


def json_schema(exposed: Mapping[str, str]) -> Schema:
    """
    Return the JSON Schema of launch files in YAML.

    It says what the reader checks without evaluating a file, as far as a
    schema can: not whether a package exists or a substitution is well-formed,
    and not whether a key stands twice.

    :param exposed: The actions of other packages, with the package of each;
      of these it knows the conditions only
    """
    return {
        '$schema': DRAFT,
        'title': 'ROS 2 launch file',
        'description': 'A launch file in YAML, as colcon launch runs it.',
        'type': 'object',
        'required': ['launch'],
        'additionalProperties': False,
        'properties': {'launch': _root()},
        'definitions': {
            'actions': {'type': 'array', 'items': _ref('action')},
            'action': _any_action(exposed),
            'exposed': _exposed(),
            'parameters': _list_of(_parameter()),
            **_value_definitions(),
            **{name: _action(action) for name, action in ACTIONS.items()},
            **{name: _action(action) for name, action in COMPONENTS.items()},
        },
    }


def schema_text(exposed: Mapping[str, str]) -> str:
    """
    Return the JSON Schema as text, one line end at its end.

    :param exposed: See :func:`json_schema`
    """
    schema = json_schema(exposed)
    return json.dumps(schema, indent=2, ensure_ascii=False) + '\n'


def _root() -> Schema:
    mapping = {
        'type': 'object',
        'required': ['children'],
        'additionalProperties': False,
        'properties': {
            'children': {
                'description': 'The actions, in order.',
                'allOf': [_ref('actions')],
            },
            'deprecated': {
                'description': 'Why the launch file should not be used any '
                'more.',
                'type': [*_SCALARS, 'null'],
            },
        },
    }
    return {
        'description': 'The actions, in order.',
        'anyOf': [_ref('actions'), mapping],
    }


def _any_action(exposed: Mapping[str, str]) -> Schema:
    names = {**{name: name for name in ACTIONS}, **ALIASES}
    return {
        'description': 'An action: its name, and its attributes below it.',
        'type': 'object',
        'minProperties': 1,
        'maxProperties': 1,
        'additionalProperties': False,
        'properties': {
            name: {
                'description': _description(ACTIONS[action]),
                'allOf': [_ref(action)],
            }
            for name, action in names.items()
        }
        | {
            name: {
                'description': f'An action of the package {package}.',
                'allOf': [_ref('exposed')],
            }
            for name, package in sorted(exposed.items())
            if name not in names
        },
    }


def _exposed() -> Schema:
    """Return the schema for an action of another package."""
    return {
        'type': ['object', 'array', 'null'],
        'properties': {a.name: _attribute(a) for a in CONDITIONS},
        'not': {'type': 'object', 'required': ['if', 'unless']},
    }


def _action(action: Action) -> Schema:
    schema = {
        **_object(action.attributes),
        'not': {'required': ['if', 'unless']},
    }
    if {a.name for a in action.attributes if a.required} == {'children'}:
        # it may be written as the list of its children
        schema = {'anyOf': [_ref('actions'), schema]}
    return {'description': _description(action), **schema}


def _object(attributes: tuple[Attribute, ...]) -> Schema:
    schema: Schema = {
        'type': 'object',
        'additionalProperties': False,
        'properties': {a.name: _attribute(a) for a in attributes},
    }
    required = [a.name for a in attributes if a.required]
    if required:
        schema['required'] = required
    return schema


def _attribute(attribute: Attribute) -> Schema:
    return {'description': _description(attribute), **_value(attribute)}


def _description(entry: Action | Attribute) -> str:
    sentences = [entry.help]
    if isinstance(entry, Attribute) and entry.default is not None:
        sentences.append(f"Default: '{entry.default}'.")
    if entry.since not in (None, RELEASES[0]):
        sentences.append(f'ROS 2 has it since {entry.since}.')
    return ' '.join(sentences)


def _value(attribute: Attribute) -> Schema:
    if attribute.type is Type.ITEMS:
        items = items_of(attribute)
        if items is PARAMETER:
            return {'allOf': [_ref('parameters')]}
        if attribute.name in COMPONENTS:
            return _list_of(_ref(attribute.name))
        return _list_of(_object(items))
    if attribute.values:
        return _enumeration(attribute)
    if attribute.pattern is not None:
        return _text(attribute.pattern)
    if attribute.type is Type.NAME:
        return {'type': ['string', 'number']}
    if attribute.type in (Type.TEXT, Type.PLAIN):
        return {'type': _SCALARS}
    if attribute.type is Type.COMMAND and attribute.required:
        return {'allOf': [_ref(_name(attribute.type))], 'minItems': 1}
    return {'allOf': [_ref(_name(attribute.type))]}


def _enumeration(attribute: Attribute) -> Schema:
    """Return the schema for one of some values, which an editor lists."""
    values = list(attribute.values)
    if attribute.type is Type.PLAIN:
        return {'enum': values}
    pattern = '|'.join(
        _any_case(value) if attribute.ignore_case else value
        for value in values
    )
    return {'anyOf': [{'enum': values}, _text(pattern)]}


def _value_definitions() -> dict[str, Schema]:
    scalar: Schema = {'type': _SCALARS}
    true = '|'.join(map(_any_case, ('true', 'false')))
    yaml_11 = '|'.join(
        word
        for lower in ('true', 'false', 'yes', 'no', 'on', 'off')
        for word in (lower, lower.capitalize(), lower.upper())
    )
    binary: Schema = {'enum': [0, 1, True, False]}
    return {
        _name(kind): {'anyOf': forms}
        for kind, forms in {
            Type.CONDITION: [binary, _text(rf'\s*({true}|0|1)\s*')],
            Type.BOOLEAN: [binary, _text(rf'\s*({yaml_11}|0|1)\s*')],
            Type.INTEGER: [
                {'type': 'integer'},
                _text(r'\s*[+-]?[0-9][0-9_]*\s*'),
            ],
            Type.SECONDS: [
                {'type': 'number', 'minimum': 0},
                _text(rf'\s*{_NUMBER}\s*'),
            ],
            Type.COMMAND: [scalar, {'type': 'array', 'items': scalar}],
            Type.VALUE: [scalar, *_uniform_lists()],
        }.items()
    }


def _uniform_lists() -> list[Schema]:
    """Return the lists that a parameter can be: of one type each."""
    unknown: Schema = {'type': 'string', 'pattern': _OPEN}
    return [
        {'type': 'array', 'items': items}
        for items in (
            {'type': 'string'},
            {'anyOf': [{'type': 'number'}, unknown]},
            {'anyOf': [{'type': 'boolean'}, unknown]},
        )
    ]


def _parameter() -> Schema:
    """Return the schema for one parameter, which has one of three forms."""
    forms = (
        (('from',), ('from', 'allow_substs')),
        (('name', 'value'), ('name', 'value', 'type')),
        (('name', 'param'), ('name', 'param')),
    )
    attributes = by_name(PARAMETER)
    return {
        'anyOf': [
            {
                **_object(tuple(attributes[name] for name in names)),
                'required': list(required),
            }
            for required, names in forms
        ]
    }


def _list_of(items: Schema) -> Schema:
    return {'type': 'array', 'minItems': 1, 'items': items}


def _text(pattern: str) -> Schema:
    """Return the schema for a text that has a pattern once evaluated."""
    return {'type': 'string', 'pattern': f'^({pattern})$|{_OPEN}'}


def _any_case(word: str) -> str:
    # JSON Schema's patterns have no flags
    return ''.join(
        f'[{letter.upper()}{letter.lower()}]' for letter in re.escape(word)
    )


def _name(kind: Type) -> str:
    return kind.value.replace(' ', '_')


def _ref(name: str) -> Schema:
    return {'$ref': f'#/definitions/{name}'}
