# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The parameters of a node, from what the launch file says of them."""

from dataclasses import replace
import os
from pathlib import Path

from colcon_yamllaunch.language.evaluation.evaluation_state import State
from colcon_yamllaunch.language.plan.plan import ParameterFile
from colcon_yamllaunch.language.plan.plan import SetParameter
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.source_text import read_source
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar
from colcon_yamllaunch.language.tree.launch_tree import Item
from colcon_yamllaunch.language.tree.launch_tree import ParameterValue
from colcon_yamllaunch.language.tree.text import Text
from colcon_yamllaunch.language.vocabulary.parameter_value import coerce
from colcon_yamllaunch.language.vocabulary.parameter_value import infer
from colcon_yamllaunch.language.vocabulary.parameter_value import is_of_type
from colcon_yamllaunch.language.vocabulary.parameter_value import Parameter
from colcon_yamllaunch.language.vocabulary.parameter_value import (
    parameter_file,
)
from colcon_yamllaunch.language.vocabulary.parameter_value import (
    ParameterContent,
)
from colcon_yamllaunch.language.vocabulary.parameter_value import (
    ParameterTypeError,
)
from colcon_yamllaunch.language.vocabulary.parameter_value import ScalarValue
from colcon_yamllaunch.language.vocabulary.parameter_value import type_name
import yaml

_LIST = 'list_of_'


def parameter_arguments(
    state: State, item: Item, node: str, pattern: str
) -> list[str | ParameterFile]:
    """
    Return the arguments for a node's own parameters, in order.

    :param item: The node
    :param node: What to call it in messages
    :param pattern: The nodes that a file of parameters is for
    :raises LaunchError: if a value cannot be had
    """
    arguments: list[str | ParameterFile] = []
    pending: list[SetParameter] = []

    def flush() -> None:
        if pending:
            file = parameter_file(pattern, pending)
            arguments.extend(['--params-file', file])
            pending.clear()

    for entry in item.items.get('param', ()):
        if 'from' in entry.texts:
            flush()
            path = _from_file(state, entry)
            if path is not None:
                arguments.extend(['--params-file', path])
        else:
            pending.extend(
                p.as_set() for p in _flatten(state, entry, node, '')
            )
    flush()
    return arguments


def evaluate_value(
    state: State,
    value: ParameterValue,
    kind: str | None,
    *,
    infer_text: bool = False,
) -> ParameterContent:
    """
    Return the value of a parameter.

    :param kind: The type that the launch file gives, or None
    :param infer_text: Whether a text without substitutions is taken for what
      YAML takes it for, as ROS 2's `set_parameter` does
    :raises LaunchError: if it has not that type, or none
    """
    if not value.is_list:
        return _scalar(state, value.texts[0], kind, infer_text)
    if kind is not None and not kind.startswith(_LIST) and kind != 'yaml':
        raise error(f'the value is a list, not of type {kind}', value.position)
    element = None
    if kind is not None and kind.startswith(_LIST):
        element = kind[len(_LIST) :]
    values = [_element(state, text, element) for text in value.texts]
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
    if not values:
        state.warn(
            'nodes do not accept an empty list, which has no type',
            value.position,
        )
    return tuple(values)


def _element(state: State, text: Text, kind: str | None) -> ScalarValue:
    value = _scalar(state, text, kind, False)
    if isinstance(value, tuple):
        raise error(
            'a list cannot have a list in it',
            text.position,
            length=text.length,
        )
    return value


def _scalar(
    state: State, text: Text, kind: str | None, infer_text: bool
) -> ParameterContent:
    state.origins = ()
    if kind is not None and kind.startswith(_LIST):
        raise error(
            f'the value is no list, but its type is {kind}',
            text.position,
            hint='write it as [first, second, …]',
            length=text.length,
        )
    literal = text.literal
    try:
        is_typed = kind not in (None, 'yaml')
        if literal is None or (is_typed and text.is_coerced):
            result = text.evaluate(state)
            return infer(result) if kind is None else coerce(result, kind)
        if infer_text and text.kind == 'str':
            return infer(literal)
    except ParameterTypeError as e:
        raise error(
            str(e), text.position, length=text.length, origins=state.origins
        ) from e
    value = literal if text.kind == 'str' else text.value
    assert value is not None
    if kind not in (None, 'yaml') and not is_of_type(value, str(kind)):
        raise error(
            f'the value is of type {type_name(value)}, not {kind}',
            text.position,
            hint=_retype_hint(text, str(kind)),
            length=text.length,
        )
    return value


def _retype_hint(text: Text, kind: str) -> str:
    if kind == 'str':
        return f"quote it: '{text.plain}'"
    if kind == 'float' and text.kind == 'int':
        return f'write {text.plain}.0'
    return 'change the value or the type'


def _flatten(
    state: State, entry: Item, node: str, prefix: str
) -> list[Parameter]:
    name = prefix + state.text(entry, 'name')
    if 'param' in entry.items:
        return [
            parameter
            for inner in entry.items['param']
            for parameter in _flatten_inner(state, inner, node, name)
        ]
    kind = entry.texts['type'].plain if 'type' in entry.texts else None
    try:
        value = evaluate_value(state, entry.values['value'], kind)
    except LaunchError as e:
        what = f"parameter '{name}' of node '{node}'"
        raise LaunchError(
            *(
                replace(d, message=f'{what}: {d.message}')
                for d in e.diagnostics
            )
        ) from e
    return [Parameter(name, value, entry.position, state.origins)]


def _flatten_inner(
    state: State, inner: Item, node: str, name: str
) -> list[Parameter]:
    if 'from' in inner.texts:
        raise error(
            "'from' cannot stand within a parameter",
            inner.position,
            hint="make it an item of the node's 'param'",
        )
    return _flatten(state, inner, node, f'{name}.')


def _from_file(state: State, entry: Item) -> str | ParameterFile | None:
    text = entry.texts['from']
    path = text.evaluate(state)
    file = os.path.join(state.cwd, path)
    if not os.path.isfile(file):
        source = _file_to_be_installed(state, file)
        if source is None:
            state.warn(
                f"the parameter file '{path}' does not exist; it is skipped",
                text.position,
                length=text.length,
            )
            return None
        file = source
    if not state.boolean(entry, 'allow_substs', False):
        return path
    return ParameterFile(_substituted(state, file, text))


def _file_to_be_installed(state: State, path: str) -> str | None:
    """Return the source of a file that a build will install, or None."""
    located = state.packages.locate(path)
    if located is None or not state.packages.may_appear(path):
        return None
    return located[1]


def _substituted(state: State, path: str, origin: Text) -> str:
    source = read_source(path, path)
    end = source.position_at(len(source.text))
    scalar = Scalar(source, 0, 0, source.text, '', None, (end.line, 0))
    try:
        content = Text(scalar).evaluate(state)
    except LaunchError as e:
        raise e.included_from(origin.position) from e
    try:
        loaded = yaml.safe_load(content)
    except (yaml.YAMLError, ValueError, RecursionError) as e:
        loaded = None
        reason = str(e).split('\n', 1)[0]
    else:
        reason = 'it has no mapping of nodes to parameters'
    if not isinstance(loaded, dict):
        raise error(
            f"the parameter file '{Path(path).name}' is no parameter file "
            f'once its substitutions are made: {reason}',
            origin.position,
            length=origin.length,
        )
    return content
