# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The table of what does each action."""

from collections.abc import Mapping

from colcon_yamllaunch.language.actions.flow_actions import (
    FLOW_HANDLERS,
    MESSAGE_HANDLERS,
)
from colcon_yamllaunch.language.actions.process_actions import PROCESS_HANDLERS
from colcon_yamllaunch.language.actions.scope_actions import SCOPE_HANDLERS
from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.walk import Handler, Walk


def _do_component_action(walk: Walk, attributes: Attributes) -> None:
    # a launch without components does not import what loads them
    from colcon_yamllaunch.language.actions.component_actions import (
        COMPONENT_HANDLERS,
    )

    COMPONENT_HANDLERS[attributes.name](walk, attributes)


_COMPONENT_HANDLERS: Mapping[str, Handler] = dict.fromkeys(
    (
        'node_container',
        'load_composable_node',
        'composable_node',
        'composable_lifecycle_node',
    ),
    _do_component_action,
)


#: What does each action, whatever the policy of the walk.
HANDLERS: Mapping[str, Handler] = {
    **SCOPE_HANDLERS,
    **FLOW_HANDLERS,
    **MESSAGE_HANDLERS,
    **PROCESS_HANDLERS,
    **_COMPONENT_HANDLERS,
}
#: The actions that no other depends on.
PASSIVE = frozenset(
    (*MESSAGE_HANDLERS, *PROCESS_HANDLERS, *_COMPONENT_HANDLERS)
)
