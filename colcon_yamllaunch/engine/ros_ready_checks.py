# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The checks of readiness conditions that the ROS client makes.

Only launches with such conditions import this. `ros_conditions` says what the
client is asked for.
"""

from collections.abc import Callable, Mapping
import json
from typing import Any

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.ready_checks import LifecycleCheck, ReadyCheck
from colcon_yamllaunch.engine.ros_requests import RosRequests, StandingRequest
from colcon_yamllaunch.plan.member_settings import ReadyCondition
from colcon_yamllaunch.plan.plan import Member, Process
from colcon_yamllaunch.plan.ros_names import names_of, NodeNames


class RosCheck(ReadyCheck):
    """Checks a condition of the ROS graph, through the ROS client."""

    _request: StandingRequest | None = None

    def begin(self) -> None:
        """Ask the client to wait for it."""
        self._request = self._requests.ask_any_client(
            'await', self._answered, **self._fields()
        )

    def cancel(self) -> None:
        """End the check."""
        super().cancel()
        if self._request is not None:
            self._requests.withdraw(self._request)

    def explain(self, explained: Callable[[str], object]) -> None:
        """Ask the client what exists instead."""
        if not self._requests.is_ready:
            super().explain(explained)
            return

        def answered(answer: Mapping[str, Any], refusal: str | None) -> None:
            explained(str(answer.get('found') or refusal or ''))

        self._requests.ask('explain', answered, **self._fields())

    @property
    def _requests(self) -> RosRequests:
        composition = self._engine.composition
        assert composition is not None
        return composition.requests

    @property
    def _names(self) -> NodeNames:
        label = self._member.label
        # the container says which name a component has
        loaded = self._engine.state.by_label[label].node
        is_process = isinstance(self._member, Process)
        return names_of(self._member, None if is_process else loaded)

    def _fields(self) -> dict[str, Any]:
        condition, names = self.condition, self._names
        name: str = condition.name
        value: Any = condition.value
        match condition.kind:
            case 'topic':
                name = names.topic(name)
            case 'service':
                name = names.service(name)
            case 'action':
                name = names.action(name)
            case 'node':
                name = names.expanded(name)
            case 'parameter':
                value = json.loads(value)
            case 'transform':
                # tf2 ignores the slash, too
                name, value = name.lstrip('/'), value.lstrip('/')
            case _:
                pass
        return {
            'member': self._member.label,
            'kind': condition.kind,
            'name': name,
            'value': value,
            'message': condition.message,
            'node': names.node,
            'namespace': names.namespace,
        }

    def _answered(self, _: object, refusal: str | None) -> None:
        self._request = None
        if refusal is None:
            self._succeed()
            return
        text = f'{self._member.label}: cannot wait for {self.condition}'
        self._engine.emit(events.Warned(f'{text}: {refusal}'))


def check_of(member: Member, condition: ReadyCondition) -> type[ReadyCheck]:
    """Return the check of a condition, which is one of `ROS_KINDS`."""
    if condition.kind == 'lifecycle' and member.is_lifecycle:
        # its states are followed all the same
        return LifecycleCheck
    return RosCheck


def node_condition(member: Member) -> ReadyCondition:
    """Return the condition that the node of a member is in the graph."""
    return ReadyCondition('node', names_of(member).node)
