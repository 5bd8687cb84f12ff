# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a running launch does for its clients; see `protocol`."""

from collections.abc import Callable
from collections.abc import Mapping
from dataclasses import asdict
import os
from pathlib import Path
from typing import Any
from typing import Protocol
from typing import TYPE_CHECKING
from typing import TypeVar

from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.acts import Acts
from colcon_yamllaunch.control.journal import Cursor
from colcon_yamllaunch.control.journal import Journal
from colcon_yamllaunch.control.launch_states import About
from colcon_yamllaunch.control.launch_states import ComponentState
from colcon_yamllaunch.control.launch_states import LaunchState
from colcon_yamllaunch.control.launch_states import MachineState
from colcon_yamllaunch.control.launch_states import ProcessState
from colcon_yamllaunch.control.launch_states import UNKNOWN
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.control.subscribers import Lease
from colcon_yamllaunch.control.subscribers import Subscribers
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.outcome import ending_of
from colcon_yamllaunch.engine.tasks import RefusedError
from colcon_yamllaunch.engine.tasks import Task
from colcon_yamllaunch.plan.plan import Process

if TYPE_CHECKING:
    # most launches have no components, and few are asked for them
    from colcon_yamllaunch.control.description import Description
    from colcon_yamllaunch.engine.components.component_task import (
        ComponentTask,
    )
    from colcon_yamllaunch.engine.components.composition import Composition
    from colcon_yamllaunch.engine.elsewhere import Done
    from colcon_yamllaunch.engine.elsewhere import Elsewhere

_State = TypeVar('_State', ProcessState, ComponentState)
#: Takes the answer to a request.
Reply = Callable[[Mapping[str, Any]], None]


class Viewer(Protocol):
    """Somebody who is attached to a process."""

    def show(self, stream: events.Stream, data: bytes) -> None:
        """Take what the process wrote."""

    def tell(self, message: Mapping[str, Any]) -> None:
        """Take a message."""


class Service:
    """
    Answers requests, and shows viewers what processes write.

    :param log_files: For each label the log with all output
    :param lease: Stops the launch when it is not renewed
    """

    def __init__(
        self,
        about: About,
        engine: Engine,
        acts: Acts,
        log_folder: Path | None,
        log_files: Mapping[str, Path],
        clock: Callable[[], float],
        journal: Journal,
        lease: Lease = bool,
    ) -> None:
        self._about = about
        self._engine = engine
        self._acts = acts
        self._supervisor = engine.supervisor
        self._terminals = engine.terminals
        self._elsewhere = engine.elsewhere
        self._log_folder = log_folder
        self._log_files = log_files
        self._clock = clock
        self._started = clock()
        self._viewers: dict[str, list[Viewer]] = {}
        self._watched: events.Watched | None = None
        #: What happened, for those who subscribe.
        self.journal = journal
        self.subscribers = Subscribers(journal, lease)

    def handle(self, event: events.Event) -> None:
        """Listen to an event."""
        if isinstance(event, events.Watched):
            self._watched = event
        if isinstance(event, events.Started | events.Exited):
            for viewer in tuple(self._viewers.get(event.process.label, ())):
                if isinstance(event, events.Started):
                    viewer.tell({'started': event.pid})
                else:
                    ending = ending_of(event.outcome, event.asked)
                    again = event.respawn_delay is not None
                    viewer.tell({'ended': ending, 'again': again})

    def answer(
        self,
        message: Mapping[str, Any],
        reply: Reply,
        cursor: Cursor | None = None,
    ) -> str | Cursor | None:
        """
        Answer a request, at once unless `protocol` says otherwise.

        Return the label of the process to :meth:`attach` the client to, or
        from where on it is told what happens, or None.

        :param cursor: Where the client has come that has subscribed
        :raises ProtocolError: when it has a wrong form
        """
        if message.get('version') != protocol.VERSION:
            raise ProtocolError(
                f'this launch speaks version {protocol.VERSION} of the '
                'protocol; use the same colcon-yamllaunch as it does'
            )
        granted: str | Cursor | None = None
        answer = protocol.success()
        try:
            match message.get('request'):
                case 'status':
                    self._measured(
                        lambda: reply(
                            protocol.success(launch=asdict(self.state()))
                        )
                    )
                    return None
                case 'shutdown':
                    self._engine.stop('requested')
                case 'stop' | 'restart' | 'kill' | 'debug' as action:
                    self._acts.act(action, _name(message), _answering(reply))
                    return None
                case 'describe':
                    self._acts.describe_to(
                        _name(message), lambda told: reply(_description(told))
                    )
                    return None
                case 'tree':
                    tree = [asdict(branch) for branch in self._acts.tree()]
                    answer = protocol.success(tree=tree)
                case 'watch':
                    self._acts.watch(paused=_is_pause(message))
                case 'change_state':
                    self._change_state(message, reply)
                    return None
                case 'attach':
                    if cursor is not None:
                        raise RefusedError(
                            'who has subscribed attaches by another connection'
                        )
                    granted, pid = self._may_attach(_name(message))
                    answer = protocol.success(pid=pid)
                case 'subscribe':
                    granted = self.subscribers.subscribe(message, cursor)
                    answer = protocol.success(
                        launch=asdict(self.state()), now=self.journal.point
                    )
                case 'ping':
                    fields = self.subscribers.ping(message, cursor)
                    answer = protocol.success(**fields)
                case _:
                    raise ProtocolError('there is no such request')
        except RefusedError as error:
            answer = protocol.failure(str(error))
        reply(answer)
        return granted

    def state(self) -> LaunchState:
        """Return the state of the launch."""
        return LaunchState(
            **asdict(self._about),
            pid=os.getpid(),
            seconds=round(self._clock() - self._started, 3),
            stopping=self._supervisor.is_stopping,
            log_folder=None
            if self._log_folder is None
            else str(self._log_folder),
            processes=self._processes(),
            components=self._components(),
            watch=self._watch(),
            watch_failed=self._watched is not None and self._watched.failed,
            watch_paused=self._acts.is_watch_paused,
            machines=()
            if self._elsewhere is None
            else tuple(
                MachineState(**told)
                for told in self._elsewhere.machine_states()
            ),
        )

    def state_of(self, task: Task) -> ProcessState:
        """Return the state of a process."""
        process = task.process
        return ProcessState(
            process.label,
            self._supervisor.phase(task),
            task.group,
            round(self._supervisor.seconds(task), 3),
            task.restarts,
            task.ending,
            os.path.basename(str(process.argv[0])),
            process.node_name,
            process.package,
            self._log_of(process.label),
            self._terminals.has_keyboard(process.label),
            process.ros_name,
            self._lifecycle_of(process.label),
        )

    def type(self, label: str, keys: bytes) -> None:
        """Type at a process."""
        self._terminals.type(label, keys)

    def attach(self, label: str, viewer: Viewer) -> None:
        """Show a process to somebody who got leave to attach."""
        self._viewers.setdefault(label, []).append(viewer)
        self._terminals.add_sink(label, viewer.show)
        self._engine.tell(events.Attached(self._process(label)))

    def detach(self, label: str, viewer: Viewer) -> None:
        """Show a process to somebody no more."""
        self._viewers[label].remove(viewer)
        self._terminals.remove_sink(label, viewer.show)
        self._engine.tell(events.Detached(self._process(label)))

    def _process(self, name: str) -> Process:
        """
        Return a process, wherever it runs.

        :raises RefusedError: when there is none
        """
        if self._elsewhere is not None and self._elsewhere.has(name):
            part = self._elsewhere.part(name)
            if isinstance(part, Process):
                return part
        return self._supervisor.task(name).process

    def _measured(self, then: Callable[[], None]) -> None:
        """Do something when it is known what other machines are used for."""
        if self._elsewhere is None:
            then()
        else:
            self._elsewhere.measure(then)

    def _watch(self) -> str | None:
        if not self._engine.is_changed:
            return None
        return '' if self._watched is None else self._watched.text

    def _change_state(self, message: Mapping[str, Any], reply: Reply) -> None:
        from colcon_yamllaunch.engine.components.transitions import TRANSITIONS

        name, transition = _name(message), str(message.get('transition'))
        if transition not in TRANSITIONS:
            known = ', '.join(TRANSITIONS)
            raise ProtocolError(f"the 'transition' is one of {known}")
        if self._elsewhere is not None and self._elsewhere.has(name):
            self._elsewhere.change_state(name, transition, _answering(reply))
            return
        composition = self._engine.composition
        if composition is None:
            raise RefusedError(f"there is no lifecycle node '{name}'")
        composition.change_state(name, transition, _answering(reply))

    def _may_attach(self, name: str) -> tuple[str, int | None]:
        """Return label and pid of a process to be attached to."""
        process = self._process(name)
        label = process.label
        # under a debugger, others have one, too
        if not (process.emulate_tty or self._terminals.has_keyboard(label)):
            raise RefusedError(
                f'{label} has no keyboard, as it has no terminal: give it '
                "'emulate_tty: true' in the launch file, or start the "
                f'launch with --attach {label}'
            )
        states = self._processes()
        return label, next((p.pid for p in states if p.label == label), None)

    def _processes(self) -> tuple[ProcessState, ...]:
        states = [self.state_of(task) for task in self._supervisor.tasks]
        elsewhere = self._elsewhere
        if elsewhere is not None:
            states += [
                ProcessState(**{**told, 'log': self._log_of(told['label'])})
                for told in elsewhere.process_states()
            ]
            states = _in_order(states, elsewhere)
        return tuple(states)

    def _log_of(self, label: str | None) -> str | None:
        log = None if label is None else self._log_files.get(label)
        return None if log is None else str(log)

    def _components(self) -> tuple[ComponentState, ...]:
        composition, elsewhere = self._engine.composition, self._elsewhere
        states: list[ComponentState] = []
        if composition is not None:
            states += [
                self._component_state(composition, task)
                for task in composition.tasks
            ]
        if elsewhere is not None:
            states += [
                ComponentState(
                    **{**told, 'log': self._log_of(told['process'])}
                )
                for told in elsewhere.component_states()
            ]
            states = _in_order(states, elsewhere)
        return tuple(states)

    def _component_state(
        self, composition: 'Composition', task: 'ComponentTask'
    ) -> ComponentState:
        component = task.component
        container = composition.container_process(task)
        process = None if container is None else container.label
        return ComponentState(
            component.label,
            task.phase,
            round(composition.seconds(task), 3),
            task.ending,
            component.plugin,
            task.full_name or component.node_name,
            component.package,
            component.container,
            process,
            self._log_of(process),
            self._lifecycle_of(component.label),
        )

    def _lifecycle_of(self, label: str) -> str | None:
        composition = self._engine.composition
        if composition is None or not composition.is_lifecycle(label):
            return None
        return composition.state(label) or UNKNOWN


def _in_order(states: list[_State], elsewhere: 'Elsewhere') -> list[_State]:
    # few launches have parts elsewhere
    from colcon_yamllaunch.engine.elsewhere import in_order

    return in_order(states, elsewhere.order, lambda state: state.label)


def _answering(reply: Reply) -> 'Done':
    """Return what answers once something is done or begun, or is not."""

    def done(reason: str | None) -> None:
        reply(
            protocol.success() if reason is None else protocol.failure(reason)
        )

    return done


def _description(told: 'Description | str') -> Mapping[str, Any]:
    """Return the answer with a description, or why there is none."""
    if isinstance(told, str):
        return protocol.failure(told)
    description = asdict(told)
    description['environment'] = dict(description['environment'])
    return protocol.success(description=description)


def _is_pause(message: Mapping[str, Any]) -> bool:
    action = message.get('action')
    if action not in ('pause', 'resume'):
        raise ProtocolError("the 'action' is one of pause, resume")
    return bool(action == 'pause')


def _name(message: Mapping[str, Any]) -> str:
    name = message.get('process')
    if not isinstance(name, str):
        raise ProtocolError("the request needs the name of a 'process'")
    return name
