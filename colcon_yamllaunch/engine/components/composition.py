# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The course of components, lifecycle nodes and ROS time in a launch.

Nothing here touches the system: requests go to a client program that speaks
with ROS (see `ros_client`), what it says is passed in, and so is a loop. So
the course of any launch can be replayed without a process.
"""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Mapping
from typing import Any

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.components.client_requests import Requests
from colcon_yamllaunch.engine.components.component_task import ComponentTask
from colcon_yamllaunch.engine.components.containers import Containers
from colcon_yamllaunch.engine.components.lifecycle_task import LifecycleTask
from colcon_yamllaunch.engine.components.lifecycles import Lifecycles
from colcon_yamllaunch.engine.components.lifecycles import Reply
from colcon_yamllaunch.engine.components.ros_timers import RosTimers
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.loop import TimerHandle
from colcon_yamllaunch.engine.tasks import RefusedError
from colcon_yamllaunch.plan.plan import ChangeState
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process


class Composition:
    """
    Has components loaded, lifecycle nodes activated and ROS time told.

    :param send: Hands a request to the client, one JSON object
    :param tell: Is told what happens
    """

    def __init__(
        self,
        plan: Plan,
        send: Callable[[Mapping[str, Any]], None],
        tell: events.Listener,
        loop: Loop,
    ) -> None:
        self._tell = tell
        self._requests = Requests(send)
        self._lifecycles = Lifecycles(plan, self._requests, tell, loop)
        self._containers = Containers(
            plan, self._requests, self._lifecycles, tell, loop
        )
        self._timers = RosTimers(self._requests, tell, loop)
        #: Whether the launch is being stopped, and so nothing more is done.
        self.is_stopping = False

    @property
    def tasks(self) -> list[ComponentTask]:
        """The components, in the order of the plan."""
        return self._containers.tasks

    @property
    def lifecycle_tasks(self) -> list[LifecycleTask]:
        """The lifecycle nodes, processes first, in the order of the plan."""
        return self._lifecycles.tasks

    def task(self, label: str) -> ComponentTask:
        """
        Return a component of the plan.

        :raises RefusedError: when there is none with this label
        """
        return self._containers.task(label)

    def is_lifecycle(self, label: str) -> bool:
        """Tell whether a process or component is a lifecycle node."""
        return self._lifecycles.of_label(label) is not None

    def state(self, label: str) -> str | None:
        """Return the lifecycle state of a process or component, if any."""
        task = self._lifecycles.of_label(label)
        return None if task is None else task.state

    def container_process(self, task: ComponentTask) -> Process | None:
        """Return the process of the plan that a component is loaded into."""
        return self._containers.provider(task.component.container)

    def seconds(self, task: ComponentTask) -> float:
        """Return for how long a component has been in its phase."""
        return self._containers.seconds(task)

    # what is changed of the plan

    def extend(self, more: Plan) -> None:
        """Take more processes and components into the plan."""
        self._lifecycles.extend(more)
        self._containers.extend(more)

    def replace_process(self, before: Process, process: Process) -> None:
        """Have a process be another one, while it does not run."""
        self._lifecycles.drop(before.label)
        self._containers.drop_process(before)
        self.extend(Plan((process,)))

    def drop_process(self, process: Process) -> None:
        """Have a process no more in the plan, which does not run."""
        self._lifecycles.drop(process.label)
        self._containers.drop_process(process)

    def replace(self, component: Component) -> None:
        """
        Have a component be another one, and load it anew if it was loaded.

        :param component: It has the label of a component of the plan
        :raises RefusedError: when there is none, or all is being stopped
        """
        self._refuse_while_stopping()
        self._containers.replace(component)

    def revise(self, component: Component) -> None:
        """Have a component be another one when it is loaded next."""
        self._containers.revise(component)

    def reload_changed(
        self, labels: Collection[str], processes: Collection[str]
    ) -> tuple[str, ...]:
        """
        Load components anew after a change, and return their labels.

        Lifecycle nodes get their states back. What was unloaded on request is
        left alone.

        :param processes: The labels of processes that are started anew, which
          brings their components
        """
        if self.is_stopping:
            return ()
        return self._containers.reload_changed(labels, processes)

    def ended_containers(self, labels: Collection[str]) -> set[str]:
        """
        Return the labels of containers of components that have ended.

        As with what a component crashed by values that were changed since.
        """
        return self._containers.ended_containers(labels)

    def drop(self, label: str) -> None:
        """
        Unload a component, and forget it then.

        :raises RefusedError: when there is none, or all is being stopped
        """
        self._refuse_while_stopping()
        self._containers.drop(label)

    # what clients of the launch ask for

    def unload(self, label: str) -> None:
        """
        Unload one component, and keep it unloaded.

        It is not loaded again with its container either, until
        :meth:`reload`. The end is told as an event.

        :raises RefusedError: when there is nothing to unload
        """
        self._refuse_while_stopping()
        self._containers.unload(label)

    def reload(self, label: str) -> None:
        """
        Unload one component if it is loaded, then load it anew.

        The end is told as an event.

        :raises RefusedError: when it cannot be loaded now
        """
        self._refuse_while_stopping()
        self._containers.reload(label)

    def change_state(self, name: str, transition: str, reply: Reply) -> None:
        """
        Have a lifecycle node make a transition.

        :param name: The label of its process or component, or its full name
        :param transition: One of :data:`.transitions.TRANSITIONS`
        :param reply: Is called once, with None when it is made, or else with
          the reason why it is not
        :raises RefusedError: when it cannot be asked for now
        """
        self._refuse_while_stopping()
        self._lifecycles.change_state(name, transition, reply)

    # what the supervisor tells

    def due(self, component: Component) -> None:
        """Load a component, whose turn has come."""
        self._containers.due(component)

    def change_as_planned(self, entry: ChangeState) -> None:
        """Have a lifecycle node make a transition that the plan has."""
        if not self.is_stopping:
            self._lifecycles.change_as_planned(entry)

    def at_ros_time(
        self, seconds: float, action: Callable[[], None]
    ) -> TimerHandle:
        """Have something done once the topic `/clock` has told so much."""
        return self._timers.add(seconds, action)

    def started(self, process: Process) -> None:
        """Take into account that a process of the plan runs."""
        self._containers.started(process)
        self._lifecycles.process_started(process)

    def leaves(self, process: Process, *, is_anew: bool) -> None:
        """
        Take into account that somebody asks a process to end.

        :param is_anew: Whether it is then started again. If its node is a
          lifecycle node, that begins as the launch file says; components get
          the states back that they have.
        """
        self._containers.leaves(process)
        self._lifecycles.leaves(process.label)
        if is_anew:
            self._lifecycles.begins_anew(process.label)

    def ended(
        self,
        process: Process,
        ending: str,
        *,
        asked: bool,
        failed: bool,
        again: bool,
    ) -> None:
        """
        Take into account that a process ended, or could not be started.

        :param ending: How, as a part of a sentence
        :param asked: Whether it had been asked to stop
        :param failed: Whether its end is a failure of its own
        :param again: Whether it will be started again
        """
        if self.is_stopping:
            return
        # its components stand for their own states
        self._containers.ended(process, ending, asked=asked, again=again)
        excused = asked or failed or again
        self._lifecycles.process_ended(process, ending, excused=excused)

    @property
    def is_busy(self) -> bool:
        """Whether something is waited for that a launch does not end before.

        That is asked when no process runs.
        """
        return not self.is_stopping and (
            self._containers.is_busy or self._lifecycles.is_busy
        )

    def end(self) -> None:
        """Give up what is still to be loaded, as nothing runs any more."""
        self._containers.give_up()

    def stop(self) -> None:
        """Do nothing more, as the launch is being stopped."""
        self.is_stopping = True
        self._requests.reset()
        self._timers.cancel()

    def end_turn(self) -> None:
        """Do what follows from all that happened in a turn of the loop."""
        if not self.is_stopping:
            self._containers.end_turn()
            self._lifecycles.end_turn()
            self._timers.end_turn()

    # what the client says

    def take(self, message: Mapping[str, Any]) -> None:
        """Take one message of the client into account."""
        if self.is_stopping:
            return
        match message:
            case {'id': int()}:
                self._requests.take(message)
            case {'event': 'ready'}:
                self._requests.is_ready = True
                self._containers.client_is_ready()
                self._lifecycles.client_is_ready()
                self._timers.client_is_ready()
            case {'event': 'container', 'container': str(name)}:
                self._containers.seen(
                    name, is_there=bool(message.get('there'))
                )
            case {'event': 'state', 'node': str(node), 'state': str(state)}:
                before = message.get('from') or None
                self._lifecycles.changed(node, state, before)
            case {'event': 'clock', 'seconds': int() | float() as seconds}:
                self._timers.clock(seconds)
            case {'event': 'trouble', 'text': str(text)}:
                self._tell(events.Warned(text))
            case _:
                # of a newer client, or no business of ours
                return

    def client_died(self) -> None:
        """Take into account that the client died; another one follows."""
        self._requests.reset()
        if not self.is_stopping:
            self._containers.client_died()
            self._lifecycles.client_died()
            self._timers.client_died()

    def client_given_up(self, reason: str) -> None:
        """
        Take into account that there will be no client any more.

        :param reason: Why, as a sentence without its end
        """
        self._requests.reset()
        if not self.is_stopping:
            self._tell(events.RosLost(reason))
            self._containers.client_given_up(reason)
            self._lifecycles.client_given_up(reason)
            self._timers.cancel()

    def _refuse_while_stopping(self) -> None:
        if self.is_stopping:
            raise RefusedError('the whole launch is being stopped')
