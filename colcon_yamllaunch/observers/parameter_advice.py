# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What to do about a node that refuses the type of a parameter."""

from collections.abc import Iterable
import os
import re

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.plan.plan import SetParameter
from colcon_yamllaunch.plan.position import Position

# InvalidParameterTypeException of rclpy, and that of rclcpp, which has two
# texts (exceptions.hpp and node_parameters.cpp)
_REFUSALS = tuple(
    map(
        re.compile,
        (
            r"Trying to set parameter '(?P<name>[^']+)' to '.*' of type "
            r"'(?P<got>\w+)', expecting type '(?P<wanted>\w+)'",
            r"parameter '(?P<name>[^']+)' has invalid type: "
            r'expected \[(?P<wanted>\w+)\] got \[(?P<got>\w+)\]',
            r'parameter \{(?P<name>[^}]+)\} is of type \{(?P<wanted>\w+)\}, '
            r'setting it to \{(?P<got>\w+)\} is not allowed',
        ),
    )
)
_ARRAY = '_array'
_WHOLE = re.compile(r'[-+]?\d+')
_ROUND = re.compile(r'([-+]?\d+)(?:\.0*)?')
_NUMBER = re.compile(r'[-+]?(\d+\.\d*|\.?\d+)([eE][-+]?\d+)?')
_NAMES = {'bool': 'a bool', 'integer': 'an integer', 'double': 'a double'}


def parameter_advice(
    line: str, parameters: Iterable[SetParameter]
) -> str | None:
    """
    Return the way out if a node says that a parameter has the wrong type.

    :param line: What it wrote
    :param parameters: Those that it was given, the last of a name counts
    """
    found = next(filter(None, (r.search(line) for r in _REFUSALS)), None)
    if found is None:
        return None
    name, got, wanted = found['name'], found['got'], found['wanted']
    got, wanted = got.lower(), wanted.lower()
    text = f"the node takes {_with_article(wanted)} for '{name}'"
    same_name = [p for p in parameters if p.name == name]
    # a file may have it for several nodes
    fitting = [p for p in same_name if _type_of(p.value) == got]
    if not same_name:
        return f'{text}, and it was given {_with_article(got)}'
    parameter = (fitting or same_name)[-1]
    passed = ''.join(f', passed by {_place(p)}' for p in parameter.origins)
    return (
        f'{text}: give it {_cure(parameter.value, wanted)} instead of '
        f'{parameter.value}, at {_place(parameter.position)}{passed}'
    )


def _place(position: Position) -> str:
    if os.path.islink(position.path):
        # an installed file is edited in the source
        path = os.path.realpath(position.path)
        position = Position(path, position.line, position.column)
    return events.shown(position)


def _cure(value: str, wanted: str) -> str:
    """Return what to write instead of a value."""
    element = wanted.removesuffix(_ARRAY)
    is_array = element != wanted
    plain = value.strip('[]') if is_array or value[:1] == '[' else value
    items = [_unquoted(item.strip()) for item in plain.split(',')]
    if not is_array and value[:1] == '[':
        return _with_article(wanted)
    new = [_as_type(item, element) for item in items]
    if None in new:
        return _with_article(wanted)
    joined = ', '.join(map(str, new))
    return f'[{joined}]' if is_array else joined


def _as_type(value: str, wanted: str) -> str | None:
    """Return a value as one of another type is written, if it can be."""
    if wanted == 'string':
        return f"'{value}'"
    if wanted == 'double' and _WHOLE.fullmatch(value):
        return f'{value}.0'
    if wanted == 'double' and _NUMBER.fullmatch(value):
        return value
    if wanted == 'integer' and (whole := _ROUND.fullmatch(value)):
        return whole[1]
    if wanted == 'bool' and value.lower() in ('0', 'false', 'off', 'no'):
        return 'false'
    if wanted == 'bool' and value.lower() in ('1', 'true', 'on', 'yes'):
        return 'true'
    return None


def _type_of(value: str) -> str:
    """Return the type of a value of YAML, as ROS 2 calls it."""
    if value[:1] == '[':
        first = value.strip('[]').partition(',')[0]
        return _type_of(first.strip()) + _ARRAY
    if _WHOLE.fullmatch(value):
        return 'integer'
    if _NUMBER.fullmatch(value):
        return 'double'
    return 'bool' if value.lower() in ('true', 'false') else 'string'


def _unquoted(value: str) -> str:
    is_quoted = len(value) > 1 and value[0] == value[-1] and value[0] in '"\''
    return value[1:-1] if is_quoted else value


def _with_article(kind: str) -> str:
    if kind.endswith(_ARRAY):
        return f'a list of {kind.removesuffix(_ARRAY)}s'
    return _NAMES.get(kind, f'a {kind}')
