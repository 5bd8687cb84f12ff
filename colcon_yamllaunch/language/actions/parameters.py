# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The parameters that launch files give to nodes and components."""

from collections.abc import Iterator
import os

from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.scope import Value
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.syntax.diagnostics import error, LaunchError
from colcon_yamllaunch.language.syntax.launch_tree import ParameterValue
from colcon_yamllaunch.language.syntax.text import Text
from colcon_yamllaunch.language.vocabulary.parameter import (
    coerce,
    infer,
    Parameter,
    parameter_file,
    ParameterContent,
    ParameterTypeError,
)
from colcon_yamllaunch.plan.plan import ParameterFile, SetParameter
from colcon_yamllaunch.plan.position import Position

#: What is said of a parameter that is an empty list.
EMPTY_LIST = 'nodes do not accept an empty list, which has no type'

_LIST = 'list_of_'

#: A value, None when it is not known, and where what it is made of was set.
Content = tuple[ParameterContent | None, tuple[Position, ...]]


def parameter_arguments(
    walk: Walk,
    attributes: Attributes,
    node: str,
    pattern: str,
    full_name: Value | None,
) -> list[str | ParameterFile]:
    """
    Return the arguments for a node's own parameters, in order.

    :param attributes: Those of the node
    :param node: What to call it in messages
    :param pattern: The nodes that a file of parameters is for
    :param full_name: The full name of the node, None when it names itself
    """
    arguments: list[str | ParameterFile] = []
    pending: list[SetParameter] = []

    def flush() -> None:
        if pending:
            file = parameter_file(pattern, pending)
            arguments.extend(['--params-file', file])
            pending.clear()

    if walk.scope.parameters:
        from colcon_yamllaunch.language.actions import parameter_files

        parameter_files.note_sections_of_scope(walk, full_name)
    for entry in attributes.items('param'):
        if 'from' in entry.item.texts:
            flush()
            # many launches have no parameter files
            from colcon_yamllaunch.language.actions import parameter_files

            file = parameter_files.file_of(walk, entry)
            if file is not None:
                arguments.extend(['--params-file', file])
            if isinstance(file, str):
                parameter_files.note_sections(
                    walk,
                    os.path.join(walk.cwd, file),
                    walk.place_of(entry.item.texts['from']),
                    full_name,
                    is_own=True,
                )
            continue
        for parameter in nested_parameters(walk, entry, node):
            if parameter.value is not None:
                pending.append(parameter.as_set())
    flush()
    return arguments


def parameter_value(
    walk: Walk,
    value: ParameterValue,
    kind: str | None,
    *,
    infer_text: bool = False,
    what: str = '',
) -> Content:
    """
    Return the value of a parameter, and its origins.

    :param kind: The type that the launch file gives, or None
    :param infer_text: Whether a text without substitutions is taken for what
      YAML takes it for, as ROS 2's `set_parameter` does
    :param what: What a message starts with
    """
    try:
        if not value.is_list:
            return _scalar(walk, value.texts[0], kind, infer_text)
        return _list(walk, value, kind)
    except LaunchError as e:
        walk.fail(e.of(what))
        return None, ()


def _list(walk: Walk, value: ParameterValue, kind: str | None) -> Content:
    if kind is not None and not kind.startswith(_LIST) and kind != 'yaml':
        raise error(f'the value is a list, not of type {kind}', value.position)
    element = None
    if kind is not None and kind.startswith(_LIST):
        element = kind[len(_LIST) :]
    contents = [_scalar(walk, text, element, False) for text in value.texts]
    for text, (content, _) in zip(value.texts, contents, strict=True):
        if isinstance(content, tuple):
            raise error('a list cannot have a list in it', text)
    values = [v for v, _ in contents if not isinstance(v, tuple | None)]
    kinds = {type(v) for v in values}
    if len(kinds) > 1:
        raise error(
            'the values of a list have one type, here they have '
            + ' and '.join(sorted(k.__name__ for k in kinds)),
            value.position,
            hint='write 1.0 for a whole number among others'
            if kinds == {int, float}
            else 'quote the values that are texts',
        )
    if not contents:
        walk.warn(EMPTY_LIST, value.position)
        return (), ()
    is_known = len(values) == len(contents)
    return tuple(values) if is_known else None, contents[-1][1]


def _scalar(
    walk: Walk, text: Text, kind: str | None, infer_text: bool
) -> Content:
    if kind is not None and kind.startswith(_LIST):
        raise error(
            f'the value is no list, but its type is {kind}',
            text,
            hint='write it as [first, second, …]',
        )
    literal = text.literal
    is_typed = kind not in (None, 'yaml')
    if literal is None or (is_typed and text.is_coerced):
        return _evaluated(walk, text, kind)
    if infer_text and text.kind == 'str':
        return _evaluated(walk, text, None)
    value = literal if text.kind == 'str' else text.value
    assert value is not None
    found = type(value).__name__
    if is_typed and found != kind:
        hint = 'change the value or the type'
        if kind == 'str':
            hint = f"quote it: '{text.plain}'"
        elif kind == 'float' and found == 'int':
            hint = f'write {text.plain}.0'
        raise error(
            f'the value is of type {found}, not {kind}', text, hint=hint
        )
    return value, ()


def _evaluated(walk: Walk, text: Text, kind: str | None) -> Content:
    value = walk.value(text)
    if value.text is None:
        return None, ()
    try:
        if kind is None:
            return infer(value.text), value.origins
        return coerce(value.text, kind), value.origins
    except ParameterTypeError as e:
        raise error(str(e), text, origins=value.origins) from e


def nested_parameters(
    walk: Walk, entry: Attributes, node: str, prefix: str = ''
) -> Iterator[Parameter]:
    """
    Iterate over the parameters that an item of `param` sets.

    :param node: What to call their node in messages
    :param prefix: What the names of those around it start with
    """
    name = prefix + (entry.text('name') or '')
    if 'param' in entry.item.items:
        for inner in entry.items('param'):
            if 'from' in inner:
                inner.fail_as_whole(
                    "'from' cannot stand within a parameter",
                    "make it an item of the node's 'param'",
                )
            else:
                yield from nested_parameters(walk, inner, node, f'{name}.')
        return
    kind = entry.plain('type') if 'type' in entry.item.texts else None
    what = f"parameter '{name}' of node '{node}': "
    written = entry.item.values['value']
    value, origins = parameter_value(walk, written, kind, what=what)
    yield Parameter(name, value, written.position, origins)
