# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Names, namespaces and remappings of nodes and components."""

import re

from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.scope import known, Value
from colcon_yamllaunch.language.evaluation.walk import Walk

_NODE_NAME = re.compile(r'[A-Za-z_][A-Za-z0-9_]*')
_NAMESPACE = re.compile(r'/|(/[A-Za-z_~{}][A-Za-z0-9_~{}]*)+')


def node_name(attributes: Attributes) -> Value | None:
    """Return the name of a node, None when it is left out."""
    name = attributes.value('name')
    if name is None or name.text is None:
        return name
    problem = node_name_problem(name.text)
    if problem is not None:
        attributes.fail('name', problem)
        return name.forgotten()
    return name


def node_namespace(walk: Walk, attributes: Attributes) -> Value | None:
    """Return the namespace of a node, None when it has none."""
    if 'namespace' not in attributes:
        return walk.scope.namespace
    inner = attributes.required('namespace')
    return inner_namespace(walk, attributes, inner)


def full_node_name(
    name: Value | None, namespace: Value | None
) -> Value | None:
    """Return the full name of a node, None when it names itself."""
    if name is None or namespace is None or name.text is None:
        text = None if name is None else name.text
        return name and name._replace(text=text and f'/{text}')
    outer = namespace.text
    text = None if outer is None else f'{outer.rstrip("/")}/{name.text}'
    sources = name.sources | namespace.sources
    return name._replace(text=text, sources=sources)


def remap_rules(walk: Walk, attributes: Attributes) -> list[str]:
    """Return the remapping rules of a node; the first that matches counts."""
    of_scope = walk.scope.remaps
    pairs = [*of_scope]
    seen: set[str] = set()
    for remap in attributes.items('remap'):
        old, new = remap.text('from'), remap.text('to')
        if old is None:
            continue
        # the first rule that matches counts (rcl_remap)
        is_done = old in seen or old in {name for name, _ in of_scope}
        if is_done and not walk.is_launch:
            by = 'before' if old in seen else "by 'set_remap'"
            text = remap.item.texts['from']
            walk.warn(
                f"'{old}' is remapped {by} already, so this has no effect",
                text,
                'remove one of the two',
            )
        seen.add(old)
        pairs.append((old, new or ''))
    return [f'{old}:={new}' for old, new in pairs]


def node_name_problem(name: str) -> str | None:
    """Return why no node can have a name, or None if one can."""
    if _NODE_NAME.fullmatch(name):
        return None
    return (
        f"the node name '{name}' may only have letters, digits and "
        'underscores, and cannot be empty or start with a digit'
    )


def namespace_problem(namespace: str) -> str | None:
    """Return why a text is no absolute namespace, or None if it is one."""
    if _NAMESPACE.fullmatch(namespace):
        return None
    return (
        f"the namespace '{namespace}' may only have letters, digits, "
        'underscores and slashes, and none of its parts can be empty or start '
        'with a digit'
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


def inner_namespace(
    walk: Walk, attributes: Attributes, inner: Value
) -> Value | None:
    """
    Return a namespace within that of the scope.

    :param attributes: Those with the inner one as `namespace`
    """
    outer = walk.scope.namespace
    if inner.text is None:
        return inner
    base = None if outer is None else outer.text
    namespace = join_namespace(base, inner.text)
    problem = namespace_problem(namespace)
    if problem is not None:
        attributes.fail('namespace', problem)
        return inner.forgotten()
    if outer is not None and base is None and inner.text[:1] != '/':
        return outer
    return known(namespace)
