# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The rules for the names of nodes and namespaces.

They are those of ROS 2's rmw (`rmw_validate_node_name`,
`rmw_validate_namespace`).
"""

import re

_NODE_NAME = re.compile(r'[A-Za-z_][A-Za-z0-9_]*')
_NAMESPACE = re.compile(r'/|(/[A-Za-z_~{}][A-Za-z0-9_~{}]*)+')


def node_name_problem(name: str) -> str | None:
    """Say why a name is none for a node, or None if it is one."""
    if _NODE_NAME.fullmatch(name):
        return None
    if not name:
        return 'a node name cannot be empty'
    if name[0].isdigit():
        return f"the node name '{name}' starts with a digit"
    return (
        f"the node name '{name}' may only have letters, digits and underscores"
    )


def namespace_problem(namespace: str) -> str | None:
    """Say why a text is no absolute namespace, or None if it is one."""
    if _NAMESPACE.fullmatch(namespace):
        return None
    if '//' in namespace:
        return f"the namespace '{namespace}' has an empty part"
    if re.search('/[0-9]', namespace):
        return f"a part of the namespace '{namespace}' starts with a digit"
    return (
        f"the namespace '{namespace}' may only have letters, digits, "
        'underscores and slashes'
    )


def join_namespace(base: str | None, namespace: str) -> str:
    """
    Return the namespace that results from one within another.

    :param base: The outer namespace, absolute, if there is one
    :param namespace: The inner one; an absolute one replaces the outer one
    """
    if not namespace.startswith('/'):
        namespace = f'{(base or "").rstrip("/")}/{namespace}'
    return namespace.rstrip('/') or '/'
