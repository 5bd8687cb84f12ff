# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The components of a launch: which container each is loaded into, and when.

Nothing here touches the system: requests go to a client program that talks to
ROS (see `ros_client`), its messages are passed in, and so is a loop. So tests
replay any launch without a process.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
import json
import re
from typing import Any

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.lifecycles import (
    Lifecycles,
    LifecycleTask,
    Reply,
)
from colcon_yamllaunch.engine.loop import Loop, TimerHandle
from colcon_yamllaunch.engine.ros_requests import (
    has_ended,
    RosRequests,
    RosTimers,
    WaitWarnings,
)
from colcon_yamllaunch.engine.state import ComponentState, LaunchState
from colcon_yamllaunch.plan.plan import (
    ChangeState,
    Component,
    Plan,
    Process,
    SetParameter,
)

# strings, and the numbers for which Python adds words to JSON
_TOKENS = re.compile(r'"(?:[^"\\]|\\.)*"|-?\.inf|\.nan')
_WORDS = {'.inf': 'Infinity', '-.inf': '-Infinity', '.nan': 'NaN'}
_NOT_LOADED = '{} is not loaded'


@dataclass(slots=True)
class ComponentTask:
    """
    What the composition needs of a component besides its `ComponentState`.

    :param launch: The launch, which has that state
    :param lifecycle: Its states, if it is a lifecycle node
    :param unique_id: The number that its container knows it by while it is
      loaded
    :param full_name: The full name of its node, from its container
    :param is_due: Whether its turn has come
    :param is_wanted: Whether it is loaded again with its container; False
      once a user asked to unload it
    :param must_reload: Whether it is loaded again as soon as it is unloaded
    :param request: The number of the load or unload that is under way
    :param was_sent: Whether a client that died had been asked to load it
    :param successor: The component that replaces it when it is loaded next
    """

    component: Component
    launch: LaunchState
    lifecycle: LifecycleTask | None = None
    unique_id: int | None = None
    full_name: str | None = None
    is_due: bool = False
    is_wanted: bool = True
    must_reload: bool = False
    request: int | None = None
    was_sent: bool = False
    successor: Component | None = None

    @property
    def label(self) -> str:
        """Its name in output and logs."""
        return self.component.label

    @property
    def state(self) -> ComponentState:
        """The state of the component; only events change it."""
        state = self.launch.by_label[self.label]
        assert isinstance(state, ComponentState)
        return state

    @property
    def phase(self) -> events.Phase:
        """Its phase."""
        return self.state.phase

    @property
    def is_open(self) -> bool:
        """Whether it is still to be loaded."""
        return (
            self.is_due
            and self.is_wanted
            and self.unique_id is None
            and self.phase in ('waiting', 'loading')
        )


@dataclass(slots=True)
class _Container:
    """
    A container that components of the plan are loaded into.

    :param name: The full name of its node
    :param tasks: Its components, in the order of the plan
    :param providers: The processes of the plan that provide it; usually one,
      and none if it runs elsewhere
    :param phases: The phase of each of those, by its label
    :param ending: How the last of those ended
    :param is_present: Whether its services are there
    :param must_list: Whether its components are unknown, as a client died,
      or it went away and came back
    """

    name: str
    tasks: list[ComponentTask] = field(default_factory=list)
    providers: list[Process] = field(default_factory=list)
    phases: dict[str, events.Phase] = field(default_factory=dict)
    ending: str = ''
    is_present: bool = False
    must_list: bool = False
    listing: int | None = None

    @property
    def is_gone(self) -> bool:
        """Whether its processes have ended for good."""
        phases = self.phases.values()
        return bool(phases) and all(phase == 'ended' for phase in phases)

    @property
    def runs(self) -> bool:
        """Whether a process of this launch provides the container now."""
        return 'running' in self.phases.values()

    def open(self) -> list[ComponentTask]:
        """Return the components that are still to be loaded."""
        return [task for task in self.tasks if task.is_open]


class Composition:
    """
    The components, lifecycle nodes and ROS timers of a launch.

    :param send: Sends a request to the client, one JSON object
    :param emit: Receives events, and applies them to `state`
    """

    def __init__(
        self,
        plan: Plan,
        send: Callable[[Mapping[str, Any]], None],
        emit: events.Listener,
        loop: Loop,
        state: LaunchState,
    ) -> None:
        self._state = state
        self._emit = emit
        self._loop = loop
        self._requests = RosRequests(send)
        self._lifecycles = Lifecycles(self._requests, emit, loop)
        self._timers = RosTimers(self._requests, emit, loop)
        self._warnings = WaitWarnings(loop)
        self._has_processes = False
        self._by_label: dict[str, ComponentTask] = {}
        self._containers: dict[str, _Container] = {}
        # components to forget as soon as they are not loaded any more
        self._dropped: set[str] = set()
        #: Whether the launch is being stopped, and nothing more is done.
        self.is_stopping = False
        self.extend(plan)

    @property
    def tasks(self) -> list[ComponentTask]:
        """The components, in the order of the plan."""
        return list(self._by_label.values())

    @property
    def requests(self) -> RosRequests:
        """The requests to the client."""
        return self._requests

    @property
    def has_client(self) -> bool:
        """Whether the client is ready for requests."""
        return self._requests.is_ready

    def task(self, label: str) -> ComponentTask:
        """
        Return a component of the plan.

        :raises RefusedError: when there is none with this label
        """
        if label not in self._by_label:
            raise RefusedError(f"there is no component '{label}'")
        return self._by_label[label]

    def container_process(self, task: ComponentTask) -> Process | None:
        """Return the process of the plan that a component is loaded into."""
        container = self._containers.get(task.component.container)
        if container is None or not container.providers:
            return None
        return container.providers[0]

    @property
    def is_busy(self) -> bool:
        """
        Whether the launch has to go on, although no process runs.

        A launch without processes waits for containers elsewhere for ever;
        others wait a while, and go on only if the container is there.
        """
        if self.is_stopping:
            return False
        return self._lifecycles.is_busy or any(
            container.is_present
            or not self._has_processes
            or self._warnings.is_short(container.name)
            for container in self._containers.values()
            if container.open()
        )

    # changes of the plan

    def extend(self, more: Plan) -> None:
        """Add processes and components to the plan."""
        self._lifecycles.extend(more)
        # any process may turn out to be a container that something is
        # loaded into later
        for process in more.processes():
            if process.node_name is not None:
                container = self._named(process.node_name)
                container.providers.append(process)
                container.phases[process.label] = 'waiting'
        for component in more.components():
            if component.label in self._by_label:
                raise ValueError(f'there is a {component.label} already')
            task = ComponentTask(
                component,
                self._state,
                self._lifecycles.of_label(component.label),
            )
            self._by_label[task.label] = task
            self._named(component.container).tasks.append(task)

    def replace_process(self, before: Process, process: Process) -> None:
        """Replace a process that does not run."""
        self.drop_process(before)
        self.extend(Plan((process,)))

    def drop_process(self, process: Process) -> None:
        """Remove a process that does not run from the plan."""
        self._lifecycles.drop(process.label)
        container = self._provided_by(process)
        if container is not None:
            container.providers.remove(process)
            container.phases.pop(process.label, None)

    def revise(self, component: Component) -> None:
        """Replace a component when it is loaded next."""
        task = self.task(component.label)
        is_same = component == task.component
        task.successor = None if is_same else component
        if task.unique_id is None and not task.is_due:
            self._succeed(task)

    def reload_changed(
        self, labels: Collection[str], processes: Collection[str]
    ) -> tuple[str, ...]:
        """
        Load components again after a change, and return their labels.

        Lifecycle nodes get their states back. Components that were unloaded on
        request stay unloaded.

        :param processes: The labels of processes that are started again, with
          their components
        """
        loaded = []
        for task in () if self.is_stopping else self.tasks:
            container = self._container_of(task)
            is_skipped = task.label in self._dropped or not task.is_wanted
            if task.label not in labels or is_skipped or not task.is_due:
                continue
            if not any(p.label in processes for p in container.providers):
                if container.is_gone or self._requests.given_up is not None:
                    continue
                self._emit(events.Requested(task.component, 'change'))
                self._reload(task)
            loaded.append(task.label)
        return tuple(loaded)

    def ended_containers(self, labels: Collection[str]) -> set[str]:
        """
        Return the processes of containers of components that have ended.

        For example, a component crashed its container with values that were
        changed since.
        """
        lacking = [t for t in self.tasks if t.label in labels and t.is_wanted]
        found = [self._container_of(task) for task in lacking]
        return {
            label
            for container in found
            if container.is_gone
            for label in container.phases
        }

    def drop(self, label: str) -> None:
        """
        Unload a component, then remove it from the plan.

        :raises RefusedError: when there is none, or all is being stopped
        """
        self._refuse_while_stopping()
        task = self.task(label)
        self._dropped.add(label)
        task.must_reload = False
        if task.is_due and task.is_wanted:
            self._unload(task)

    # commands

    def unload(self, label: str) -> None:
        """
        Unload one component, and keep it unloaded.

        It is not loaded again with its container either, until
        :meth:`reload`. An event reports the end.

        :raises RefusedError: when there is nothing to unload
        """
        task = self._due_task(label)
        if not task.is_wanted and not task.must_reload:
            raise RefusedError(
                f'{label} is being unloaded'
                if task.phase == 'unloading'
                else _NOT_LOADED.format(label)
            )
        if task.phase in ('unloaded', 'failed'):
            raise RefusedError(_NOT_LOADED.format(label))
        self._emit(events.Requested(task.component, 'stop'))
        task.must_reload = False
        self._unload(task)

    def reload(self, label: str) -> None:
        """
        Unload one component if it is loaded, then load it again.

        An event reports the end.

        :raises RefusedError: when it cannot be loaded now
        """
        task = self._due_task(label)
        container = self._container_of(task)
        if container.is_gone:
            (first, *_) = container.phases
            raise RefusedError(
                f'its container {container.name} does not run; '
                f'to start it again: --restart {first}'
            )
        if self._requests.given_up is not None:
            raise RefusedError(self._requests.given_up)
        self._emit(events.Requested(task.component, 'restart'))
        self._lifecycles.reset_goal(label)
        self._reload(task)

    def change_state(self, name: str, transition: str, reply: Reply) -> None:
        """
        Request a transition of a lifecycle node.

        :param name: The label of its process or component, or its full name
        :param transition: One of `plan.TRANSITIONS`
        :param reply: Called once, with None when the transition is made, or
          with the reason why it is not
        :raises RefusedError: when it cannot be requested now
        """
        self._refuse_while_stopping()
        self._lifecycles.change_state(name, transition, reply)

    # calls of the supervisor

    def due(self, component: Component) -> None:
        """Load a component whose turn has come."""
        task = self._by_label.get(component.label)
        if task is None:
            # it was dropped before its turn came
            return
        task.is_due = True
        if task.is_wanted:
            self._begin(task)

    def change_as_planned(self, entry: ChangeState) -> None:
        """Make a transition of the plan."""
        if not self.is_stopping:
            self._lifecycles.change_as_planned(entry)

    def at_ros_time(
        self, seconds: float, action: Callable[[], None]
    ) -> TimerHandle:
        """Call `action` after `seconds` of the topic `/clock`."""
        return self._timers.add(seconds, action)

    def started(self, process: Process) -> None:
        """Load the components of a container that runs now."""
        self._has_processes = True
        container = self._provided_by(process)
        if container is not None:
            container.phases[process.label] = 'running'
            for task in tuple(container.tasks):
                if task.is_due and task.is_wanted and task.unique_id is None:
                    self._begin(task)
        self._lifecycles.process_started(process)

    def stop_requested(self, process: Process, *, is_restart: bool) -> None:
        """
        Handle that a user asked to stop or restart a process.

        :param is_restart: Whether it starts again. Then its own lifecycle node
          begins with the goal of the launch file; its components get their
          states back.
        """
        container = self._provided_by(process)
        for task in () if container is None else container.tasks:
            self._lifecycles.stop_requested(task.label)
        self._lifecycles.stop_requested(process.label)
        if is_restart:
            self._lifecycles.reset_goal(process.label)

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
        Handle the end of a process, or that it could not be started.

        :param ending: How, as a part of a sentence
        :param asked: Whether it had been asked to stop
        :param failed: Whether its end is a failure of its own
        :param again: Whether it will be started again
        """
        if self.is_stopping:
            return
        self._has_processes = True
        container = self._provided_by(process)
        if container is not None:
            container.phases[process.label] = 'waiting' if again else 'ended'
            container.ending = f'{process.label} {ending}'
            if not container.runs:
                self._container_ended(container, asked=asked, again=again)
        excused = asked or failed or again
        self._lifecycles.process_ended(process, ending, excused=excused)

    def end(self) -> None:
        """Give up unloaded components, as no process runs."""
        self._fail_open(
            'there was no such container until everything in the launch had '
            'ended'
        )

    def stop(self) -> None:
        """Do nothing more, as the launch is being stopped."""
        self.is_stopping = True
        self._requests.reset()
        self._timers.cancel()

    def end_turn(self) -> None:
        """Forget dropped components, and warn of missing containers."""
        if self.is_stopping:
            return
        self._forget_dropped()
        for container in self._containers.values():
            waiting = container.open()
            if not waiting:
                self._warnings.cancel(container.name)
            elif self._warnings.is_due(container.name):
                self._emit(events.Warned(_waited_for(container, waiting)))
        self._lifecycles.end_turn()
        self._timers.end_turn()

    # messages of the client

    def handle(self, message: Mapping[str, Any]) -> None:
        """Handle one message of the client."""
        if self.is_stopping:
            return
        match message:
            case {'id': int()}:
                self._requests.handle(message)
            case {'event': 'ready'}:
                self._requests.client_is_ready()
                for container in self._containers.values():
                    if container.must_list:
                        self._list(container)
                    else:
                        self._request_open(container)
                self._lifecycles.client_is_ready()
                self._timers.follow_clock()
            case {'event': 'container', 'container': str(name)}:
                self._presence_changed(
                    name, is_present=bool(message.get('there'))
                )
            case {'event': 'state', 'node': str(node), 'state': str(state)}:
                before = message.get('from') or None
                self._lifecycles.changed(node, state, before)
            case {'event': 'clock', 'seconds': int() | float() as seconds}:
                self._timers.clock(seconds)
            case {'event': 'trouble', 'text': str(text)}:
                self._emit(events.Warned(text))
            case _:
                # of a newer client
                return

    def client_died(self) -> None:
        """Note that requests are lost; another client follows."""
        self._requests.reset()
        if self.is_stopping:
            return
        for container in self._containers.values():
            container.is_present = False
            container.listing = None
            for task in container.tasks:
                task.was_sent |= task.request is not None
                task.request = None
                if task.phase == 'loading':
                    self._enter(task, 'waiting')
                elif task.phase == 'unloading':
                    self._enter(task, 'loaded')
                if task.was_sent or task.unique_id is not None:
                    container.must_list = True
        self._lifecycles.client_died()
        self._timers.client_died()

    def client_given_up(self, reason: str) -> None:
        """
        Fail everything that needs a client, as none follows.

        :param reason: Why, as a sentence without its end
        """
        self._requests.reset()
        if self.is_stopping:
            return
        self._emit(events.RosLost(reason))
        self._requests.given_up = reason
        self._fail_open(reason)
        self._lifecycles.client_given_up(reason)
        self._timers.cancel()

    def _refuse_while_stopping(self) -> None:
        if self.is_stopping:
            raise RefusedError('the whole launch is being stopped')

    def _due_task(self, label: str) -> ComponentTask:
        self._refuse_while_stopping()
        task = self.task(label)
        if not task.is_due:
            raise RefusedError(f'{label} has not been loaded yet')
        return task

    def _reload(self, task: ComponentTask) -> None:
        if task.unique_id is None and task.phase != 'loading':
            task.is_wanted = True
            self._requests.cancel(task.request)
            self._begin(task)
            return
        task.must_reload = True
        self._unload(task)

    def _container_ended(
        self, container: _Container, *, asked: bool, again: bool
    ) -> None:
        container.is_present = container.must_list = False
        self._warnings.begin(container.name)
        self._requests.cancel(container.listing)
        container.listing = None
        if container.tasks:
            self._requests.gone(container=container.name)
        for task in container.tasks:
            if task.is_due:
                self._lost_container(container, task, asked=asked, again=again)

    def _presence_changed(self, name: str, *, is_present: bool) -> None:
        """Handle that the services of a container came or went."""
        container = self._containers.get(name)
        if container is None or container.is_gone:
            return
        if not is_present:
            self._services_lost(container)
            return
        if not container.is_present:
            self._warnings.begin(container.name)
        container.is_present = True
        if container.must_list:
            self._list(container)
        for task in container.tasks:
            if task.request is not None and task.phase == 'waiting':
                self._enter(task, 'loading')

    def _fail_open(self, reason: str) -> None:
        for container in self._containers.values():
            for task in container.open():
                self._fail(task, reason)

    def _named(self, name: str) -> _Container:
        return self._containers.setdefault(name, _Container(name))

    def _forget_dropped(self) -> None:
        for label in tuple(self._dropped):
            task = self._by_label[label]
            if task.phase not in ('loading', 'unloading'):
                self._dropped.remove(label)
                del self._by_label[label]
                self._container_of(task).tasks.remove(task)
                self._lifecycles.drop(label)
                self._emit(events.Dropped(task.component))

    def _succeed(self, task: ComponentTask) -> None:
        """Replace a component that is not loaded by its successor."""
        component, task.successor = task.successor, None
        if component is None:
            return
        self._container_of(task).tasks.remove(task)
        task.component = component
        self._named(component.container).tasks.append(task)
        self._lifecycles.drop(task.label)
        self._lifecycles.extend(Plan((component,)))
        task.lifecycle = self._lifecycles.of_label(task.label)
        self._emit(events.Planned((component,)))

    def _container_of(self, task: ComponentTask) -> _Container:
        return self._containers[task.component.container]

    def _provided_by(self, process: Process) -> _Container | None:
        return self._containers.get(process.node_name or '')

    def _enter(
        self, task: ComponentTask, phase: events.Phase, ending: str = ''
    ) -> None:
        """
        Put a component into a phase.

        :param ending: Why it is not loaded, or could not be unloaded
        """
        if (phase, ending) != (task.phase, task.state.ending):
            self._emit(events.MemberChanged(task.component, phase, ending))

    def _begin(self, task: ComponentTask) -> None:
        """Load a component as soon as possible."""
        self._succeed(task)
        container = self._container_of(task)
        task.request = None
        task.must_reload = False
        if not [t for t in container.open() if t is not task]:
            self._warnings.begin(container.name)
        self._enter(task, 'waiting')
        if container.is_gone:
            self._fail(task, f'its container {container.ending}')
        elif self._requests.given_up is not None:
            self._fail(task, self._requests.given_up)
        elif self._requests.is_ready and not container.must_list:
            self._load(container, task)

    def _load(self, container: _Container, task: ComponentTask) -> None:
        try:
            request = load_request(task.component)
        except ValueError as error:
            self._fail(task, str(error))
            return

        def answered(answer: Mapping[str, Any], refusal: str | None) -> None:
            task.request = None
            task.was_sent = False
            # those behind it go on from now
            self._warnings.begin(container.name)
            if refusal is None:
                self._loaded(task, answer['unique_id'], answer['full_name'])
            elif container.runs and has_ended(refusal):
                # the end of its process, which comes soon, says more
                container.must_list = True
                self._enter(task, 'waiting')
            elif task.is_wanted:
                self._fail(task, refusal)
            else:
                self._unloaded(task, refusal)

        task.request = self._requests.ask('load', answered, **request)
        if container.is_present:
            self._enter(task, 'loading')

    def _loaded(
        self, task: ComponentTask, unique_id: int, full_name: str
    ) -> None:
        seconds = self._state.seconds_of(task.state)
        task.unique_id, task.full_name = unique_id, full_name
        self._enter(task, 'loaded')
        self._emit(
            events.Loaded(task.component, full_name, unique_id, seconds)
        )
        if not task.is_wanted:
            self._ask_to_unload(task)
        elif task.lifecycle is not None:
            self._lifecycles.up(task.lifecycle, full_name)

    def _fail(
        self, task: ComponentTask, reason: str, *, again: bool = False
    ) -> None:
        task.request = None
        task.was_sent = False
        self._enter(task, 'waiting' if again else 'failed', reason)
        self._emit(events.LoadFailed(task.component, reason, again))

    def _unload(self, task: ComponentTask) -> None:
        """Unload a component, or cancel its load."""
        task.is_wanted = False
        if task.phase == 'unloading':
            return
        if task.unique_id is not None:
            self._ask_to_unload(task)
        elif task.phase != 'loading':
            self._requests.cancel(task.request)
            task.request = None
            self._unloaded(task, 'it was not loaded yet')
        # one that is being loaded is unloaded as soon as it is

    def _ask_to_unload(self, task: ComponentTask) -> None:
        container = self._container_of(task)
        self._enter(task, 'unloading')
        if self._requests.given_up is not None:
            self._unload_failed(task, self._requests.given_up)
            return
        if not self._requests.is_ready or container.must_list:
            return

        def answered(_: object, refusal: str | None) -> None:
            task.request = None
            if refusal is None:
                self._unloaded(task, events.REQUESTED)
            else:
                self._unload_failed(task, refusal)

        task.request = self._requests.ask(
            'unload',
            answered,
            container=container.name,
            unique_id=task.unique_id,
        )

    def _unload_failed(self, task: ComponentTask, reason: str) -> None:
        """Handle that a component cannot be unloaded."""
        task.is_wanted = True
        task.must_reload = False
        self._enter(task, 'loaded', f'could not be unloaded: {reason}')
        self._emit(events.Warned(f'{task.label}: {task.state.ending}'))

    def _unloaded(self, task: ComponentTask, reason: str) -> None:
        """Handle that a component is not loaded any more."""
        was_loaded = task.unique_id is not None
        task.unique_id = task.request = None
        if task.lifecycle is not None:
            self._lifecycles.down(task.lifecycle)
        self._enter(task, 'unloaded')
        if was_loaded:
            self._emit(events.Unloaded(task.component, reason))
        again, task.must_reload = task.must_reload, False
        if again:
            task.is_wanted = True
            self._begin(task)

    def _lost_container(
        self,
        container: _Container,
        task: ComponentTask,
        *,
        asked: bool,
        again: bool,
    ) -> None:
        """Handle the end of the container of a component."""
        was_open = task.is_open
        self._requests.cancel(task.request)
        task.request = None
        task.was_sent = False
        # an open reload is done with the container
        task.is_wanted |= task.must_reload
        task.must_reload = False
        if task.unique_id is not None:
            self._unloaded(task, events.CONTAINER_ENDED)
        reason = f'its container {container.ending}'
        if was_open and not asked:
            self._fail(task, reason, again=again)
        elif again and task.is_wanted:
            self._enter(task, 'waiting')
        elif task.phase != 'failed':
            self._enter(task, 'unloaded', reason)

    def _services_lost(self, container: _Container) -> None:
        container.is_present = False
        self._warnings.begin(container.name)
        for task in container.tasks:
            if task.phase == 'loading':
                self._enter(task, 'waiting')
        # the end of a process of this launch is handled in `ended`
        if not container.runs and any(
            task.unique_id is not None for task in container.tasks
        ):
            container.must_list = True

    def _list(self, container: _Container) -> None:
        """List the loaded components, before any is loaded twice."""
        if not self._requests.is_ready or container.listing is not None:
            return

        def answered(answer: Mapping[str, Any], refusal: str | None) -> None:
            container.listing = None
            if refusal is None:
                container.must_list = False
                self._compare(container, answer['nodes'])
                self._request_open(container)
            elif container.is_present:
                # else it is asked when it comes
                self._loop.call_later(
                    limits.LIST_RETRY_DELAY, self._list, container
                )

        container.listing = self._requests.ask(
            'list', answered, container=container.name
        )

    def _compare(
        self, container: _Container, nodes: Iterable[tuple[str, int]]
    ) -> None:
        """Compare the components with the nodes in their container."""
        left = {unique_id: name for name, unique_id in nodes}
        for task in tuple(container.tasks):
            if task.unique_id is None:
                continue
            if left.pop(task.unique_id, None) != task.full_name:
                was_wanted = task.is_wanted
                self._unloaded(task, 'its container came back without it')
                if was_wanted:
                    self._enter(task, 'waiting')
        for task in container.tasks:
            if task.was_sent and task.unique_id is None:
                task.was_sent = False
                unique_id = _loaded_as(task, left, own=container.runs)
                if unique_id is not None:
                    self._loaded(task, unique_id, left.pop(unique_id))

    def _request_open(self, container: _Container) -> None:
        """Request the loads and unloads that are still to be done."""
        for task in container.tasks:
            if task.request is not None:
                continue
            if task.is_open:
                self._load(container, task)
            elif task.unique_id is not None and not task.is_wanted:
                self._ask_to_unload(task)


def _loaded_as(
    task: ComponentTask, left: Mapping[int, str], *, own: bool
) -> int | None:
    """
    Return the id of a component that was being loaded, if it is.

    :param left: The nodes that are no other component, by their unique ids
    :param own: Whether only this launch loads into the container
    """
    name = task.component.node_name
    for unique_id, full_name in sorted(left.items()):
        if full_name == name or (own and name is None):
            return unique_id
    return None


def _waited_for(container: _Container, waiting: list[ComponentTask]) -> str:
    """Return which components wait for `container`."""
    names = events.listed([task.label for task in waiting])
    if container.is_present:
        first = waiting[0].label
        return f'{container.name} is still loading {first}'
    text = f'waiting for the container {container.name}, to load {names}'
    if container.runs:
        (label, *_) = (
            label
            for label, phase in container.phases.items()
            if phase == 'running'
        )
        return f'{text}; {label} runs, but is no container yet'
    if container.phases:
        return f'{text}; it has not been started yet'
    return f'{text}; nothing in this launch provides it'


def load_request(component: Component) -> dict[str, Any]:
    """
    Return the fields of a load request, see `ros_client`.

    :raises ValueError: when the value of a parameter cannot be read
    """
    return {
        'container': component.container,
        'package': component.package,
        'plugin': component.plugin,
        'name': component.name,
        'namespace': component.namespace,
        'remaps': list(component.remaps),
        'parameters': _values(component.parameters),
        'extra_arguments': _values(component.extra_arguments),
    }


def _values(parameters: Iterable[SetParameter]) -> list[list[Any]]:
    # the last of several with one name counts
    return [[n, v] for n, v in {p.name: _value(p) for p in parameters}.items()]


def _value(parameter: SetParameter) -> Any:
    text = _TOKENS.sub(
        lambda found: _WORDS.get(found[0], found[0]), parameter.value
    )
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(
            f"the value of its parameter '{parameter.name}' is no JSON: "
            f'{parameter.value}'
        ) from error
