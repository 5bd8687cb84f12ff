# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Whether parameters can have the values that launch files give them."""

import os

from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.language.checking.attributes import truth
from colcon_yamllaunch.language.checking.check_state import Checking
from colcon_yamllaunch.language.checking.possible_scope import Value
from colcon_yamllaunch.language.checking.possible_values import value_of
from colcon_yamllaunch.language.evaluation.node_parameters import (
    evaluate_value,
)
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.source_text import read_source
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar
from colcon_yamllaunch.language.tree.launch_tree import Item
from colcon_yamllaunch.language.tree.launch_tree import ParameterValue
from colcon_yamllaunch.language.tree.text import Text
from colcon_yamllaunch.language.vocabulary.parameter_value import coerce
from colcon_yamllaunch.language.vocabulary.parameter_value import infer
from colcon_yamllaunch.language.vocabulary.parameter_value import (
    ParameterTypeError,
)
import yaml


def check_parameter(checking: Checking, entry: Item) -> None:
    """Check an item of a node's 'param'."""
    if 'from' in entry.texts:
        _check_from(checking, entry)
        return
    value_of(checking, entry.texts['name'])
    for inner in entry.items.get('param', ()):
        if 'from' in inner.texts:
            checking.error(
                "'from' cannot stand within a parameter",
                inner.position,
                hint="make it an item of the node's 'param'",
            )
        else:
            check_parameter(checking, inner)
    if 'value' in entry.values:
        kind = entry.texts['type'].plain if 'type' in entry.texts else None
        check_value(checking, entry.values['value'], kind)


def check_value(
    checking: Checking,
    value: ParameterValue,
    kind: str | None,
    *,
    infer_text: bool = False,
) -> None:
    """
    Check the value of a parameter.

    :param kind: The type that the launch file gives, or None
    :param infer_text: Whether a text is taken for what YAML takes it for
    """
    is_literal = all(text.literal is not None for text in value.texts)
    is_list_type = kind is not None and kind.startswith('list_of_')
    if is_literal or (is_list_type and not value.is_list):
        _evaluate(checking, value, kind, infer_text)
        return
    element = None if kind is None else kind.removeprefix('list_of_')
    for text in value.texts:
        _check_scalar(checking, text, element)


def _evaluate(
    checking: Checking,
    value: ParameterValue,
    kind: str | None,
    infer_text: bool,
) -> None:
    """Evaluate a value as a launch does."""
    try:
        evaluate_value(checking.state, value, kind, infer_text=infer_text)
    except LaunchError as e:
        checking.report(e)


def _check_scalar(checking: Checking, text: Text, kind: str | None) -> None:
    value = value_of(checking, text)
    if value.text is None or text.literal is not None:
        return
    try:
        if kind is None:
            infer(value.text)
        else:
            coerce(value.text, kind)
    except ParameterTypeError as e:
        checking.error(str(e), text.position, length=text.length)


def check_parameter_file(
    checking: Checking, text: Text, value: Value, *, is_needed: bool
) -> str | None:
    """
    Check whether a file with parameters is there.

    :param is_needed: Whether the launch fails without it
    :returns: The path to read it at, None when that is not known
    """
    if value.text is None:
        return None
    path = checking.absolute(value.text)
    located = checking.packages.locate(path)
    if located is not None:
        return located[1]
    if os.path.isfile(path):
        return path
    note = checking.error
    message = f"the parameter file '{value.text}' does not exist"
    if not is_needed:
        message += '; it is skipped'
    if not is_needed or checking.packages.may_appear(path):
        note = checking.warn
    note(
        message,
        text.position,
        hint=did_you_mean(
            os.path.basename(path), checking.packages.similar(path)
        ),
        length=text.length,
    )
    return None


def _check_from(checking: Checking, entry: Item) -> None:
    text = entry.texts['from']
    path = check_parameter_file(
        checking, text, value_of(checking, text), is_needed=False
    )
    substitutes = entry.texts.get('allow_substs')
    if substitutes is None:
        return
    value = value_of(checking, substitutes)
    if value.text is not None and truth(value, False) is None:
        checking.error(
            f"'allow_substs' wants true or false, not '{value.text}'",
            substitutes.position,
            length=substitutes.length,
        )
    if truth(value, False) is False:
        return
    if path is None or truth(value, False) is None:
        checking.use.is_open = True
    else:
        _check_substitutions(checking, path, text)


def _check_substitutions(checking: Checking, path: str, origin: Text) -> None:
    with checking.state.within(checking.state.source, origin.position):
        try:
            text = whole_file(path)
        except LaunchError as e:
            checking.report(e)
            return
        checking.use.add_text(text.template)
        content = value_of(checking, text).text
    if content is not None and not _is_mapping(content):
        checking.error(
            f"'{os.path.basename(path)}' is no parameter file once its "
            'substitutions are made',
            origin.position,
            hint='it is a YAML mapping of nodes to parameters',
            length=origin.length,
        )


def whole_file(path: str) -> Text:
    """
    Return the content of a file with substitutions in it.

    :raises LaunchError: if it cannot be read, or one of them is malformed
    """
    source = read_source(path, path)
    end = source.position_at(len(source.text))
    return Text(Scalar(source, 0, 0, source.text, '', None, (end.line, 0)))


def _is_mapping(content: str) -> bool:
    try:
        return isinstance(yaml.safe_load(content), dict)
    except (yaml.YAMLError, ValueError, RecursionError):
        return False
