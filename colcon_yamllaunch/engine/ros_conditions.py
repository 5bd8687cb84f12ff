# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What the ROS client checks for readiness; `ros_client` imports it when needed.

Requests:

    {"id": 1, "do": "await", "member": "lidar-1", "kind": "topic",
     "name": "/drivers/scan", "value": null, "message": false,
     "node": "/drivers/lidar", "namespace": "/drivers"}
        answered when the condition holds; see `ReadyCondition` for what
        `name`, `value` and `message` are. Names are full names, and `node`
        and `namespace` are those of the member's node; `node` may be empty.
    {"id": 2, "do": "explain", …}
        with the fields of an `await`; answered with `found`: what there is
        instead, as a part of a sentence, or empty
    {"id": 3, "do": "gone", "member": "lidar-1"}
        its process has ended. What is still visible of it does not count.

A process that crashed stays visible until the middleware gives it up, for
example for 20 s. So what is visible when a process ends does not count for
`FORGET_DELAY` seconds; what is visible even then belongs to another process.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from difflib import get_close_matches
import importlib
import json
import time
from typing import Any, TYPE_CHECKING

#: Seconds between two looks at the graph while it changes all the time.
LOOK_INTERVAL = 0.02
#: Seconds until what was visible at the end of a process counts again.
FORGET_DELAY = 30.0
#: How many names an explanation has.
MAXIMUM_NAMES = 3
#: Stands for a node or server without an identity.
SOMETHING = b'?'
#: What nearly every node has; who publishes them shows the nodes.
_COMMON_TOPICS = ('/rosout', '/parameter_events')
_COMMON_SERVICES = (
    'describe_parameters',
    'get_parameter_types',
    'get_parameters',
    'get_type_description',
    'list_parameters',
    'set_parameters',
    'set_parameters_atomically',
)
_SEND_GOAL = '/_action/send_goal'
#: The fields of a parameter's value by its type, see
#: rcl_interfaces/msg/ParameterType.
_VALUES = {
    1: 'bool_value',
    2: 'integer_value',
    3: 'double_value',
    4: 'string_value',
}

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.ros_client import Ros

    # as code, this needs 3.9
    Json = dict[str, Any]
    Identities = frozenset[bytes]

NONE: Identities = frozenset()


class Graph:
    """
    The nodes, topics and services that exist now; each is read once.

    :param node: The ROS node of this program
    """

    def __init__(self, node: Any) -> None:
        self._node = node
        self._known: dict[str, Any] = {}

    @property
    def nodes(self) -> list[str]:
        """The full names of all nodes."""
        names: list[str] = self._once('nodes', self._read_nodes)
        return names

    @property
    def services(self) -> list[str]:
        """The names of all services."""
        pairs = self._once('services', self._node.get_service_names_and_types)
        return [name for name, _ in pairs]

    @property
    def topics(self) -> list[str]:
        """The names of all topics."""
        pairs = self._once('topics', self._node.get_topic_names_and_types)
        return [name for name, _ in pairs]

    def publishers(self, topic: str) -> Any:
        """Return the publishers of a topic."""
        return self._node.get_publishers_info_by_topic(topic)

    def node_identities(self, name: str) -> Identities:
        """Return the identities of the nodes with a name."""
        found = self._once('identities', self._identities).get(name)
        if found:
            return frozenset(found)
        return frozenset({SOMETHING}) if name in self.nodes else NONE

    def server_identities(self, service: str) -> Identities:
        """Return the identities of the servers of a service."""
        replies = self._node.get_publishers_info_by_topic(
            f'rr{service}Reply', no_mangle=True
        )
        found = _identities_of(replies)
        if not found and service in self.services:
            return frozenset({SOMETHING})
        return found

    def published_by(self, node: str) -> list[str]:
        """Return the topics that a node publishes."""
        read = self._node.get_publisher_names_and_types_by_node
        topics = _names_by_node(read, node)
        return [t for t in topics if t not in _COMMON_TOPICS]

    def served_by(self, node: str) -> list[str]:
        """Return the services that a node offers."""
        read = self._node.get_service_names_and_types_by_node
        common = {f'{node}/{end}' for end in _COMMON_SERVICES}
        return [s for s in _names_by_node(read, node) if s not in common]

    def _read_nodes(self) -> list[str]:
        pairs = self._node.get_node_names_and_namespaces()
        return [_joined(namespace, name) for name, namespace in pairs]

    def _identities(self) -> dict[str, list[bytes]]:
        found: dict[str, list[bytes]] = {}
        for topic in _COMMON_TOPICS:
            for one in self.publishers(topic):
                name = _joined(one.node_namespace, one.node_name)
                found.setdefault(name, []).append(bytes(one.endpoint_gid))
        return found

    def _once(self, key: str, read: Callable[[], Any]) -> Any:
        if key not in self._known:
            self._known[key] = read()
        return self._known[key]


class Condition:
    """
    A condition of a member of the launch.

    :param owner: The conditions of the launch
    :param fields: Those of the request
    """

    def __init__(self, owner: Conditions, fields: Json) -> None:
        self.member: str = fields['member']
        #: The id of the request to answer, None if nobody waits.
        self.request: int | None = None
        self._owner = owner
        self._ros = owner.ros
        self._name: str = fields['name']
        self._value = fields.get('value')
        self._node: str = fields.get('node') or ''
        self._namespace: str = fields.get('namespace') or '/'
        #: What is visible of processes that have ended, and until when that
        #: does not count.
        self._gone = NONE
        self._gone_until = 0.0

    @property
    def due(self) -> float | None:
        """When to look again without any change, None for never."""
        if self.request is None or not self._gone:
            return None
        return self._gone_until

    def begin(self, request: int) -> None:
        """Begin to check, and answer `request` when the condition holds."""
        self.request = request
        self._begin()

    def cancel(self) -> None:
        """End the check."""
        self.request = None
        self._stop()

    def look(self, now: float) -> None:
        """Look whether the condition holds, and answer if it does."""
        present = self._identities()
        if now >= self._gone_until:
            self._gone = NONE
        elif self._gone and present == {SOMETHING}:
            # a part of what has ended is not visible any more
            return
        else:
            self._gone &= present
        fresh = present - self._gone
        if fresh and self._holds(fresh):
            self._succeed()

    def lose(self, now: float) -> None:
        """Handle the end of the process of the member."""
        self._gone |= self._identities()
        self._gone_until = now + FORGET_DELAY

    def explain(self) -> str:
        """Return what exists instead, as a part of a sentence."""
        return self._similar(self._all())

    @property
    def _graph(self) -> Graph:
        return self._owner.graph

    def _begin(self) -> None:
        """Prepare to check."""

    def _stop(self) -> None:
        """Clean up after a check."""

    def _identities(self) -> Identities:
        """Return the identities of what exists and may meet the condition."""
        return NONE

    def _holds(self, fresh: Identities) -> bool:
        """
        Return whether the condition holds, as something is there.

        :param fresh: The identities of what belongs to no ended process
        """
        return bool(fresh)

    def _all(self) -> list[str]:
        """Return the names of all that the condition may be about."""
        return []

    def _succeed(self) -> None:
        """Answer that the condition holds."""
        request = self.request
        if request is not None:
            self.cancel()
            self._ros.answer(request, ok=True)

    def _shown(self, name: str) -> str:
        """Return a full name as users write it for this node."""
        prefix = self._namespace.rstrip('/') + '/'
        return name[len(prefix) :] if name.startswith(prefix) else name

    def _similar(self, names: Iterable[str]) -> str:
        """Return a remark on similar names, or an empty text."""
        near = get_close_matches(self._name, sorted(names), MAXIMUM_NAMES)
        return f'there is {", ".join(map(self._shown, near))}' if near else ''

    def _nearest(self, names: Iterable[str]) -> str:
        """Return some names, the most similar ones first."""
        known = sorted(self._shown(name) for name in names)
        wanted = self._shown(self._name)
        near = get_close_matches(wanted, known, MAXIMUM_NAMES, 0.5)
        rest = [name for name in known if name not in near]
        return ', '.join([*near, *rest][:MAXIMUM_NAMES])

    def _missing_node(self) -> str:
        """Return a remark if its node is missing, else an empty text."""
        nodes = self._graph.nodes
        if self._node in nodes:
            return ''
        near = get_close_matches(self._node, nodes, 1)
        there = f', but {near[0]}' if near else ''
        return f'there is no node {self._node}{there}'


class OfNode(Condition):
    """A condition about something that a node offers."""

    #: What a node does that offers it.
    _verb = ''

    def explain(self) -> str:
        """Return what the node offers, as a part of a sentence."""
        if not self._node:
            return super().explain()
        offered = self._nearest(self._own()) or 'nothing'
        return self._missing_node() or f'its node {self._verb} {offered}'

    def _own(self) -> list[str]:
        """Return the names of what the node offers."""
        return []


class Topic(OfNode):
    """A topic has a publisher, and maybe a message has arrived."""

    _verb = 'publishes'

    def __init__(self, owner: Conditions, fields: Json) -> None:
        super().__init__(owner, fields)
        self._needs_message = bool(fields.get('message'))
        self._subscription: Any = None
        self._problem = ''

    def explain(self) -> str:
        """Return why no message arrives, or what is published instead."""
        if self._subscription is not None:
            return 'it has a publisher, but no message has arrived'
        return self._problem or super().explain()

    def _stop(self) -> None:
        if self._subscription is not None:
            self._ros.node.destroy_subscription(self._subscription)
            self._subscription = None

    def _identities(self) -> Identities:
        return _identities_of(self._graph.publishers(self._name))

    def _holds(self, fresh: Identities) -> bool:
        if self._needs_message and self._subscription is None:
            self._subscribe(fresh)
        return not self._needs_message

    def _own(self) -> list[str]:
        return self._graph.published_by(self._node)

    def _all(self) -> list[str]:
        return [t for t in self._graph.topics if t not in _COMMON_TOPICS]

    def _subscribe(self, fresh: Identities) -> None:
        qos = importlib.import_module('rclpy.qos')
        publisher = next(
            one
            for one in self._graph.publishers(self._name)
            if bytes(one.endpoint_gid) in fresh
        )
        offered = publisher.qos_profile
        try:
            self._subscription = self._ros.node.create_subscription(
                _message_type(publisher.topic_type),
                self._name,
                lambda _: self._succeed(),
                qos.QoSProfile(
                    depth=1,
                    reliability=offered.reliability,
                    durability=offered.durability,
                ),
                # nobody reads it
                raw=True,
            )
        except Exception as e:  # noqa: BLE001 - by any package of messages
            self._problem = f'{publisher.topic_type} cannot be imported: {e}'


class Service(OfNode):
    """A service has a server."""

    _verb = 'offers'

    def _identities(self) -> Identities:
        return self._graph.server_identities(self._name)

    def _own(self) -> list[str]:
        return _without_hidden(self._graph.served_by(self._node))

    def _all(self) -> list[str]:
        return _without_hidden(self._graph.services)


class Action(OfNode):
    """An action has a server."""

    _verb = 'has the actions'

    def _identities(self) -> Identities:
        return self._graph.server_identities(self._name + _SEND_GOAL)

    def _own(self) -> list[str]:
        return _actions(self._graph.served_by(self._node))

    def _all(self) -> list[str]:
        return _actions(self._graph.services)


class Node(Condition):
    """A node is in the graph."""

    def look(self, now: float) -> None:
        """Compare the names if no identities matter, which is faster."""
        if self._gone:
            super().look(now)
        elif self._name in self._graph.nodes:
            self._succeed()

    def _identities(self) -> Identities:
        return self._graph.node_identities(self._name)

    def _all(self) -> list[str]:
        return self._graph.nodes


class Lifecycle(Condition):
    """A lifecycle node is in a state."""

    def __init__(self, owner: Conditions, fields: Json) -> None:
        super().__init__(owner, fields)
        self._peer = self._ros.lifecycle_node(self._node)
        self._peer.listeners.append(self._changed)

    def look(self, now: float) -> None:
        """Wait for the states that the node reports."""

    def lose(self, now: float) -> None:  # noqa: ARG002
        """Handle the end of the process of the node."""
        self._peer.lose()

    def explain(self) -> str:
        """Return the state, as a part of a sentence."""
        if self._peer.state is not None:
            return f'it is {self._peer.state}'
        return self._missing_node() or 'its node has no lifecycle'

    def _begin(self) -> None:
        self._peer.subscribe()
        self._changed()

    def _changed(self) -> None:
        if self._peer.state == self._name:
            self._succeed()


class Parameter(Condition):
    """A parameter has a value."""

    def __init__(self, owner: Conditions, fields: Json) -> None:
        super().__init__(owner, fields)
        self._peer = self._ros.parameter_node(self._node)
        self._peer.listeners.append(self._ask)
        self._subscription: Any = None
        self._seen: Any = None
        self._names: list[str] = []

    def look(self, now: float) -> None:
        """Wait for the values that the node reports."""

    def lose(self, now: float) -> None:  # noqa: ARG002
        """Handle the end of the process of the node."""
        self._peer.lose()

    def explain(self) -> str:
        """Return the value, or other parameters, as a part of a sentence."""
        if self._seen is not None:
            return f'it is {json.dumps(self._seen)}'
        missing = self._missing_node()
        if missing or not self._peer.is_present:
            return missing or 'its node has no services for parameters'
        return f'its node has {self._nearest(self._names) or "none"}'

    def _begin(self) -> None:
        if self._subscription is None:
            messages = importlib.import_module('rcl_interfaces.msg')
            qos = importlib.import_module('rclpy.qos')
            self._subscription = self._ros.node.create_subscription(
                messages.ParameterEvent,
                '/parameter_events',
                self._changed,
                qos.qos_profile_parameter_events,
            )
        self._ask()

    def _stop(self) -> None:
        if self._subscription is not None:
            self._ros.node.destroy_subscription(self._subscription)
            self._subscription = None

    def _changed(self, event: Any) -> None:
        if event.node == self._node:
            self._ask()

    def _ask(self) -> None:
        if self.request is None or not self._peer.is_present:
            return
        self._peer.get(self._name, self._got)

    def _got(self, response: Any) -> None:
        if self.request is None:
            return
        self._seen = None
        for value in response.values:
            field = _VALUES.get(value.type)
            if field is not None:
                self._seen = getattr(value, field)
        if self._seen is None:
            self._peer.list_names(self._listed)
        elif _is_same(self._seen, self._value):
            self._succeed()

    def _listed(self, response: Any) -> None:
        self._names = list(response.result.names)


class Transform(Condition):
    """There is a transform between two frames."""

    def __init__(self, owner: Conditions, fields: Json) -> None:
        super().__init__(owner, fields)
        self._wanted = (self._name, str(self._value))
        self._subscriptions: list[Any] = []
        #: The parents of frames.
        self._parents: dict[str, str] = {}

    def look(self, now: float) -> None:
        """Wait for transforms."""

    def explain(self) -> str:
        """Return what connects the frames, as a part of a sentence."""
        if not self._parents:
            return 'no transforms arrive'
        frames = self._frames
        for wanted in self._wanted:
            if wanted not in frames:
                near = get_close_matches(wanted, sorted(frames), 1)
                there = f', but {near[0]}' if near else ''
                return f'there is no frame {wanted}{there}'
        first, second = map(self._root, self._wanted)
        return f'they are in separate trees, below {first} and {second}'

    def _begin(self) -> None:
        # processes that have ended do not send static transforms again
        self._stop()
        self._parents = {}
        qos = importlib.import_module('rclpy.qos')
        messages = importlib.import_module('tf2_msgs.msg')
        static = qos.QoSProfile(
            depth=100, durability=qos.DurabilityPolicy.TRANSIENT_LOCAL
        )
        # as tf2_ros has them
        for topic, profile in (
            ('/tf', qos.QoSProfile(depth=100)),
            ('/tf_static', static),
        ):
            self._subscriptions.append(
                self._ros.node.create_subscription(
                    messages.TFMessage, topic, self._add, profile
                )
            )

    def _stop(self) -> None:
        for subscription in self._subscriptions:
            self._ros.node.destroy_subscription(subscription)
        self._subscriptions = []

    @property
    def _frames(self) -> set[str]:
        return {*self._parents, *self._parents.values()}

    def _add(self, message: Any) -> None:
        for one in message.transforms:
            # tf2 ignores the slash, too
            child = one.child_frame_id.lstrip('/')
            self._parents[child] = one.header.frame_id.lstrip('/')
        first, second = self._wanted
        is_known = {first, second} <= self._frames
        if is_known and self._root(first) == self._root(second):
            self._succeed()

    def _root(self, frame: str) -> str:
        """Return the root of the tree that a frame is in."""
        way = [frame]
        while frame in self._parents:
            frame = self._parents[frame]
            if frame in way:
                # the frames of a cycle have none: choose one of them
                return min(way[way.index(frame) :])
            way.append(frame)
        return frame


_KINDS: dict[str, type[Condition]] = {
    'topic': Topic,
    'service': Service,
    'action': Action,
    'node': Node,
    'lifecycle': Lifecycle,
    'parameter': Parameter,
    'transform': Transform,
}


class Conditions:
    """The conditions that the launch has asked for."""

    def __init__(self, ros: Ros) -> None:
        self.ros = ros
        #: The graph at the last look.
        self.graph = Graph(ros.node)
        self._known: dict[str, Condition] = {}
        self._looked = 0.0
        #: When to look at the graph again, None for at its next change.
        self._due: float | None = None

    def begin(self, request: Json) -> None:
        """Begin to check a condition."""
        self._condition(request).begin(request['id'])
        self.look_soon()

    def explain(self, request: Json) -> None:
        """Answer what exists instead of what a condition waits for."""
        condition = self._condition(request)
        self.graph = Graph(self.ros.node)
        self.ros.answer(request['id'], ok=True, found=condition.explain())

    def cancel(self, request: int) -> bool:
        """End the check of a request; return whether there is one."""
        for condition in self._known.values():
            if condition.request == request:
                condition.cancel()
                return True
        return False

    def lose(self, member: str) -> None:
        """Handle the end of a process."""
        self.graph = Graph(self.ros.node)
        for condition in self._known.values():
            if condition.member == member:
                condition.lose(time.monotonic())

    def look_soon(self) -> None:
        """Look at the graph soon, as it has changed."""
        if self._due is None or self._due > self._looked + LOOK_INTERVAL:
            self._due = self._looked + LOOK_INTERVAL

    @property
    def due(self) -> float | None:
        """When to call `look`, None if nothing changes until then."""
        moments = [] if self._due is None else [self._due]
        for condition in self._known.values():
            if condition.due is not None:
                moments.append(condition.due)
        return min(moments) if moments else None

    def look(self, now: float) -> None:
        """Look at the graph if that is due."""
        due = self.due
        if due is None or now < due:
            return
        self._due = None
        self._looked = now
        self.graph = Graph(self.ros.node)
        for condition in list(self._known.values()):
            if condition.request is not None:
                condition.look(now)

    def _condition(self, request: Json) -> Condition:
        fields = ('member', 'kind', 'name', 'value', 'message', 'node')
        key = repr([request.get(field) for field in fields])
        if key not in self._known:
            self._known[key] = _KINDS[request['kind']](self, request)
        return self._known[key]


def _identities_of(endpoints: Any) -> Identities:
    return frozenset(bytes(one.endpoint_gid) for one in endpoints)


def _names_by_node(read: Callable[[str, str], Any], node: str) -> list[str]:
    namespace, _, name = node.rpartition('/')
    try:
        return [found for found, _ in read(name, namespace or '/')]
    except Exception:  # noqa: BLE001 - the node is not there
        return []


def _without_hidden(names: Iterable[str]) -> list[str]:
    return [name for name in names if '/_' not in name]


def _actions(services: Iterable[str]) -> list[str]:
    return [s[: -len(_SEND_GOAL)] for s in services if s.endswith(_SEND_GOAL)]


def _message_type(name: str) -> Any:
    package, _, kind = name.partition('/')
    module = importlib.import_module(f'{package}.msg')
    return getattr(module, kind.rpartition('/')[2])


def _is_same(value: Any, wanted: Any) -> bool:
    """Compare values; a truth value is no number."""
    if isinstance(value, bool) or isinstance(wanted, bool):
        return value is wanted
    return bool(value == wanted)


def _joined(namespace: str, name: str) -> str:
    return f'{namespace.rstrip("/")}/{name}'
