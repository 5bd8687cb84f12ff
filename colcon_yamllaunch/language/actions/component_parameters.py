# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The parameters of a component.

It reads no files itself: who loads it does, and sends what they say.
"""

from collections.abc import Iterator
import os

from colcon_yamllaunch.language.actions.node_parameters import EMPTY_LIST
from colcon_yamllaunch.language.actions.node_parameters import (
    nested_parameters,
)
from colcon_yamllaunch.language.actions.parameter_file_lookup import file_of
from colcon_yamllaunch.language.actions.parameter_file_lookup import (
    note_sections,
)
from colcon_yamllaunch.language.actions.parameter_file_lookup import (
    note_sections_of_scope,
)
from colcon_yamllaunch.language.actions.parameter_file_lookup import (
    sections_in,
)
from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.values import Value
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.language.tree.text import Text
from colcon_yamllaunch.language.vocabulary.parameter import Parameter
from colcon_yamllaunch.language.vocabulary.parameter_sections import (
    ParameterSections,
)
from colcon_yamllaunch.language.vocabulary.parameter_sections import (
    read_sections,
)
from colcon_yamllaunch.plan.plan import ParameterFile


def component_parameters(
    walk: Walk, attributes: Attributes, component: str, node: Value | None
) -> list[Parameter]:
    """
    Return the parameters that a component is loaded with, in order.

    :param attributes: Those of the component
    :param component: What to call it in messages
    :param node: The full name of its node, None when it names itself
    """
    found: list[Parameter] = []
    plugin = attributes.item.texts['plugin']
    note_sections_of_scope(walk, node)
    for parameter in walk.scope.parameters:
        if isinstance(parameter, Parameter):
            found.append(parameter)
        else:
            found += _in_file(walk, parameter, plugin, node)
    for entry in attributes.items('param'):
        if 'from' not in entry.item.texts:
            found += nested_parameters(walk, entry, component)
            continue
        text, file = (
            entry.item.texts['from'],
            file_of(walk, entry, is_needed=True),
        )
        if isinstance(file, ParameterFile):
            found += _in_text(walk, file.content, text, node)
        elif file is not None:
            note_sections(walk, file, entry, node)
            found += _in_file(walk, os.path.join(walk.cwd, file), text, node)
    # what has no type cannot be sent
    return [p for p in found if p.value != ()]


def _in_file(
    walk: Walk, path: str, origin: Text, node: Value | None
) -> Iterator[Parameter]:
    """Iterate over the parameters of a file that are for a node."""
    with walk.within_text(origin):
        # other nodes read theirs themselves
        walk.inputs[walk.parameter_file(path) or path] = None
        yield from _of_node(walk, sections_in(walk, path), node)


def _in_text(
    walk: Walk, content: str, origin: Text, node: Value | None
) -> Iterator[Parameter]:
    with walk.within_text(origin):
        source = Source(origin.plain, origin.plain, content)
        yield from _of_node(walk, read_sections(source), node)


def _of_node(
    walk: Walk, read: ParameterSections, node: Value | None
) -> Iterator[Parameter]:
    if read.warnings:
        walk.report(LaunchError(*read.warnings))
    if node is not None and node.text is None:
        return
    for parameter in read.parameters_of(node and node.text):
        if parameter.value == ():
            walk.warn(
                f"the parameter '{parameter.name}' is left out: {EMPTY_LIST}",
                parameter.position,
            )
        yield parameter
