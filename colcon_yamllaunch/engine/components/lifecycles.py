# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The course of lifecycle nodes: their states, and what activates them."""

from collections import deque
from collections.abc import Callable
from collections.abc import Mapping
from typing import Any

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.components.client_requests import has_ended
from colcon_yamllaunch.engine.components.client_requests import Requests
from colcon_yamllaunch.engine.components.lifecycle_task import LifecycleTask
from colcon_yamllaunch.engine.components.patience import Patience
from colcon_yamllaunch.engine.components.transitions import TRANSITIONS
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.tasks import RefusedError
from colcon_yamllaunch.plan.plan import ChangeState
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process

#: Is called with None for success, else with the reason of the failure.
Reply = Callable[[str | None], None]

# what leads from a state to a goal
_STEPS = {
    ('unconfigured', 'active'): 'configure',
    ('unconfigured', 'inactive'): 'configure',
    ('inactive', 'active'): 'activate',
}
_GONE = 'it is no part of the launch any more'
_OTHER_WISH = 'somebody asked for something else'
# the states that a transition passes through, and where it ends well
_REACHED = {
    ('configuring', 'inactive'),
    ('activating', 'active'),
    ('deactivating', 'inactive'),
    ('cleaningup', 'unconfigured'),
    ('shuttingdown', 'finalized'),
}


class Lifecycles:
    """
    The lifecycle nodes of a launch.

    One that is to be activated is brought there step by step, by the state
    that it has, so it does not matter where it was when a client died.
    """

    def __init__(
        self,
        plan: Plan,
        requests: Requests,
        tell: events.Listener,
        loop: Loop,
    ) -> None:
        self._requests = requests
        self._tell = tell
        self._loop = loop
        self._given_up: str | None = None
        self._replies: dict[int, Reply] = {}
        # what waits for a client, by the labels of the nodes
        self._wishes: dict[str, tuple[str, Reply]] = {}
        # the transitions that the plan has, by the full names of the nodes;
        # the first one of each is under way, or waits for the node
        self._planned: dict[str, deque[ChangeState]] = {}
        self._planned_since: dict[str, float] = {}
        self._planned_requests: dict[str, int] = {}
        self._by_label: dict[str, LifecycleTask] = {}
        self._patience = Patience(loop)
        self._has_processes = False
        self.extend(plan)

    @property
    def tasks(self) -> list[LifecycleTask]:
        """The nodes, those of processes first, in the order of the plan."""
        return list(self._by_label.values())

    def extend(self, more: Plan) -> None:
        """Take more into the plan."""
        self._has_processes |= any(True for _ in more.processes())
        owners: list[Process | Component] = [
            *more.processes(),
            *more.components(),
        ]
        for owner in owners:
            if owner.is_lifecycle:
                self._by_label[owner.label] = LifecycleTask(
                    owner, owner.node_name, _first_goal(owner)
                )

    def drop(self, label: str) -> None:
        """Forget a node, if it is one; it does not run."""
        task = self._by_label.pop(label, None)
        if task is not None:
            self._drop(task, _GONE)
            self._patience.forget(label)

    def of_label(self, label: str) -> LifecycleTask | None:
        """Return the lifecycle node of a process or component, if it is."""
        return self._by_label.get(label)

    @property
    def is_busy(self) -> bool:
        """
        Whether a node is on its way to its goal, or to be on its way.

        One that is elsewhere gets a while to come, or ever so long if
        nothing was started.
        """
        now = self._loop.time()
        return any(t.is_driven and t.is_running for t in self.tasks) or any(
            not self._has_processes or now < since + limits.PATIENCE
            for node, since in self._planned_since.items()
            if self._of_node(node) is None
        )

    def process_started(self, process: Process) -> None:
        """Follow the node of a process, and bring it to its goal."""
        task = self._by_label.get(process.label)
        if task is not None:
            self.up(task, task.node)

    def process_ended(
        self, process: Process, ending: str, *, excused: bool
    ) -> None:
        """
        Take the end of a process into account.

        :param excused: Whether its end is no failure to reach the goal
        """
        task = self._by_label.get(process.label)
        if task is None:
            return
        missed = task.is_driven and task.is_running and not excused
        transition = _STEPS.get(
            (task.state or 'unconfigured', task.goal or '')
        )
        self.down(task)
        if missed:
            self._fail(task, transition or 'configure', f'it {ending}')

    def up(self, task: LifecycleTask, node: str | None) -> None:
        """Follow a node that runs now, and bring it to its goal."""
        task.node = node
        task.state = None
        task.is_running = True
        task.is_leaving = False
        # who was shut down comes back by a new start only
        if task.is_anew or task.goal == 'finalized':
            task.goal = _first_goal(task.owner)
        task.is_anew = False
        task.is_driven = task.goal in ('inactive', 'active')
        task.request = None
        task.since = self._loop.time()
        if self._given_up is not None:
            self._fail_for_good(task, self._given_up)
        elif self._requests.is_ready:
            self._follow(task)
        if node is not None:
            self._go_on(node)

    def down(self, task: LifecycleTask) -> None:
        """Take into account that a node does not run any more."""
        if task.is_running and task.node is not None:
            self._requests.gone(node=task.node)
            self._give_up(task.node)
        task.is_running = task.is_driven = False
        task.state = None
        self._drop(task, 'it ended')
        self._patience.forget(task.label)

    def leaves(self, label: str) -> None:
        """
        Take into account that the process of a node is asked to end.

        The states that it passes through now are on the way to its end, so
        nobody wants them to be restored.
        """
        task = self._by_label.get(label)
        if task is not None:
            task.is_leaving = task.is_running

    def begins_anew(self, label: str) -> None:
        """Have a node start with the goal of the launch file next time."""
        task = self._by_label.get(label)
        if task is not None:
            task.is_anew = True

    def changed(self, node: str, state: str, before: str | None) -> None:
        """Take into account which state a node has, and had before."""
        for task in self.tasks:
            if task.node == node and task.is_running:
                self._changed(task, node, state, before)

    def change_state(self, name: str, transition: str, reply: Reply) -> None:
        """Have a node make a transition; see `Composition.change_state`."""
        task = self._named(name)
        if transition not in TRANSITIONS:
            raise RefusedError(f"there is no transition '{transition}'")
        if self._given_up is not None:
            raise RefusedError(self._given_up)
        if self._requests.is_ready:
            self._wish(task, transition, reply)
        else:
            # it comes soon, and what is not started yet may run then
            self._drop(task, _OTHER_WISH)
            self._wishes[task.label] = transition, reply

    def change_as_planned(self, entry: ChangeState) -> None:
        """
        Have a node make a transition, after those that it had before.

        It may be one that is no part of the launch.
        """
        if entry.transition not in TRANSITIONS:
            task = self._of_node(entry.node)
            self._tell_of_failure(entry, task, 'there is no such transition')
            return
        waiting = self._planned.setdefault(entry.node, deque())
        waiting.append(entry)
        if len(waiting) == 1:
            self._planned_since[entry.node] = self._loop.time()
            self._go_on(entry.node)

    def client_is_ready(self) -> None:
        """Follow the nodes that run."""
        for task in self.tasks:
            if task.is_running:
                self._follow(task)
        for node in tuple(self._planned):
            self._go_on(node)
        wishes, self._wishes = self._wishes, {}
        for label, (transition, reply) in wishes.items():
            try:
                self._wish(self._by_label[label], transition, reply)
            except RefusedError as error:
                reply(str(error))

    def client_died(self) -> None:
        """Take into account that requests have been lost."""
        self._planned_requests.clear()
        for task in self.tasks:
            if task.label not in self._wishes:
                self._drop(task, 'the ROS client ended, and starts again')

    def client_given_up(self, reason: str) -> None:
        """Give up with the client."""
        self._given_up = reason
        self._planned_requests.clear()
        for task in self.tasks:
            self._drop(task, reason)
            self._fail_for_good(task, reason)
        for node in tuple(self._planned):
            self._go_on(node)

    def end_turn(self) -> None:
        """Say of which nodes nothing comes."""
        for task in self.tasks:
            if not (task.is_driven and task.is_running):
                self._patience.forget(task.label)
            elif self._patience.is_over(task.label, task.since):
                text = (
                    f'{task.label}: waiting for {task.node} to become '
                    f'{task.goal}'
                )
                if task.state is None:
                    text += (
                        '; it does not offer the services of a lifecycle node'
                    )
                else:
                    text += f'; it is {task.state}'
                self._tell(events.Warned(text))
        for node, since in self._planned_since.items():
            is_elsewhere = self._of_node(node) is None
            if is_elsewhere and self._patience.is_over(node, since):
                transition = self._planned[node][0].transition
                self._tell(
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

    def _wish(
        self, task: LifecycleTask, transition: str, reply: Reply
    ) -> None:
        """
        Have a node make a transition that a user asked for.

        :raises RefusedError: when it does not run
        """
        if not task.is_running or task.node is None:
            raise RefusedError(f'{task.label} does not run')
        self._drop(task, _OTHER_WISH)
        # who decides on the states from now on is the user
        task.is_driven = False
        self._ask(task, transition, reply)

    def _go_on(self, node: str) -> None:
        """Ask for the next transition of a node that the plan has."""
        waiting = self._planned.get(node)
        if not waiting or node in self._planned_requests:
            return
        task = self._of_node(node)
        entry = waiting[0]
        if self._given_up is not None:
            self._give_up(node)
            self._tell_of_failure(entry, task, self._given_up)
            return
        if not self._requests.is_ready or not (
            task is None or task.is_running
        ):
            return
        if task is not None:
            # the plan says itself what comes next
            self._drop(task, _OTHER_WISH)
            task.is_driven = False
            if task.state == TRANSITIONS[entry.transition].goal:
                self._made(node)
                return

        def answered(answer: Mapping[str, Any]) -> None:
            del self._planned_requests[node]
            if answer.get('ok'):
                if task is not None:
                    goal = TRANSITIONS[entry.transition].goal
                    self._reach(task, goal, is_wish=True)
                self._made(node)
                return
            self._give_up(node)
            if not has_ended(answer):
                reason = str(answer.get('reason') or 'it was refused')
                self._tell_of_failure(entry, task, reason)

        self._planned_requests[node] = self._requests.ask(
            'change_state', answered, node=node, transition=entry.transition
        )

    def _reach(
        self, task: LifecycleTask, state: str, *, is_wish: bool
    ) -> None:
        """
        Take into account that a transition succeeded.

        :param is_wish: Whether the user asked for it, rather than the launch
        """
        task.state = state
        if is_wish:
            task.goal = state
        self._tell(events.PartChanged(task.owner, lifecycle=state))

    def _made(self, node: str) -> None:
        """Go on after a transition that the plan has."""
        waiting = self._planned[node]
        waiting.popleft()
        if waiting:
            self._planned_since[node] = self._loop.time()
            self._go_on(node)
        else:
            self._give_up(node)

    def _give_up(self, node: str) -> None:
        """Forget the transitions of a node that the plan has."""
        self._planned.pop(node, None)
        self._planned_since.pop(node, None)
        self._patience.forget(node)
        self._requests.cancel(self._planned_requests.pop(node, None))

    def _tell_of_failure(
        self, entry: ChangeState, task: LifecycleTask | None, reason: str
    ) -> None:
        if task is not None:
            self._fail(task, entry.transition, reason)
            return
        place = events.shown(entry.position)
        self._tell(
            events.Warned(
                f"the transition '{entry.transition}' of {entry.node} "
                f'failed: {reason} (from {place})'
            )
        )

    def _follow(self, task: LifecycleTask) -> None:
        if task.node is not None:
            self._requests.ask('follow', lambda _: None, node=task.node)

    def _changed(
        self,
        task: LifecycleTask,
        node: str,
        state: str,
        before: str | None,
    ) -> None:
        if before is None and state == task.state:
            # it was only looked at once more
            self._drive(task)
            return
        task.state = state
        is_wish = not (task.is_driven or task.is_leaving)
        if (before, state) in _REACHED and is_wish:
            # somebody else decided so
            task.goal = state
        self._tell(events.StateChanged(task.owner, node, state, before))
        self._drive(task)

    def _drive(self, task: LifecycleTask) -> None:
        """Take the next step to the goal, unless one is under way."""
        if not task.is_driven or task.request is not None:
            return
        if task.state == task.goal:
            task.is_driven = False
            return
        step = _STEPS.get((task.state or '', task.goal or ''))
        if step is not None:
            task.since = self._loop.time()
            self._ask(task, step, None)

    def _ask(
        self, task: LifecycleTask, transition: str, reply: Reply | None
    ) -> None:
        def answered(answer: Mapping[str, Any]) -> None:
            task.request = None
            self._replies.pop(number, None)
            self._answered(task, transition, reply, answer)

        number = self._requests.ask(
            'change_state', answered, node=task.node, transition=transition
        )
        task.request = number
        if reply is not None:
            self._replies[number] = reply

    def _answered(
        self,
        task: LifecycleTask,
        transition: str,
        reply: Reply | None,
        answer: Mapping[str, Any],
    ) -> None:
        if answer.get('ok'):
            # the event may come later
            is_wish = reply is not None
            goal = TRANSITIONS[transition].goal
            self._reach(task, goal, is_wish=is_wish)
            self._drive(task)
            if reply is not None:
                reply(None)
            return
        reason = str(answer.get('reason') or 'it was refused')
        if reply is not None:
            reply(reason)
        elif not has_ended(answer):
            # or else its end says more
            task.is_driven = False
            self._fail(task, transition, reason)

    def _drop(self, task: LifecycleTask, reason: str) -> None:
        """Take the transition back that is under way, if one is."""
        number, task.request = task.request, None
        if number is not None:
            self._requests.cancel(number)
            reply = self._replies.pop(number, None)
            if reply is not None:
                reply(reason)
        if task.label in self._wishes:
            _, reply = self._wishes.pop(task.label)
            reply(reason)

    def _fail(self, task: LifecycleTask, transition: str, reason: str) -> None:
        self._tell(
            events.TransitionFailed(
                task.owner, task.node or task.label, transition, reason
            )
        )

    def _fail_for_good(self, task: LifecycleTask, reason: str) -> None:
        if task.is_driven and task.is_running:
            step = _STEPS.get((task.state or 'unconfigured', task.goal or ''))
            self._fail(task, step or 'configure', reason)
        task.is_driven = False


def _first_goal(owner: Process | Component) -> str | None:
    """Return the state that the launch file wants a node to have."""
    return 'active' if owner.autostart else None
