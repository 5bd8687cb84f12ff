# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The actions that load components into a container."""

from collections.abc import Iterator, Mapping
import os

from colcon_yamllaunch.language.actions.node_names import (
    full_node_name,
    node_name,
    node_name_problem,
    node_namespace,
    remap_rules,
)
from colcon_yamllaunch.language.actions.parameter_files import (
    file_of,
    note_sections,
    note_sections_of_scope,
    read_sections,
    sections_in,
)
from colcon_yamllaunch.language.actions.parameters import (
    EMPTY_LIST,
    nested_parameters,
    parameter_value,
)
from colcon_yamllaunch.language.actions.process_actions import run_node
from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.findings import PluginUse
from colcon_yamllaunch.language.evaluation.scope import Value
from colcon_yamllaunch.language.evaluation.walk import Handler, Walk
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.launch_tree import Entity
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.language.syntax.text import Text
from colcon_yamllaunch.language.vocabulary.actions import COMPONENTS
from colcon_yamllaunch.language.vocabulary.parameter import Parameter
from colcon_yamllaunch.plan.plan import Component, ParameterFile


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
            found += _from_file(walk, parameter, plugin, node)
    for entry in attributes.items('param'):
        if 'from' not in entry.item.texts:
            found += nested_parameters(walk, entry, component)
            continue
        text, file = (
            entry.item.texts['from'],
            file_of(walk, entry, needed=True),
        )
        if isinstance(file, str):
            file = os.path.join(walk.cwd, file)
            place = walk.place_of(text)
            note_sections(walk, file, place, node, is_own=True)
        if file is not None:
            found += _from_file(walk, file, text, node)
    # what has no type cannot be sent
    return [p for p in found if p.value != ()]


def _from_file(
    walk: Walk, file: str | ParameterFile, origin: Text, node: Value | None
) -> Iterator[Parameter]:
    """
    Iterate over the parameters of a file that are for a node.

    :param file: Its path, or its content
    :param origin: What names it
    """
    with walk.within_text(origin):
        if isinstance(file, ParameterFile):
            source = Source(origin.plain, origin.plain, file.content)
            read = read_sections(source)
        else:
            # other nodes read theirs themselves
            walk.inputs[walk.parameter_file(file) or file] = None
            read = sections_in(walk, file)
        if read.warnings:
            walk.report(LaunchError(*read.warnings))
        if node is not None and node.text is None:
            return
        for parameter in read.parameters_of(node and node.text):
            if parameter.value == ():
                walk.warn(
                    f"the parameter '{parameter.name}' is left out: "
                    f'{EMPTY_LIST}',
                    parameter.position,
                )
            yield parameter


def _node_container(walk: Walk, attributes: Attributes) -> None:
    components = _components(attributes)
    if components and 'name' not in attributes:
        attributes.fail_as_whole(
            "a 'node_container' with components needs a 'name'",
            'by that they are loaded into it',
        )
    container = run_node(walk, attributes)
    _load(walk, components, container)


def _load_composable_node(walk: Walk, attributes: Attributes) -> None:
    target = attributes.required('target')
    container = None
    if target.text is not None:
        # ROS 2's launcher has no namespace to put in front of it
        container = f'/{target.text.removeprefix("/")}'
        if any(map(node_name_problem, container[1:].split('/'))):
            attributes.fail(
                'target',
                f"'{target.text}' is not the full name of a node",
                'write it as /namespace/name',
            )
            container = None
    if container is not None and target.is_sure and not walk.never:
        place = walk.place_of(attributes.item.texts['target'])
        walk.targets.append((container, place))
    components = _components(attributes)
    if not components:
        attributes.fail_as_whole(
            "'load_composable_node' has nothing to load",
            "write 'composable_node' with a list in it",
        )
    _load(walk, components, container)


def _components(attributes: Attributes) -> list[Entity]:
    """Return the components in the lists of an action, as they stand there."""
    lists = attributes.item.items
    entities = [
        Entity(action, item)
        for name, action in COMPONENTS.items()
        for item in lists.get(name, ())
    ]
    if all(name in lists for name in COMPONENTS):

        def place(entity: Entity) -> tuple[int, int]:
            position = entity.item.position
            return position.line, position.column

        entities.sort(key=place)
    return entities


def _load(walk: Walk, components: list[Entity], container: str | None) -> None:
    inner = walk.scope.inner()
    inner.container = container
    with walk.within_scope(inner):
        walk.visit_all(tuple(components))


def _component(walk: Walk, attributes: Attributes) -> None:
    package, plugin = attributes.text('pkg'), attributes.text('plugin')
    if package is not None:
        # whether it has the component shows once it is built
        texts = attributes.item.texts
        at = texts['pkg'].position
        if walk.packages.prefix(package) is not None:
            walk.use_package(package, at)
        use = PluginUse(package, plugin, texts['plugin'].position, at)
        walk.plugins.append(use)
    # ROS 2 takes an empty name for none
    written = attributes.text('name')
    name = None if written == '' else node_name(attributes)
    namespace = node_namespace(walk, attributes)
    full_name = full_node_name(name, namespace)
    full_text = None if full_name is None else full_name.text
    title = (name and name.text) or (plugin or '').rpartition('::')[2]
    parameters = component_parameters(walk, attributes, title, full_name)
    remaps = remap_rules(walk, attributes)
    extra = []
    for pair in attributes.items('extra_arg'):
        argument = pair.text('name') or ''
        value, origins = parameter_value(
            walk,
            pair.item.values['value'],
            None,
            infer_text=True,
            what=f"extra argument '{argument}': ",
        )
        if value != ():
            extra.append(Parameter(argument, value, pair.position, origins))
    if full_text is not None:
        walk.note_node(full_text, attributes.item.texts['name'])
    elif name is not None:
        walk.may_have_others = True
    if not walk.is_launch:
        return
    is_lifecycle = attributes.name == 'composable_lifecycle_node'
    walk.draft.entries.append(
        Component(
            label=walk.draft.component_label(plugin or ''),
            package=package or '',
            plugin=plugin or '',
            container=walk.scope.container or '',
            position=attributes.position,
            name=(name and name.text) or '',
            namespace=(namespace and namespace.text) or '',
            remaps=tuple(remaps),
            parameters=tuple(p.as_json() for p in parameters),
            extra_arguments=tuple(p.as_json() for p in extra),
            block=walk.draft.block,
            is_lifecycle=is_lifecycle,
            autostart=is_lifecycle and attributes.boolean('autostart') is True,
        )
    )


#: What does each action that loads components, and each of those.
COMPONENT_HANDLERS: Mapping[str, Handler] = {
    'node_container': _node_container,
    'load_composable_node': _load_composable_node,
    'composable_node': _component,
    'composable_lifecycle_node': _component,
}
