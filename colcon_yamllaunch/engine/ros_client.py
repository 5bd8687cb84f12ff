# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The program that uses ROS for a launch: containers, states, the clock.

It runs with the Python of the sourced environment, from 3.8 on and Humble on;
`ros_link` starts it. It imports nothing of this project, and other packages
only after it has reported which of them are missing.

It reads requests from its standard input and writes answers and events to its
standard output, as JSON, one a line. It ends when its input does. Standard
error is free text for a log. SIGINT is ignored: a terminal's Ctrl-C is the
launcher's.

Events:

    {"event": "found", "missing": ["composition_interfaces"]}
        the first line: which of the modules in its arguments are missing; if
        any is, it ends
    {"event": "ready"}
    {"event": "container", "container": "/box", "there": true}
        for each container named in a load or list, when its service comes
        (true) or goes; one that is replaced goes and comes
    {"event": "state", "node": "/a", "state": "inactive",
     "from": "configuring"}
        `from` is null if it is unknown
    {"event": "clock", "seconds": 12.5}
        at most 20 a second
    {"event": "trouble", "text": "…"}

Requests have an `id`, which the answer has too, with `ok`, and `reason` if
that is false:

    {"id": 1, "do": "load", "container": "/box", "package": "p",
     "plugin": "a::B", "name": "n", "namespace": "/ns", "remaps": ["a:=b"],
     "parameters": [["x.y", 1.0]], "extra_arguments": []}
        waits for the container, and for the loads that were asked before;
        answered with `full_name` and `unique_id`, or the container's reason.
        Doubles have a point or an exponent, or are NaN or Infinity.
    {"id": 2, "do": "unload", "container": "/box", "unique_id": 3}
    {"id": 3, "do": "list", "container": "/box"}
        answered with `nodes`: [["/ns/n", 3]]
    {"id": 4, "do": "cancel", "request": 1}
        has no answer; that request fails with the reason "cancelled" if it is
        still open. If it comes too late for a load, the component is unloaded.
    {"id": 5, "do": "follow", "node": "/a"}
        sends the states of a lifecycle node from now on
    {"id": 6, "do": "change_state", "node": "/a", "transition": "configure"}
        waits for the node, and for the changes that were asked before
    {"id": 7, "do": "clock"}
        sends the time of /clock from now on
    {"id": 8, "do": "gone", "container": "/box"}
        (or "node") the process that had it has ended. Without this, one that
        crashed is noticed when the middleware gives it up, which takes Fast
        DDS 20 s, or when another one comes in its place.

The requests "await" and "explain", and "gone" with a "member", are about what
must hold until something is ready; see `ros_conditions`, which is imported for
them.

The middleware may lose the response to a call: rmw_fastrtps drops it if the
server has not found the client within 0.1 s (ros2/rmw_fastrtps#392).
Without a response, the outcome of a load, an unload or a change follows from
the list of the container, or from the state of the node; it is not sent again.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
import ctypes
from dataclasses import dataclass
import importlib
import importlib.util
import json
import os
import signal
import sys
import threading
import time
from typing import Any, TYPE_CHECKING

#: Seconds between two events with the time of /clock.
CLOCK_PERIOD = 0.05
#: Seconds after a change of the graph at which it is looked at again, as what
#: is found may not be connected at once; each wait doubles, from the first to
#: the last.
FIRST_LOOK = 0.005
LAST_LOOK = 2.5
#: Seconds between two looks if no event reports changes of the graph.
POLL_PERIOD = 0.25
#: Seconds until a server that replaces another one is connected, while the
#: number of connections still includes those of the other one.
CONNECTING = 0.05
#: Seconds until a node is asked for its state, if it has not reported the one
#: that follows from a transition.
STATE_TIMEOUT = 0.3
#: Seconds without an answer until the outcome of a call is looked for, as the
#: middleware may lose answers; each wait doubles.
ANSWER_TIMEOUT = 5.0
#: How many such searches may find no outcome until the call is given up.
MAXIMUM_CHECKS = 3
READ_SIZE = 1 << 16
#: Log messages go to standard error only, not to a file or a topic.
QUIET = ('--disable-external-lib-logs', '--disable-rosout-logs')

#: The number of a transition, where it has one whatever the state is
#: (lifecycle_msgs/msg/Transition), the states that it starts from, and the
#: one that it leads to.
TRANSITIONS = {
    'configure': (1, ('unconfigured',), 'inactive'),
    'cleanup': (2, ('inactive',), 'unconfigured'),
    'activate': (3, ('inactive',), 'active'),
    'deactivate': (4, ('active',), 'inactive'),
    'shutdown': (0, ('unconfigured', 'inactive', 'active'), 'finalized'),
}
#: The states that a node stays in (primary states).
STATES = {'unconfigured', 'inactive', 'active', 'finalized'}
#: Stands for any server if the middleware has no identities of them.
SOME_SERVER = b'?'

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.ros_conditions import Conditions

    # as code, this needs 3.9
    Json = dict[str, Any]
    Servers = frozenset[bytes]


class CallRefused(Exception):  # noqa: N818 - it is an answer
    """A request cannot be done, with the reason."""


class Output:
    """Writes lines to the original standard output."""

    def __init__(self) -> None:
        self._descriptor = os.dup(1)
        # other prints, by any library, are not for the engine
        os.dup2(2, 1)

    def write(self, **fields: Any) -> None:
        """Write a line, or end if nobody reads."""
        data = (json.dumps(fields) + '\n').encode()
        try:
            while data:
                data = data[os.write(self._descriptor, data) :]
        except BrokenPipeError:
            os._exit(1)


class Input:
    """
    Reads requests in a thread, from before ROS is up.

    :ivar wake: Called when there is a request
    """

    def __init__(self) -> None:
        self.wake: Callable[[], object] = _nothing
        self.has_ended = False
        self._lines: deque[bytes] = deque()
        threading.Thread(target=self._read, daemon=True).start()

    def next_line(self) -> bytes | None:
        """Return the next line, None if there is none."""
        return self._lines.popleft() if self._lines else None

    def _read(self) -> None:
        rest = b''
        while True:
            data = os.read(0, READ_SIZE)
            if not data:
                self.has_ended = True
                self.wake()
                return
            *lines, rest = (rest + data).split(b'\n')
            self._lines.extend(lines)
            if lines:
                self.wake()


@dataclass(eq=False)
class Call:
    """
    A call of a service.

    :param request: The id of the request that it is for, None for none
    :param service: The last part of the service's name
    :param message: The request message
    :param answered: Called with the response
    :param refused: Called with the reason why there is none
    """

    request: int | None
    service: str
    message: Any
    answered: Callable[[Any], None]
    refused: Callable[[str], None]
    future: Any = None
    #: The state that the node had when the call was sent, if it is known.
    state: str | None = None
    #: The servers that have received the call.
    servers: Servers = frozenset()
    #: Whether the call is not sent again, to a server that replaces them.
    is_final: bool = False
    #: Looks for the outcome of the call. A call without this function changes
    #: nothing, so it is just sent again.
    check_outcome: Callable[[], None] | None = None
    #: The call that looks for the outcome.
    question: Call | None = None
    #: How many of these searches found no outcome.
    failed_checks: int = 0
    #: Seconds until the next search, and when it is due.
    timeout: float = ANSWER_TIMEOUT
    due: float = 0.0


class Peer:
    """
    A node with services: a container, or a lifecycle node.

    The identity of the servers distinguishes processes with its name, as a
    crashed one stays visible for a while beside the one that takes its place.

    :param ros: The ROS node of this program
    :param name: Its full name
    :param noun: What it is called in reasons
    :param services: The types of its services by the end of their names; the
      first one shows whether it is there
    """

    def __init__(
        self, ros: Ros, name: str, noun: str, services: dict[str, Any]
    ) -> None:
        self.name = name
        self.is_present = False
        #: The state that a lifecycle node is known to have.
        self.state: str | None = None
        self._ros = ros
        self._noun = noun
        self._clients = {
            end: ros.node.create_client(kind, f'{name}/{end}')
            for end, kind in services.items()
        }
        main = next(iter(services))
        self._main_client = self._clients[main]
        self._replies = f'rr{name}/{main}Reply'
        #: What is called one after the other.
        self._queue: deque[Call] = deque()
        self._running: list[Call] = []
        #: The servers that are still visible, but have ended.
        self._gone: Servers = frozenset()
        self._current: Servers = frozenset()
        self._connected_at = 0.0

    @property
    def is_unsettled(self) -> bool:
        """Whether to look at the node again, without any news of it."""
        head = self._queue_head
        waits = [*self._running, *([head] if head else [])]
        is_sent = all(call.servers & self._current for call in waits)
        return not is_sent or bool(self._current) != self.is_present

    @property
    def due(self) -> list[float]:
        """When there is something to ask again."""
        return [one.due for one in self._running if one.future is not None]

    def on_presence(self) -> None:
        """Handle that the node came or went."""

    def check(self, now: float) -> None:
        """Find the servers that exist now, and send them the calls."""
        present = self._servers()
        self._name(present - self._gone)
        before = self._current
        candidates = present - self._gone
        fresh = candidates - before
        # one that comes takes the place of those before
        self._current = fresh or before & candidates
        self._gone = present - self._current
        if fresh and self._gone:
            self._connected_at = now + CONNECTING
        if before and not before & self._current:
            self._set_present(False)
            self._lose()
        is_ready = self._main_client.service_is_ready()
        is_connected = now >= self._connected_at
        self._set_present(bool(self._current) and is_ready and is_connected)
        self._repeat()
        self._send_next()

    def ask_again(self, now: float) -> None:
        """Query the outcome of calls without an answer."""
        for call in list(self._running):
            if call.future is None or now < call.due:
                continue
            call.timeout *= 2
            call.due = now + call.timeout
            if call.check_outcome is not None:
                call.check_outcome()
            elif self._can_send(call):
                self._transmit(call)

    def lose(self) -> None:
        """Handle the end of its process."""
        self._gone |= self._servers()
        for call in self._running:
            call.is_final = True
        self.check(time.monotonic())

    def call(self, call: Call) -> None:
        """Call a service at once, only of the server that exists now."""
        call.is_final = True
        if not self.is_present:
            call.refused('not there')
        else:
            self._send(call)

    def call_in_order(self, call: Call) -> None:
        """Call a service when it is there, after all such calls before."""
        self._queue.append(call)
        self._send_next()

    def cancel(self, request: int) -> bool:
        """
        Give up a call.

        :returns: whether there was one
        """
        for call in [*self._queue, *self._running]:
            if call.request == request:
                self._give_up(call, 'cancelled')
                return True
        return False

    @property
    def _queue_head(self) -> Call | None:
        return self._queue[0] if self._queue else None

    def _servers(self) -> Servers:
        """Return the identities of those that have the main service."""
        found = self._ros.node.get_publishers_info_by_topic(
            self._replies, no_mangle=True
        )
        servers = frozenset(bytes(one.endpoint_gid) for one in found)
        if not servers and self._main_client.service_is_ready():
            return frozenset({SOME_SERVER})
        return servers

    def _name(self, servers: Servers) -> None:
        """
        Identify servers without names with those that have names.

        The graph may report them after a client is connected; a call that was
        sent in between has arrived, and must not be sent again.
        """
        unnamed = frozenset({SOME_SERVER})
        if self._current == unnamed and servers and servers != unnamed:
            self._current = servers
            for call in self._running:
                if call.servers == unnamed:
                    call.servers = servers

    def _ask_about(
        self,
        call: Call,
        service: str,
        message: Any,
        answered: Callable[[Any], None],
    ) -> None:
        """
        Ask for the outcome of a call, unless that was asked already.

        :param answered: Called with the response if the call is still open
        """

        def received(response: Any) -> None:
            if call in self._running:
                answered(response)

        if call.question not in self._running:
            call.question = Call(None, service, message, received, _nothing)
            self.call(call.question)

    def _check_failed(self, call: Call, reason: str) -> None:
        """Count a check without an effect; after some, give the call up."""
        call.failed_checks += 1
        if call.failed_checks == MAXIMUM_CHECKS:
            self._give_up(call, f'there was no answer, and {reason}')

    def _give_up(self, call: Call, reason: str) -> None:
        """Refuse a call, but recognize a late answer."""
        call.request = None
        call.is_final = True
        if call in self._queue:
            self._queue.remove(call)
        refused, call.refused = call.refused, _nothing
        refused(reason)
        self._send_next()

    def _set_present(self, is_present: bool) -> None:
        if is_present != self.is_present:
            self.is_present = is_present
            self.on_presence()

    def _lose(self) -> None:
        """Refuse lost calls, unless another server may receive them."""
        for call in list(self._running):
            is_lost = not call.servers & self._current
            if is_lost and (call.is_final or not self._current):
                self._end(call)
                call.refused(f'the {self._noun} has ended')

    def _repeat(self) -> None:
        """
        Send calls again that only ended servers have received.

        They may have ended before, as this is noticed late.
        """
        for call in self._running:
            if not call.servers & self._current and self._can_send(call):
                call.is_final = True
                self._transmit(call)

    def _send_next(self) -> None:
        head = self._queue_head
        if head and head not in self._running and self._can_send(head):
            self._send(head)

    def _can_send(self, call: Call) -> bool:
        """Return whether a call arrives, as each service has a connection."""
        client = self._clients[call.service]
        return self.is_present and bool(client.service_is_ready())

    def _send(self, call: Call) -> None:
        self._running.append(call)
        if self._can_send(call):
            self._transmit(call)
        else:
            self._ros.look_soon()

    def _transmit(self, call: Call) -> None:
        self._forget(call)
        call.state = self.state
        call.servers = self._current
        call.due = time.monotonic() + call.timeout
        call.future = self._clients[call.service].call_async(call.message)
        call.future.add_done_callback(lambda future: self._done(call, future))

    def _done(self, call: Call, future: Any) -> None:
        if future is not call.future or call not in self._running:
            return
        self._answer(call, future.result())

    def _answer(self, call: Call, response: Any) -> None:
        self._end(call)
        call.answered(response)
        self._send_next()

    def _end(self, call: Call) -> None:
        self._forget(call)
        self._running.remove(call)
        if call is self._queue_head:
            self._queue.popleft()

    def _forget(self, call: Call) -> None:
        future, call.future = call.future, None
        if future is not None:
            self._clients[call.service].remove_pending_request(future)


class Container(Peer):
    """A component container."""

    def __init__(self, ros: Ros, name: str) -> None:
        kinds = importlib.import_module('composition_interfaces.srv')
        self._kinds = kinds
        services = {
            '_container/load_node': kinds.LoadNode,
            '_container/unload_node': kinds.UnloadNode,
            '_container/list_nodes': kinds.ListNodes,
        }
        super().__init__(ros, name, 'container', services)
        #: The last unique id that is known; a container counts them up.
        self._last_id = 0

    def on_presence(self) -> None:
        """Report to the engine that the container came or went."""
        self._ros.output.write(
            event='container', container=self.name, there=self.is_present
        )

    def _lose(self) -> None:
        self._last_id = 0
        super()._lose()

    def load(self, request: Json) -> None:
        """Load a component, after those before."""
        message = self._kinds.LoadNode.Request()
        message.package_name = request['package']
        message.plugin_name = request['plugin']
        message.node_name = request.get('name', '')
        message.node_namespace = request.get('namespace', '')
        message.remap_rules = request.get('remaps', [])
        message.parameters = parameters(request.get('parameters', []))
        message.extra_arguments = parameters(
            request.get('extra_arguments', [])
        )
        call = self._ros.call(request, '_container/load_node', message)
        answer = call.answered

        def answered(response: Any) -> None:
            if response.success:
                self._last_id = max(self._last_id, response.unique_id)
            if call.request is not None:
                answer(response)
            elif response.success:
                self.unload({'id': None, 'unique_id': response.unique_id})

        call.answered = answered
        call.check_outcome = lambda: self._find_loaded(call)
        self.call_in_order(call)

    def unload(self, request: Json) -> None:
        """Unload a component at once."""
        message = self._kinds.UnloadNode.Request()
        message.unique_id = request['unique_id']
        call = self._ros.call(request, '_container/unload_node', message)
        call.check_outcome = lambda: self._find_unloaded(call)
        self.call(call)

    def list(self, request: Json) -> None:
        """List the loaded components."""
        message = self._kinds.ListNodes.Request()
        self.call(self._ros.call(request, '_container/list_nodes', message))

    def _find_loaded(self, call: Call) -> None:
        """
        Search the list of the container for the component of a load.

        The load is not sent again if there is none: it may still come.
        """
        asked = call.message
        full_name = f'{asked.node_namespace}/{asked.node_name}'.strip('/')

        def listed(response: Any) -> None:
            pairs = zip(  # noqa: B905 - `strict` needs 3.10
                response.full_node_names, response.unique_ids
            )
            fresh = [pair for pair in pairs if pair[1] > self._last_id]
            named = [pair for pair in fresh if pair[0] == f'/{full_name}']
            # a component may have a name of its own choice
            found = named or fresh
            if len(found) == 1:
                [(name, unique_id)] = found
                loaded = self._kinds.LoadNode.Response(
                    success=True, full_node_name=name, unique_id=unique_id
                )
                self._answer(call, loaded)
            else:
                self._check_failed(call, 'the container does not list it')

        self._ask_list(call, listed)

    def _find_unloaded(self, call: Call) -> None:
        """Check whether the container no longer lists a component."""

        def listed(response: Any) -> None:
            if call.message.unique_id in response.unique_ids:
                self._check_failed(call, 'the container still lists it')
            else:
                unloaded = self._kinds.UnloadNode.Response(success=True)
                self._answer(call, unloaded)

        self._ask_list(call, listed)

    def _ask_list(self, call: Call, listed: Callable[[Any], None]) -> None:
        message = self._kinds.ListNodes.Request()
        self._ask_about(call, '_container/list_nodes', message, listed)


class LifecycleNode(Peer):
    """A node with states."""

    def __init__(self, ros: Ros, name: str) -> None:
        kinds = importlib.import_module('lifecycle_msgs.srv')
        self._kinds = kinds
        services = {
            'get_state': kinds.GetState,
            'change_state': kinds.ChangeState,
        }
        super().__init__(ros, name, 'node', services)
        self._subscription: Any = None
        #: The state after a transition, until the node reports it.
        self._expected: str | None = None
        self._refresh_at = 0.0
        #: The number of reported transitions, to recognize old states.
        self._transitions = 0
        #: Called when the node has another state.
        self.listeners: list[Callable[[], object]] = []

    @property
    def is_unsettled(self) -> bool:
        """Whether to look at the node again, without any news of it."""
        return super().is_unsettled or self._expected is not None

    def check(self, now: float) -> None:
        """Ask for the state, too, if the node should have reported it."""
        super().check(now)
        if self._expected is not None and now >= self._refresh_at:
            self._expected = None
            self._refresh()

    def on_presence(self) -> None:
        """Ask for the state of a node that comes."""
        self.state = self._expected = None
        if self.is_present:
            self._refresh()

    def follow(self, request: Json) -> None:
        """Report the states from now on."""
        self.subscribe()
        self._ros.answer(request['id'], ok=True)

    def subscribe(self) -> None:
        """Follow the states from now on."""
        if self._subscription is None:
            messages = importlib.import_module('lifecycle_msgs.msg')
            self._subscription = self._ros.node.create_subscription(
                messages.TransitionEvent,
                f'{self.name}/transition_event',
                self._on_transition,
                10,
            )
            self._refresh()

    def change_state(self, request: Json) -> None:
        """Change the state, after the changes before."""
        transition = request['transition']
        if transition not in TRANSITIONS:
            raise CallRefused(f'there is no transition {transition!r}')
        message = self._kinds.ChangeState.Request()
        message.transition.id = TRANSITIONS[transition][0]
        message.transition.label = transition
        call = self._ros.call(request, 'change_state', message)

        def answered(response: Any) -> None:
            if response.success:
                self._ros.answer(call.request, ok=True)
                self._expect(TRANSITIONS[transition][2])
            else:
                self._explain(call.request, transition, call.state)

        call.answered = answered
        call.check_outcome = lambda: self._find_changed(call, transition)
        self.call_in_order(call)

    def _find_changed(self, call: Call, transition: str) -> None:
        """
        Find out from the state whether a change was made or refused.

        It is not sent again if neither: it may still be made.
        """
        _, starts, goal = TRANSITIONS[transition]

        def answered(response: Any) -> None:
            state = response.current_state.label
            is_made = state == goal != call.state
            if is_made or state in STATES - {*starts}:
                self._answer(
                    call, self._kinds.ChangeState.Response(success=is_made)
                )
            elif state in starts:
                self._check_failed(call, f'the node is {state!r}')

        message = self._kinds.GetState.Request()
        self._ask_about(call, 'get_state', message, answered)

    def _expect(self, state: str) -> None:
        """Ask for the state if the node does not report it for a while."""
        if self._subscription is not None and state != self.state:
            self._expected = state
            self._refresh_at = time.monotonic() + STATE_TIMEOUT
            self._ros.look_soon()

    def _explain(
        self, request: int | None, transition: str, before: str | None
    ) -> None:
        """Answer that a change was refused, with a state for the reason."""

        def refused(reason: str = '') -> None:
            text = reason or f'{transition!r} failed'
            self._ros.answer(request, ok=False, reason=text)

        def answered(response: Any) -> None:
            state = response.current_state.label
            self._report_state(state, None)
            start = before or state
            if start in TRANSITIONS[transition][1]:
                refused(f'{transition!r} failed, the node is {state!r}')
            else:
                refused(f'{transition!r} is not possible in {state!r}')

        message = self._kinds.GetState.Request()
        self.call(Call(None, 'get_state', message, answered, refused))

    def _refresh(self) -> None:
        """Ask for the state, and report it unless a later one arrives."""
        if self._subscription is None or not self.is_present:
            return
        known = self._transitions

        def answered(response: Any) -> None:
            if known == self._transitions:
                self._report_state(response.current_state.label, None)

        message = self._kinds.GetState.Request()
        self.call(Call(None, 'get_state', message, answered, _nothing))

    def _on_transition(self, event: Any) -> None:
        self._transitions += 1
        self._report_state(event.goal_state.label, event.start_state.label)

    def _report_state(self, state: str, before: str | None) -> None:
        if self._subscription is None or state == self.state:
            return
        if before is None:
            before = self.state
        self.state = state
        if state == self._expected:
            self._expected = None
        # `from` is a word of Python
        fields = {'node': self.name, 'state': state, 'from': before}
        self._ros.output.write(event='state', **fields)
        for listener in self.listeners:
            listener()


class ParameterNode(Peer):
    """A node with parameters."""

    def __init__(self, ros: Ros, name: str) -> None:
        self._kinds = importlib.import_module('rcl_interfaces.srv')
        services = {
            'get_parameters': self._kinds.GetParameters,
            'list_parameters': self._kinds.ListParameters,
        }
        super().__init__(ros, name, 'node', services)
        #: Called when the node comes or goes.
        self.listeners: list[Callable[[], object]] = []

    def on_presence(self) -> None:
        """Report that the node came or went."""
        for listener in self.listeners:
            listener()

    def get(self, parameter: str, answered: Callable[[Any], None]) -> None:
        """Ask for the value of a parameter."""
        message = self._kinds.GetParameters.Request(names=[parameter])
        self.call(Call(None, 'get_parameters', message, answered, _nothing))

    def list_names(self, answered: Callable[[Any], None]) -> None:
        """Ask for the names of all parameters."""
        message = self._kinds.ListParameters.Request()
        self.call(Call(None, 'list_parameters', message, answered, _nothing))


class Clock:
    """Reports the time of /clock, and sleeps between two reports."""

    def __init__(self, ros: Ros) -> None:
        groups = importlib.import_module('rclpy.callback_groups')
        qos = importlib.import_module('rclpy.qos')
        messages = importlib.import_module('rosgraph_msgs.msg')
        self.due = 0.0
        self._output = ros.output
        clock = self

        class Group(groups.MutuallyExclusiveCallbackGroup):  # type: ignore
            """Takes no message before one is due, so that none wakes us."""

            def can_execute(self, entity: Any) -> bool:
                is_due = time.monotonic() >= clock.due
                return is_due and bool(super().can_execute(entity))

        ros.node.create_subscription(
            messages.Clock,
            '/clock',
            self._on_clock,
            qos.QoSProfile(
                depth=1, reliability=qos.ReliabilityPolicy.BEST_EFFORT
            ),
            callback_group=Group(),
        )

    def _on_clock(self, message: Any) -> None:
        self.due = time.monotonic() + CLOCK_PERIOD
        seconds = message.clock.sec + message.clock.nanosec / 1e9
        self._output.write(event='clock', seconds=seconds)


class Ros:
    """
    What this program is in ROS, and its loop.

    :param output: Where answers and events go
    :param requests: Where requests come from
    """

    def __init__(self, output: Output, requests: Input) -> None:
        rclpy = importlib.import_module('rclpy')
        executors = importlib.import_module('rclpy.executors')
        signals = importlib.import_module('rclpy.signals')
        rclpy.init(
            args=['--ros-args', *QUIET],
            signal_handler_options=signals.SignalHandlerOptions.NO,
        )
        self.output = output
        self.node = _make_node()
        self._rclpy = rclpy
        self._requests = requests
        self._executor = executors.SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._peers: dict[tuple[type, str], Any] = {}
        self._clock: Clock | None = None
        self._conditions: Conditions | None = None
        self._next_look: float | None = None
        self._pause = FIRST_LOOK
        self._is_notified = _watch_graph(self.node, self.look_soon)
        wake = self.node.create_guard_condition(_nothing)
        requests.wake = wake.trigger

    def run(self) -> None:
        """Serve until there are no requests any more."""
        self.output.write(event='ready')
        while not self._requests.has_ended:
            line = self._requests.next_line()
            if line is not None:
                self._handle(line)
                continue
            self._look()
            self._executor.spin_once(timeout_sec=self._seconds_to_wait())
        self._rclpy.shutdown()

    def call(self, request: Json, service: str, message: Any) -> Call:
        """Return a call that answers a request in the usual way."""
        call: Call

        def answered(response: Any) -> None:
            fields = _fields(response)
            self.answer(call.request, **fields)

        def refused(reason: str) -> None:
            self.answer(request['id'], ok=False, reason=reason)

        call = Call(request['id'], service, message, answered, refused)
        return call

    def answer(self, request: int | None, **fields: Any) -> None:
        """Answer a request, unless it was cancelled."""
        if request is not None:
            self.output.write(id=request, **fields)

    def _handle(self, line: bytes) -> None:
        try:
            request = json.loads(line)
            number, handler = request['id'], _HANDLERS[request['do']]
        except (ValueError, LookupError, TypeError):
            text = line.decode(errors='replace')
            self.output.write(event='trouble', text=f'strange request: {text}')
            return
        try:
            handler(self, request)
        except CallRefused as e:
            self.answer(number, ok=False, reason=str(e))
        except Exception as e:  # noqa: BLE001 - ROS has many for bad names
            reason = f'{type(e).__name__}: {e}'
            self.answer(number, ok=False, reason=reason)

    def _cancel(self, request: Json) -> None:
        number = request['request']
        if self._conditions is None or not self._conditions.cancel(number):
            any(peer.cancel(number) for peer in self._peers.values())

    def _gone(self, request: Json) -> None:
        if self._conditions is not None and 'member' in request:
            self._conditions.lose(request['member'])
        for peer in self._peers.values():
            if peer.name in (request.get('container'), request.get('node')):
                peer.lose()
        self.answer(request['id'], ok=True)

    def _follow_clock(self, request: Json) -> None:
        if self._clock is None:
            self._clock = Clock(self)
        self.answer(request['id'], ok=True)

    def _container(self, request: Json) -> Any:
        return self._peer(Container, request['container'])

    def lifecycle_node(self, name: str) -> LifecycleNode:
        """Return a lifecycle node, by its full name."""
        node: LifecycleNode = self._peer(LifecycleNode, name)
        return node

    def parameter_node(self, name: str) -> ParameterNode:
        """Return a node with parameters, by its full name."""
        node: ParameterNode = self._peer(ParameterNode, name)
        return node

    @property
    def conditions(self) -> Conditions:
        """The conditions of readiness."""
        if self._conditions is None:
            # few launches have any
            path = os.path.join(os.path.dirname(__file__), 'ros_conditions.py')
            spec = importlib.util.spec_from_file_location('conditions', path)
            assert spec is not None and spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
            self._conditions = module.Conditions(self)
        conditions: Conditions = self._conditions
        return conditions

    def _peer(self, kind: type, name: str) -> Any:
        if (kind, name) not in self._peers:
            self._peers[kind, name] = kind(self, name)
            self.look_soon()
            self._look()
        return self._peers[kind, name]

    def look_soon(self) -> None:
        """Read the graph now, and frequently for a while."""
        self._pause = FIRST_LOOK
        self._next_look = 0.0
        if self._conditions is not None:
            self._conditions.look_soon()

    def _look(self) -> None:
        """Read the graph if that is due, and after calls."""
        now = time.monotonic()
        peers = self._peers.values()
        for peer in peers:
            peer.ask_again(now)
        if self._conditions is not None:
            self._conditions.look(now)
        if self._next_look is None or now < self._next_look:
            return
        for peer in peers:
            peer.check(now)
        self._next_look = None
        is_unsettled = any(peer.is_unsettled for peer in peers)
        if is_unsettled:
            self._next_look = now + self._pause
            self._pause = min(2 * self._pause, LAST_LOOK)
        is_polled = not self._is_notified and self._next_look is None
        if is_polled and (peers or self._conditions is not None):
            self._next_look = now + POLL_PERIOD
            if self._conditions is not None:
                self._conditions.look_soon()

    def _seconds_to_wait(self) -> float | None:
        now = time.monotonic()
        moments = [] if self._next_look is None else [self._next_look]
        if self._clock is not None and self._clock.due > now:
            moments.append(self._clock.due)
        if self._conditions is not None and self._conditions.due is not None:
            moments.append(self._conditions.due)
        for peer in self._peers.values():
            moments += peer.due
        # zero would be a poll of ROS, less means forever
        return max(0.0005, min(moments) - now) if moments else None


_HANDLERS: dict[str, Callable[[Ros, Json], object]] = {
    'load': lambda ros, request: ros._container(request).load(request),
    'unload': lambda ros, request: ros._container(request).unload(request),
    'list': lambda ros, request: ros._container(request).list(request),
    'follow': lambda ros, request: ros.lifecycle_node(request['node']).follow(
        request
    ),
    'change_state': lambda ros, request: ros.lifecycle_node(
        request['node']
    ).change_state(request),
    'await': lambda ros, request: ros.conditions.begin(request),
    'explain': lambda ros, request: ros.conditions.explain(request),
    'cancel': Ros._cancel,
    'clock': Ros._follow_clock,
    'gone': Ros._gone,
}


def parameters(pairs: list[tuple[str, Any]]) -> list[Any]:
    """
    Return parameters as messages.

    :raises CallRefused: if there is no type for a value
    """
    return [_parameter(name, value) for name, value in pairs]


def _parameter(name: str, value: Any) -> Any:
    kind = importlib.import_module('rclpy.parameter').Parameter
    refused = CallRefused(f'the parameter {name!r} cannot be {value!r}')
    kinds = {*map(type, value)} if isinstance(value, list) else {type(value)}
    # rclpy takes a truth value for a number, and no list for one of bytes
    if not kinds or {bool, int} <= kinds or value is None:
        raise refused
    try:
        if kinds == {int, float}:
            value = [float(one) for one in value]
        return kind(name, value=value).to_parameter_msg()
    except TypeError:
        raise refused from None


def _fields(response: Any) -> Json:
    """Return the fields of an answer for a response of a container."""
    if hasattr(response, 'unique_ids'):
        pairs = zip(  # noqa: B905 - `strict` needs 3.10
            response.full_node_names, response.unique_ids
        )
        return {'ok': True, 'nodes': [list(pair) for pair in pairs]}
    if not response.success:
        return {'ok': False, 'reason': response.error_message}
    if hasattr(response, 'unique_id'):
        return {
            'ok': True,
            'full_name': response.full_node_name,
            'unique_id': response.unique_id,
        }
    return {'ok': True}


def _make_node() -> Any:
    """Return a hidden node with nothing that it does not need."""
    parameter = importlib.import_module('rclpy.parameter').Parameter
    return importlib.import_module('rclpy.node').Node(
        f'_colcon_launch_{os.getpid()}',
        use_global_arguments=False,
        enable_rosout=False,
        start_parameter_services=False,
        parameter_overrides=[
            parameter('start_type_description_service', value=False)
        ],
    )


def _watch_graph(node: Any, changed: Callable[[], None]) -> bool:
    """
    Wake the executor up when a node or service comes or goes.

    rclpy lacks the condition that rcl has for it, but its wait sets and nodes
    allow to add it.

    :returns: whether that works here
    """
    waitables = importlib.import_module('rclpy.waitable')
    binding = importlib.import_module('rclpy.impl.implementation_singleton')
    try:
        # the handle of the binding finds the libraries that it is linked with
        rcl = ctypes.CDLL(binding.rclpy_implementation.__file__)
        get_condition = rcl.rcl_node_get_graph_guard_condition
        add_condition = rcl.rcl_wait_set_add_guard_condition
        get_condition.restype = ctypes.c_void_p
        get_condition.argtypes = [ctypes.c_void_p]
        add_condition.argtypes = [ctypes.c_void_p] * 3
        condition = get_condition(node.handle.pointer)
    except (AttributeError, OSError) as e:
        print(f'Changes of the graph are polled: {e}', file=sys.stderr)
        return False

    class Graph(waitables.Waitable):  # type: ignore
        """The condition that the graph has changed."""

        def __init__(self) -> None:
            super().__init__(node.default_callback_group)
            self._index = ctypes.c_size_t()

        def __enter__(self) -> None:
            node.handle.__enter__()

        def __exit__(self, *arguments: Any) -> None:
            node.handle.__exit__(*arguments)

        def get_num_entities(self) -> Any:
            return waitables.NumberOfEntities(num_gcs=1)

        def add_to_wait_set(self, wait_set: Any) -> None:
            index = ctypes.byref(self._index)
            add_condition(wait_set.pointer, condition, index)

        def is_ready(self, wait_set: Any) -> bool:
            index = self._index.value
            return bool(wait_set.is_ready('guard_condition', index))

        def take_data(self) -> None:
            """Return nothing: a condition has no data."""

        async def execute(self, _: None) -> None:
            changed()

    node.add_waitable(Graph())
    return True


def _nothing(*_: Any) -> None:
    """Do nothing, as a callback."""


def main(needed: list[str]) -> int:
    """Report missing modules, and serve if there are none."""
    if '__file__' in globals():
        # nothing beside it may be taken for a module of the same name
        folder = os.path.dirname(os.path.abspath(__file__))
        sys.path[:] = [p for p in sys.path if os.path.abspath(p) != folder]
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    output = Output()
    requests = Input()
    missing = [name for name in needed if not importlib.util.find_spec(name)]
    output.write(event='found', missing=missing)
    if missing:
        return 0
    try:
        ros = Ros(output, requests)
    except Exception as e:
        output.write(event='trouble', text=f'ROS does not start: {e}')
        raise
    ros.run()
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
