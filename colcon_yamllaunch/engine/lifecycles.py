# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Lifecycle nodes: their states, and the transitions that a launch makes."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.loop import do_nothing, Loop
from colcon_yamllaunch.engine.ros_requests import (
    has_ended,
    RosRequests,
    WaitWarnings,
)
from colcon_yamllaunch.plan.plan import (
    ChangeState,
    Member,
    Plan,
    Process,
    TRANSITIONS,
)

#: Called with None for success, else with the reason of the failure.
Reply = Callable[[str | None], None]

# the next transition from a state to a goal
_STEPS = {
    ('unconfigured', 'active'): 'configure',
    ('unconfigured', 'inactive'): 'configure',
    ('inactive', 'active'): 'activate',
}
_GONE = 'it is not in the launch any more'
_SUPERSEDED = 'somebody asked for something else'
# the state during a transition, and that after its success
_REACHED = {
    ('configuring', 'inactive'),
    ('activating', 'active'),
    ('deactivating', 'inactive'),
    ('cleaningup', 'unconfigured'),
    ('shuttingdown', 'finalized'),
}


@dataclass(slots=True)
class LifecycleTask:
    """
    A lifecycle node of the plan, and its state.

    :param member: Its process or component
    :param node: Its full name, None where it is not known yet
    :param state: The label of its state, such as `active`; None while it
      does not run or its state is unknown
    :param goal: The state that it is to reach when it starts: that of the
      launch file, or the state that it had before it was respawned
    :param is_running: Whether its process runs, or it is loaded
    :param is_stopping: Whether its process was asked to stop
    :param is_goal_reset: Whether its next start has the goal of the launch
      file
    :param is_driven: Whether it is on the way to its goal
    :param request: The number of the transition that is under way
    :param requested: The transition that a user requested, and how to reply;
      without a number, it waits for a client
    """

    member: Member
    node: str | None
    goal: str | None = None
    state: str | None = None
    is_running: bool = False
    is_stopping: bool = False
    is_goal_reset: bool = False
    is_driven: bool = False
    request: int | None = None
    requested: tuple[str, Reply] | None = None

    @property
    def label(self) -> str:
        """The label of its process or component."""
        return self.member.label

    @property
    def is_reachable(self) -> bool:
        """Whether transitions can be requested."""
        return self.is_running and self.node is not None


@dataclass(slots=True)
class _Planned:
    """
    The transitions of the plan for a node.

    :param entries: The first one was requested, or waits for the node
    :param request: Its number, if it was requested
    """

    entries: deque[ChangeState]
    request: int | None = None


class Lifecycles:
    """
    The lifecycle nodes of a launch.

    A node reaches its goal step by step, each from the state that it has then,
    so the death of a client does not matter.
    """

    def __init__(
        self,
        requests: RosRequests,
        emit: events.Listener,
        loop: Loop,
    ) -> None:
        self._requests = requests
        self._emit = emit
        # by the full names of the nodes
        self._planned: dict[str, _Planned] = {}
        self._by_label: dict[str, LifecycleTask] = {}
        self._warnings = WaitWarnings(loop)
        self._has_processes = False

    @property
    def tasks(self) -> list[LifecycleTask]:
        """The nodes, those of processes first, in the order of the plan."""
        return list(self._by_label.values())

    def extend(self, more: Plan) -> None:
        """Add processes and components to the plan."""
        self._has_processes |= any(True for _ in more.processes())
        for member in more.members():
            if member.is_lifecycle:
                self._by_label[member.label] = LifecycleTask(
                    member, member.node_name, _first_goal(member)
                )

    def drop(self, label: str) -> None:
        """Forget a node, if it is one; it does not run."""
        task = self._by_label.pop(label, None)
        if task is not None:
            self._drop(task, _GONE)
            self._warnings.cancel(label)

    def of_label(self, label: str) -> LifecycleTask | None:
        """Return the lifecycle node of a process or component, if any."""
        return self._by_label.get(label)

    @property
    def is_busy(self) -> bool:
        """
        Whether a node still has to reach its goal.

        A node elsewhere may take a while to appear, or any time if nothing was
        started.
        """
        return any(t.is_driven and t.is_running for t in self.tasks) or any(
            not self._has_processes or self._warnings.is_short(node)
            for node in self._planned
            if self._of_node(node) is None
        )

    def process_started(self, process: Process) -> None:
        """Follow the node of a process to its goal."""
        task = self._by_label.get(process.label)
        if task is not None:
            self.up(task, task.node)

    def process_ended(
        self, process: Process, ending: str, *, excused: bool
    ) -> None:
        """
        Handle the end of a process.

        :param excused: Whether its end is no failure to reach the goal
        """
        task = self._by_label.get(process.label)
        if task is None:
            return
        missed = task.is_driven and task.is_running and not excused
        transition = _next_step(task)
        self.down(task)
        if missed:
            self._fail(task, transition, f'it {ending}')

    def up(self, task: LifecycleTask, node: str | None) -> None:
        """Follow a node that runs now to its goal."""
        task.node = node
        task.state = None
        task.is_running = True
        task.is_stopping = False
        # a node that was shut down comes back by a new start only
        if task.is_goal_reset or task.goal == 'finalized':
            task.goal = _first_goal(task.member)
        task.is_goal_reset = False
        task.is_driven = task.goal in ('inactive', 'active')
        task.request = None
        self._warnings.begin(task.label)
        if self._requests.given_up is not None:
            self._fail_for_good(task, self._requests.given_up)
        elif self._requests.is_ready:
            self._follow(task)
        if node is not None:
            self._request_planned(node)

    def down(self, task: LifecycleTask) -> None:
        """Handle that a node does not run any more."""
        if task.is_running and task.node is not None:
            self._requests.gone(node=task.node)
            self._forget_planned(task.node)
        task.is_running = task.is_driven = False
        task.state = None
        self._drop(task, 'it ended')
        self._warnings.cancel(task.label)

    def stop_requested(self, label: str) -> None:
        """
        Handle that a user asked to stop or restart the process of a node.

        Its states from now on lead to its end, and are not restored.
        """
        task = self._by_label.get(label)
        if task is not None:
            task.is_stopping = task.is_running

    def reset_goal(self, label: str) -> None:
        """Start a node with the goal of the launch file next time."""
        task = self._by_label.get(label)
        if task is not None:
            task.is_goal_reset = True

    def changed(self, node: str, state: str, before: str | None) -> None:
        """Handle a new state of a node."""
        for task in self.tasks:
            if task.node == node and task.is_running:
                self._changed(task, node, state, before)

    def change_state(self, name: str, transition: str, reply: Reply) -> None:
        """Request a transition; see `Composition.change_state`."""
        task = self._named(name)
        if transition not in TRANSITIONS:
            raise RefusedError(f"there is no transition '{transition}'")
        if self._requests.given_up is not None:
            raise RefusedError(self._requests.given_up)
        if self._requests.is_ready and not task.is_reachable:
            raise RefusedError(f'{task.label} does not run')
        self._drop(task, _SUPERSEDED)
        task.requested = transition, reply
        # else a client comes soon, and the node may run by then
        if self._requests.is_ready:
            self._request(task)

    def change_as_planned(self, entry: ChangeState) -> None:
        """
        Make a transition of the plan, after those before it.

        The node may not be in the launch.
        """
        if entry.transition not in TRANSITIONS:
            task = self._of_node(entry.node)
            self._report_failure(entry, task, 'there is no such transition')
            return
        if entry.node in self._planned:
            self._planned[entry.node].entries.append(entry)
        else:
            self._planned[entry.node] = _Planned(deque([entry]))
            self._warnings.begin(entry.node)
            self._request_planned(entry.node)

    def client_is_ready(self) -> None:
        """Follow the nodes that run."""
        for task in self.tasks:
            if task.is_running:
                self._follow(task)
        for node in tuple(self._planned):
            self._request_planned(node)
        for task in self.tasks:
            if not task.is_reachable:
                self._drop(task, f'{task.label} does not run')
            elif task.requested is not None:
                self._request(task)

    def client_died(self) -> None:
        """Note that requests have been lost."""
        for planned in self._planned.values():
            planned.request = None
        for task in self.tasks:
            if task.request is not None:
                self._drop(task, 'the ROS client ended, and starts again')

    def client_given_up(self, reason: str) -> None:
        """Give up because the client is lost."""
        for planned in self._planned.values():
            planned.request = None
        for task in self.tasks:
            self._drop(task, reason)
            self._fail_for_good(task, reason)
        for node in tuple(self._planned):
            self._request_planned(node)

    def end_turn(self) -> None:
        """Warn of nodes that do not reach their goal."""
        for task in self.tasks:
            if not (task.is_driven and task.is_running):
                self._warnings.cancel(task.label)
            elif self._warnings.is_due(task.label):
                reason = 'it does not offer the services of a lifecycle node'
                if task.state is not None:
                    reason = f'it is {task.state}'
                self._emit(
                    events.Warned(
                        f'{task.label}: waiting for {task.node} to become '
                        f'{task.goal}; {reason}'
                    )
                )
        for node, planned in self._planned.items():
            is_elsewhere = self._of_node(node) is None
            if is_elsewhere and self._warnings.is_due(node):
                transition = planned.entries[0].transition
                self._emit(
                    events.Warned(
                        f'waiting for {node}, to {transition} it; nothing in '
                        'this launch provides it'
                    )
                )

    def _of_node(self, node: str) -> LifecycleTask | None:
        return next((t for t in self.tasks if t.node == node), None)

    def _named(self, name: str) -> LifecycleTask:
        for task in self.tasks:
            if name in (task.label, task.node):
                return task
        raise RefusedError(f"there is no lifecycle node '{name}'")

    def _request(self, task: LifecycleTask) -> None:
        """Request the transition that a user requested."""
        assert task.requested is not None
        # from now on, the user decides on its states
        task.is_driven = False
        self._ask(task, task.requested[0])

    def _request_planned(self, node: str) -> None:
        """Request the next transition of the plan for a node."""
        planned = self._planned.get(node)
        if planned is None or planned.request is not None:
            return
        task = self._of_node(node)
        entry = planned.entries[0]
        if self._requests.given_up is not None:
            self._forget_planned(node)
            self._report_failure(entry, task, self._requests.given_up)
            return
        if not self._requests.is_ready or not (
            task is None or task.is_running
        ):
            return
        if task is not None:
            # the plan decides on its next states
            self._drop(task, _SUPERSEDED)
            task.is_driven = False
            if task.state == TRANSITIONS[entry.transition].goal:
                self._planned_made(node)
                return

        def answered(_: object, refusal: str | None) -> None:
            planned.request = None
            if refusal is None:
                if task is not None:
                    goal = TRANSITIONS[entry.transition].goal
                    self._reach(task, goal, is_requested=True)
                self._planned_made(node)
                return
            self._forget_planned(node)
            if not has_ended(refusal):
                self._report_failure(entry, task, refusal)

        planned.request = self._requests.ask(
            'change_state', answered, node=node, transition=entry.transition
        )

    def _reach(
        self, task: LifecycleTask, state: str, *, is_requested: bool
    ) -> None:
        """
        Handle the success of a transition.

        :param is_requested: Whether a user requested it, not the launch
        """
        task.state = state
        if is_requested:
            task.goal = state
        self._emit(events.MemberChanged(task.member, lifecycle=state))

    def _planned_made(self, node: str) -> None:
        """Go on after a transition of the plan."""
        planned = self._planned[node]
        planned.entries.popleft()
        if planned.entries:
            self._warnings.begin(node)
            self._request_planned(node)
        else:
            self._forget_planned(node)

    def _forget_planned(self, node: str) -> None:
        """Forget the transitions of the plan for a node."""
        self._warnings.cancel(node)
        planned = self._planned.pop(node, None)
        if planned is not None:
            self._requests.cancel(planned.request)

    def _report_failure(
        self, entry: ChangeState, task: LifecycleTask | None, reason: str
    ) -> None:
        if task is not None:
            self._fail(task, entry.transition, reason)
            return
        place = events.shown(entry.position)
        self._emit(
            events.Warned(
                f"the transition '{entry.transition}' of {entry.node} "
                f'failed: {reason} (from {place})'
            )
        )

    def _follow(self, task: LifecycleTask) -> None:
        if task.node is not None:
            self._requests.ask('follow', do_nothing, node=task.node)

    def _changed(
        self,
        task: LifecycleTask,
        node: str,
        state: str,
        before: str | None,
    ) -> None:
        if before is None and state == task.state:
            # it is no news
            self._drive(task)
            return
        task.state = state
        is_requested = not (task.is_driven or task.is_stopping)
        if (before, state) in _REACHED and is_requested:
            # another program changed the state
            task.goal = state
        self._emit(events.StateChanged(task.member, node, state, before))
        self._drive(task)

    def _drive(self, task: LifecycleTask) -> None:
        """Request the next step to the goal, unless one is open."""
        if not task.is_driven or task.request is not None:
            return
        if task.state == task.goal:
            task.is_driven = False
            return
        step = _STEPS.get((task.state or '', task.goal or ''))
        if step is not None:
            self._warnings.begin(task.label)
            self._ask(task, step)

    def _ask(self, task: LifecycleTask, transition: str) -> None:
        def answered(_: object, refusal: str | None) -> None:
            task.request = None
            self._answered(task, transition, refusal)

        task.request = self._requests.ask(
            'change_state', answered, node=task.node, transition=transition
        )

    def _answered(
        self, task: LifecycleTask, transition: str, refusal: str | None
    ) -> None:
        requested, task.requested = task.requested, None
        if refusal is None:
            # the event may come later
            goal = TRANSITIONS[transition].goal
            self._reach(task, goal, is_requested=requested is not None)
            self._drive(task)
            if requested is not None:
                requested[1](None)
            return
        if requested is not None:
            requested[1](refusal)
        elif not has_ended(refusal):
            # else the end of its process is the failure
            task.is_driven = False
            self._fail(task, transition, refusal)

    def _drop(self, task: LifecycleTask, reason: str) -> None:
        """Cancel the open transition, if there is one."""
        self._requests.cancel(task.request)
        task.request = None
        requested, task.requested = task.requested, None
        if requested is not None:
            requested[1](reason)

    def _fail(self, task: LifecycleTask, transition: str, reason: str) -> None:
        self._emit(
            events.TransitionFailed(
                task.member, task.node or task.label, transition, reason
            )
        )

    def _fail_for_good(self, task: LifecycleTask, reason: str) -> None:
        if task.is_driven and task.is_running:
            self._fail(task, _next_step(task), reason)
        task.is_driven = False


def _first_goal(member: Member) -> str | None:
    """Return the goal of a node in the launch file."""
    return 'active' if member.autostart else None


def _next_step(task: LifecycleTask) -> str:
    """Return the transition that a node on the way to its goal needs."""
    state = task.state or 'unconfigured'
    return _STEPS.get((state, task.goal or ''), 'configure')
