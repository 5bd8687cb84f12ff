# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The course of components: what is loaded into which container, and when."""

from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from dataclasses import field
from itertools import count
from typing import Any
from typing import Literal

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.components.client_requests import has_ended
from colcon_yamllaunch.engine.components.client_requests import Requests
from colcon_yamllaunch.engine.components.component_task import ComponentTask
from colcon_yamllaunch.engine.components.component_task import LoadPhase
from colcon_yamllaunch.engine.components.lifecycles import Lifecycles
from colcon_yamllaunch.engine.components.load_request import load_request
from colcon_yamllaunch.engine.components.patience import Patience
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.tasks import RefusedError
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process

_NOT_LOADED = '{} is not loaded'


@dataclass(slots=True)
class _Container:
    """
    A container that components of the plan are loaded into.

    :param name: The full name of its node
    :param tasks: Its components, in the order of the plan
    :param providers: The processes of the plan that are it; usually one, and
      none if it runs elsewhere
    :param courses: What each of those does, by its label
    :param ending: How the last of those ended
    :param is_there: Whether its services were there when last heard of
    :param must_list: Whether it is not known what is loaded, as a client
      died, or it went away and came back
    :param since: Since when it is waited for
    """

    name: str
    tasks: list[ComponentTask] = field(default_factory=list)
    providers: list[Process] = field(default_factory=list)
    courses: dict[str, Literal['pending', 'running', 'ended']] = field(
        default_factory=dict
    )
    ending: str = ''
    is_there: bool = False
    must_list: bool = False
    listing: int | None = None
    since: float = 0.0

    @property
    def is_gone(self) -> bool:
        """Whether it was a process of ours, and none comes any more."""
        courses = self.courses.values()
        return bool(courses) and all(c == 'ended' for c in courses)

    @property
    def runs(self) -> bool:
        """Whether a process of ours is it and runs."""
        return 'running' in self.courses.values()

    def open(self) -> list[ComponentTask]:
        """Return what is still to be loaded."""
        return [task for task in self.tasks if task.is_open]


class Containers:
    """The components of a launch, by their containers."""

    def __init__(
        self,
        plan: Plan,
        requests: Requests,
        lifecycles: Lifecycles,
        tell: events.Listener,
        loop: Loop,
    ) -> None:
        self._requests = requests
        self._lifecycles = lifecycles
        self._tell = tell
        self._loop = loop
        self._given_up: str | None = None
        self._has_processes = False
        self._patience = Patience(loop)
        self._by_label: dict[str, ComponentTask] = {}
        self._containers: dict[str, _Container] = {}
        self._numbers = count()
        # those that are forgotten once they are not loaded any more
        self._dropped: set[str] = set()
        self.extend(plan)

    @property
    def tasks(self) -> list[ComponentTask]:
        """The components, in the order of the plan."""
        return list(self._by_label.values())

    def extend(self, more: Plan) -> None:
        """Take more into the plan."""
        # any process may turn out to be a container that something is
        # loaded into later
        for process in more.processes():
            if process.node_name is not None:
                container = self._named(process.node_name)
                container.providers.append(process)
                container.courses[process.label] = 'pending'
        for component in more.components():
            if component.label in self._by_label:
                raise ValueError(f'there is a {component.label} already')
            task = ComponentTask(
                next(self._numbers),
                component,
                self._loop.time(),
                self._lifecycles.of_label(component.label),
            )
            self._by_label[task.label] = task
            self._named(component.container).tasks.append(task)

    def replace(self, component: Component) -> None:
        """Have a component be another one; see `Composition`."""
        task = self.task(component.label)
        self._dropped.discard(task.label)
        task.successor = component
        if task.is_due and not self._container_of(task).is_gone:
            with suppress(RefusedError):
                self.reload(task.label)
        elif task.unique_id is None:
            self._succeed(task)

    def revise(self, component: Component) -> None:
        """Have a component be another one when it is loaded next."""
        task = self.task(component.label)
        is_same = component == task.component
        task.successor = None if is_same else component
        if task.unique_id is None and not task.is_due:
            self._succeed(task)

    def reload_changed(
        self, labels: Collection[str], processes: Collection[str]
    ) -> tuple[str, ...]:
        """Load components anew after a change; see `Composition`."""
        loaded = []
        for task in self.tasks:
            container = self._container_of(task)
            is_left = task.label in self._dropped or not task.is_wanted
            if task.label not in labels or is_left or not task.is_due:
                continue
            if not any(p.label in processes for p in container.providers):
                if container.is_gone or self._given_up is not None:
                    continue
                self._tell(events.Requested(task.component, 'change'))
                self._reload(task)
            loaded.append(task.label)
        return tuple(loaded)

    def ended_containers(self, labels: Collection[str]) -> set[str]:
        """Return the processes that components lack; see `Composition`."""
        lacking = [t for t in self.tasks if t.label in labels and t.is_wanted]
        found = [self._container_of(task) for task in lacking]
        return {label for c in found if c.is_gone for label in c.courses}

    def drop(self, label: str) -> None:
        """Unload a component, and forget it then; see `Composition`."""
        task = self.task(label)
        self._dropped.add(label)
        task.is_again = False
        if task.is_due and task.is_wanted:
            self._unload(task)

    def drop_process(self, process: Process) -> None:
        """Forget a process, which does not run."""
        container = self._provided_by(process)
        if container is not None:
            container.providers.remove(process)
            container.courses.pop(process.label, None)

    def task(self, label: str) -> ComponentTask:
        """Return a component; see `Composition.task`."""
        if label not in self._by_label:
            raise RefusedError(f"there is no component '{label}'")
        return self._by_label[label]

    def provider(self, name: str) -> Process | None:
        """Return the process of the plan that a container is, if one is."""
        container = self._containers.get(name)
        if container is None or not container.providers:
            return None
        return container.providers[0]

    def seconds(self, task: ComponentTask) -> float:
        """Return for how long a component has been in its phase."""
        return self._loop.time() - task.since

    @property
    def is_busy(self) -> bool:
        """
        Whether anything is still to be loaded while no process runs.

        Who started nothing waits for a container elsewhere for ever; others
        give it a while, and go on only if it is there.
        """
        now = self._loop.time()
        return any(
            container.is_there
            or not self._has_processes
            or now < container.since + limits.PATIENCE
            for container in self._containers.values()
            if container.open()
        )

    def due(self, component: Component) -> None:
        """Load a component, whose turn has come."""
        task = self._by_label.get(component.label)
        if task is None:
            # it was dropped before its turn came
            return
        task.is_due = True
        if task.is_wanted:
            self._begin(task)

    def unload(self, label: str) -> None:
        """Unload a component; see `Composition.unload`."""
        task = self.task(label)
        if not task.is_due:
            raise RefusedError(f'{label} has not been loaded yet')
        if not task.is_wanted and not task.is_again:
            raise RefusedError(
                f'{label} is being unloaded'
                if task.phase == 'unloading'
                else _NOT_LOADED.format(label)
            )
        if task.phase in ('unloaded', 'failed'):
            raise RefusedError(_NOT_LOADED.format(label))
        self._tell(events.Requested(task.component, 'stop'))
        task.is_again = False
        self._unload(task)

    def reload(self, label: str) -> None:
        """Load a component anew; see `Composition.reload`."""
        task = self.task(label)
        if not task.is_due:
            raise RefusedError(f'{label} has not been loaded yet')
        container = self._container_of(task)
        if container.is_gone:
            (first, *_) = container.courses
            raise RefusedError(
                f'its container {container.name} does not run; '
                f'to start it again: --restart {first}'
            )
        if self._given_up is not None:
            raise RefusedError(self._given_up)
        self._tell(events.Requested(task.component, 'restart'))
        self._lifecycles.begins_anew(label)
        self._reload(task)

    def _reload(self, task: ComponentTask) -> None:
        if task.unique_id is None and task.phase != 'loading':
            task.is_wanted = True
            self._requests.cancel(task.request)
            self._begin(task)
            return
        task.is_again = True
        self._unload(task)

    def started(self, process: Process) -> None:
        """Load what belongs into a container that runs now."""
        self._has_processes = True
        container = self._provided_by(process)
        if container is None:
            return
        container.courses[process.label] = 'running'
        for task in tuple(container.tasks):
            if task.is_due and task.is_wanted and task.unique_id is None:
                self._begin(task)

    def leaves(self, process: Process) -> None:
        """Take into account that a process is asked to end."""
        container = self._provided_by(process)
        for task in () if container is None else container.tasks:
            self._lifecycles.leaves(task.label)

    def ended(
        self, process: Process, ending: str, *, asked: bool, again: bool
    ) -> None:
        """Take the end of a process into account; see `Composition`."""
        self._has_processes = True
        container = self._provided_by(process)
        if container is None:
            return
        container.courses[process.label] = 'pending' if again else 'ended'
        container.ending = f'{process.label} {ending}'
        if container.runs:
            return
        container.is_there = container.must_list = False
        container.since = self._loop.time()
        self._requests.cancel(container.listing)
        container.listing = None
        if container.tasks:
            self._requests.gone(container=container.name)
        for task in container.tasks:
            if task.is_due:
                self._went_with(container, task, asked=asked, again=again)

    def seen(self, name: str, *, is_there: bool) -> None:
        """Take into account that the services of a container came or went."""
        container = self._containers.get(name)
        if container is None or container.is_gone:
            return
        if not is_there:
            self._vanished(container)
            return
        if not container.is_there:
            container.since = self._loop.time()
        container.is_there = True
        if container.must_list:
            self._list(container)
        for task in container.tasks:
            if task.request is not None and task.phase == 'waiting':
                self._enter(task, 'loading')

    def client_is_ready(self) -> None:
        """Ask for everything that is to be done."""
        for container in self._containers.values():
            if container.must_list:
                self._list(container)
            else:
                self._go_on(container)

    def client_died(self) -> None:
        """Take into account that nobody answers what was asked."""
        for container in self._containers.values():
            container.is_there = False
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

    def client_given_up(self, reason: str) -> None:
        """Give up what is still to be loaded."""
        self._given_up = reason
        for container in self._containers.values():
            for task in container.open():
                self._fail(task, reason)

    def give_up(self) -> None:
        """Give up what is still to be loaded, as the launch ends."""
        for container in self._containers.values():
            for task in container.open():
                self._fail(
                    task,
                    'there was no such container until everything in the '
                    'launch had ended',
                )

    def end_turn(self) -> None:
        """Forget what was dropped, and say which containers do not come."""
        self._forget_dropped()
        for container in self._containers.values():
            waiting = container.open()
            if not waiting:
                self._patience.forget(container.name)
            elif self._patience.is_over(container.name, container.since):
                self._tell(events.Warned(_waited_for(container, waiting)))

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
                self._tell(events.Dropped(task.component))

    def _succeed(self, task: ComponentTask) -> None:
        """Have a component that is not loaded be what comes after it."""
        component, task.successor = task.successor, None
        if component is None:
            return
        self._container_of(task).tasks.remove(task)
        task.component = component
        self._named(component.container).tasks.append(task)
        self._lifecycles.drop(task.label)
        self._lifecycles.extend(Plan((component,)))
        task.lifecycle = self._lifecycles.of_label(task.label)
        self._tell(events.Planned((component,)))

    def _container_of(self, task: ComponentTask) -> _Container:
        return self._containers[task.component.container]

    def _provided_by(self, process: Process) -> _Container | None:
        return self._containers.get(process.node_name or '')

    def _enter(
        self, task: ComponentTask, phase: LoadPhase, ending: str = ''
    ) -> None:
        """
        Put a component into a phase.

        :param ending: Why it is not loaded, or could not be unloaded
        """
        if phase != task.phase:
            task.since = self._loop.time()
        elif ending == task.ending:
            return
        task.phase, task.ending = phase, ending
        self._tell(events.PartChanged(task.component, phase, ending))

    def _begin(self, task: ComponentTask) -> None:
        """Have a component loaded as soon as that can be."""
        self._succeed(task)
        container = self._container_of(task)
        task.request = None
        task.is_again = False
        if not [t for t in container.open() if t is not task]:
            container.since = self._loop.time()
        self._enter(task, 'waiting')
        if container.is_gone:
            self._fail(task, f'its container {container.ending}')
        elif self._given_up is not None:
            self._fail(task, self._given_up)
        elif self._requests.is_ready and not container.must_list:
            self._load(container, task)

    def _load(self, container: _Container, task: ComponentTask) -> None:
        try:
            request = load_request(task.component)
        except ValueError as error:
            self._fail(task, str(error))
            return

        def answered(answer: Mapping[str, Any]) -> None:
            task.request = None
            task.was_sent = False
            # those behind it go on from now
            container.since = self._loop.time()
            if container.runs and has_ended(answer):
                # the end of its process, which comes soon, says more
                container.must_list = True
                self._enter(task, 'waiting')
                return
            if not answer.get('ok'):
                self._refused(task, str(answer.get('reason') or 'no reason'))
                return
            self._loaded(task, answer['unique_id'], answer['full_name'])

        task.request = self._requests.ask('load', answered, **request)
        if container.is_there:
            self._enter(task, 'loading')

    def _loaded(
        self, task: ComponentTask, unique_id: int, full_name: str
    ) -> None:
        seconds = self.seconds(task)
        task.unique_id, task.full_name = unique_id, full_name
        self._enter(task, 'loaded')
        self._tell(
            events.Loaded(task.component, full_name, unique_id, seconds)
        )
        if not task.is_wanted:
            self._ask_to_unload(task)
        elif task.lifecycle is not None:
            self._lifecycles.up(task.lifecycle, full_name)

    def _refused(self, task: ComponentTask, reason: str) -> None:
        if task.is_wanted:
            self._fail(task, reason)
            return
        again, task.is_again = task.is_again, False
        task.is_wanted = again
        self._enter(task, 'unloaded')
        if again:
            self._begin(task)

    def _fail(
        self, task: ComponentTask, reason: str, *, again: bool = False
    ) -> None:
        task.request = None
        task.was_sent = False
        self._enter(task, 'waiting' if again else 'failed', reason)
        self._tell(events.LoadFailed(task.component, reason, again))

    def _unload(self, task: ComponentTask) -> None:
        """Unload a component, or take back that it is to be loaded."""
        task.is_wanted = False
        if task.phase == 'unloading':
            return
        if task.unique_id is not None:
            self._ask_to_unload(task)
        elif task.phase != 'loading':
            self._requests.cancel(task.request)
            task.request = None
            self._gone(task, 'it was not loaded yet')
        # one that is being loaded is unloaded as soon as it is

    def _ask_to_unload(self, task: ComponentTask) -> None:
        container = self._container_of(task)
        self._enter(task, 'unloading')
        if self._given_up is not None:
            self._kept(task, self._given_up)
            return
        if not self._requests.is_ready or container.must_list:
            return

        def answered(answer: Mapping[str, Any]) -> None:
            task.request = None
            if answer.get('ok'):
                self._gone(task, events.REQUESTED)
            else:
                self._kept(task, str(answer.get('reason') or 'no reason'))

        task.request = self._requests.ask(
            'unload',
            answered,
            container=container.name,
            unique_id=task.unique_id,
        )

    def _kept(self, task: ComponentTask, reason: str) -> None:
        """Take into account that a component cannot be unloaded."""
        task.is_wanted = True
        task.is_again = False
        self._enter(task, 'loaded', f'could not be unloaded: {reason}')
        self._tell(events.Warned(f'{task.label}: {task.ending}'))

    def _gone(self, task: ComponentTask, reason: str) -> None:
        """Take into account that a component is not loaded any more."""
        was_loaded = task.unique_id is not None
        task.unique_id = task.request = None
        if task.lifecycle is not None:
            self._lifecycles.down(task.lifecycle)
        self._enter(task, 'unloaded')
        if was_loaded:
            self._tell(events.Unloaded(task.component, reason))
        again, task.is_again = task.is_again, False
        if again:
            task.is_wanted = True
            self._begin(task)

    def _went_with(
        self,
        container: _Container,
        task: ComponentTask,
        *,
        asked: bool,
        again: bool,
    ) -> None:
        """Take into account that the container of a component ended."""
        was_open = task.is_open
        self._requests.cancel(task.request)
        task.request = None
        task.was_sent = False
        # who asked to load it anew gets it with the container
        task.is_wanted |= task.is_again
        task.is_again = False
        if task.unique_id is not None:
            self._gone(task, events.CONTAINER_ENDED)
        reason = f'its container {container.ending}'
        if was_open and not asked:
            self._fail(task, reason, again=again)
        elif again and task.is_wanted:
            self._enter(task, 'waiting')
        elif task.phase != 'failed':
            self._enter(task, 'unloaded', reason)

    def _vanished(self, container: _Container) -> None:
        container.is_there = False
        container.since = self._loop.time()
        for task in container.tasks:
            if task.phase == 'loading':
                self._enter(task, 'waiting')
        # of a process of ours, its end tells what to do
        if not container.runs and any(
            task.unique_id is not None for task in container.tasks
        ):
            container.must_list = True

    def _list(self, container: _Container) -> None:
        """Ask what is loaded, before anything is loaded twice."""
        if not self._requests.is_ready or container.listing is not None:
            return

        def answered(answer: Mapping[str, Any]) -> None:
            container.listing = None
            if answer.get('ok'):
                container.must_list = False
                self._compare(container, answer['nodes'])
                self._go_on(container)
            elif container.is_there:
                # else it is asked when it comes
                self._loop.call_later(limits.LIST_PAUSE, self._list, container)

        container.listing = self._requests.ask(
            'list', answered, container=container.name
        )

    def _compare(
        self, container: _Container, nodes: Iterable[tuple[str, int]]
    ) -> None:
        """Take into account what is loaded in a container."""
        left = {unique_id: name for name, unique_id in nodes}
        for task in tuple(container.tasks):
            if task.unique_id is None:
                continue
            if left.pop(task.unique_id, None) != task.full_name:
                was_wanted = task.is_wanted
                self._gone(task, 'its container came back without it')
                if was_wanted:
                    self._enter(task, 'waiting')
        for task in container.tasks:
            if task.was_sent and task.unique_id is None:
                task.was_sent = False
                unique_id = _loaded_as(task, left, own=container.runs)
                if unique_id is not None:
                    self._loaded(task, unique_id, left.pop(unique_id))

    def _go_on(self, container: _Container) -> None:
        """Ask for what is still to be loaded and unloaded."""
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
    Return which node a component is that was being loaded.

    :param left: What is loaded and nobody else's, by the unique ids
    :param own: Whether nobody but this launch loads into the container
    """
    name = task.component.node_name
    for unique_id, full_name in sorted(left.items()):
        if full_name == name or (own and name is None):
            return unique_id
    return None


def _waited_for(container: _Container, waiting: list[ComponentTask]) -> str:
    """Say that a container is waited for, and for what."""
    names = ', '.join(t.label for t in waiting[: limits.NAMES_SHOWN])
    if len(waiting) > limits.NAMES_SHOWN:
        names += f' and {len(waiting) - limits.NAMES_SHOWN} more'
    if container.is_there:
        first = waiting[0].label
        return f'{container.name} is still loading {first}'
    text = f'waiting for the container {container.name}, to load {names}'
    if container.runs:
        (label, *_) = (
            n for n, c in container.courses.items() if c == 'running'
        )
        return f'{text}; {label} runs, but is no container yet'
    if container.courses:
        return f'{text}; it has not been started yet'
    return f'{text}; nothing in this launch provides it'
