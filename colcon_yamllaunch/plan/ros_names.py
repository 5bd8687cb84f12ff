# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The names of topics, services and nodes as the node of a member has them.

ROS 2 expands a name (`rcl_expand_topic_name`) and then replaces it by the
first remapping rule that matches (`rcl_remap_topic_name`).
"""

from collections.abc import Iterable, Iterator
import re

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.plan.plan import Component, Member

# `node:from:=to`; the scheme says which names a rule is about
_RULE = re.compile(
    r'(?:([A-Za-z_]\w*):(?!//))?(rostopic://|rosservice://)?([^:]+):=(.*)',
    re.DOTALL,
)
_FLAGS = ('-r', '--remap')


@dataclass(frozen=True, slots=True)
class _Rule:
    """
    A remapping rule.

    :param node: The name of the node that it is about; empty for all
    :param scheme: `rostopic://`, `rosservice://`, or empty for both
    """

    node: str
    scheme: str
    old: str
    new: str


@dataclass(frozen=True, slots=True)
class NodeNames:
    """
    The names that a node uses.

    :param namespace: Its namespace, such as `/` or `/drivers`
    :param name: Its name without the namespace; empty if the launch files do
      not give it
    """

    namespace: str
    name: str
    rules: tuple[_Rule, ...] = ()

    @property
    def node(self) -> str:
        """Its full name; empty if the launch files do not give it."""
        return _joined(self.namespace, self.name) if self.name else ''

    def topic(self, name: str) -> str:
        """Return the full name of a topic of the node."""
        return self._remapped(self.expanded(name), 'rostopic://')

    def service(self, name: str) -> str:
        """Return the full name of a service of the node."""
        return self._remapped(self.expanded(name), 'rosservice://')

    def action(self, name: str) -> str:
        """
        Return the full name of an action of the node.

        ROS 2 before Kilted remaps only the services that an action has.
        """
        full = self.expanded(name)
        hidden = f'{full}/_action/send_goal'
        remapped = self._remapped(hidden, 'rosservice://')
        if remapped != hidden:
            return remapped.removesuffix('/_action/send_goal')
        return self._remapped(full, 'rosservice://')

    def expanded(self, name: str) -> str:
        """Return a name as a full name, without remapping."""
        for key, value in (
            ('{node}', self.name),
            ('{ns}', self.namespace),
            ('{namespace}', self.namespace),
        ):
            name = name.replace(key, value)
        if name.startswith('/'):
            return name
        if name == '~' or name.startswith('~/'):
            return f'{self.node}{name[1:]}'
        return _joined(self.namespace, name)

    def _remapped(self, full: str, scheme: str) -> str:
        for rule in self.rules:
            if (
                rule.node in ('', self.name)
                and rule.scheme in ('', scheme)
                and self.expanded(rule.old) == full
            ):
                return self.expanded(rule.new)
        return full


def needs_node_name(name: str) -> bool:
    """Return whether a name depends on the name of the node."""
    return name.startswith('~') or '{node}' in name


def names_of(member: Member, full_name: str | None = None) -> NodeNames:
    """
    Return the names that the node of a member uses.

    :param full_name: Its full name, if that is known from elsewhere
    """
    if isinstance(member, Component):
        words: Iterable[str] = member.remaps
    else:
        words = _ros_arguments(member.argv)
    rules = tuple(_rules(words))
    full = full_name or member.node_name or ''
    namespace, _, name = full.rpartition('/')
    if not full and isinstance(member, Component):
        namespace = member.namespace
    # those of the command line count, the first of each
    for rule in reversed(() if full_name else rules):
        if rule.old == '__ns':
            namespace = rule.new
        elif rule.old in ('__node', '__name'):
            name = rule.new
    rules = tuple(r for r in rules if not r.old.startswith('__'))
    return NodeNames(namespace or '/', name, rules)


def _ros_arguments(argv: Iterable[object]) -> Iterator[str]:
    """Return the remapping rules of a command line (`rcl_arguments_init`)."""
    is_ros = is_rule = False
    for word in argv:
        if is_rule and isinstance(word, str):
            yield word
        is_rule = is_ros and not is_rule and word in _FLAGS
        if word == '--ros-args':
            is_ros = True
        elif word == '--':
            is_ros = False


def _rules(words: Iterable[str]) -> Iterator[_Rule]:
    for word in words:
        match = _RULE.fullmatch(word)
        if match is not None:
            node, scheme, old, new = match.groups()
            yield _Rule(node or '', scheme or '', old, new)


def _joined(namespace: str, name: str) -> str:
    return f'{namespace.rstrip("/")}/{name}'
