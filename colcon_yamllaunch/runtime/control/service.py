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

from colcon_yamllaunch.runtime.acts.acts import Acts
from colcon_yamllaunch.runtime.control import protocol
from colcon_yamllaunch.runtime.control.backlog import Backlog
from colcon_yamllaunch.runtime.control.backlog import Cursor
from colcon_yamllaunch.runtime.control.launch_states import About
from colcon_yamllaunch.runtime.control.launch_states import ComponentState
from colcon_yamllaunch.runtime.control.launch_states import LaunchState
from colcon_yamllaunch.runtime.control.launch_states import ProcessState
from colcon_yamllaunch.runtime.control.launch_states import UNKNOWN
from colcon_yamllaunch.runtime.control.protocol import ProtocolError
from colcon_yamllaunch.runtime.core import events
from colcon_yamllaunch.runtime.core.outcome import ending_of
from colcon_yamllaunch.runtime.core.tasks import RefusedError
from colcon_yamllaunch.runtime.core.tasks import Task
from colcon_yamllaunch.runtime.course.engine import Engine

if TYPE_CHECKING:
    # most launches have no components
    from colcon_yamllaunch.runtime.components.component_task import (
        ComponentTask,
    )
    from colcon_yamllaunch.runtime.components.composition import Composition

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
    """

    def __init__(
        self,
        about: About,
        engine: Engine,
        acts: Acts,
        log_folder: Path | None,
        log_files: Mapping[str, Path],
        clock: Callable[[], float],
    ) -> None:
        self._about = about
        self._engine = engine
        self._acts = acts
        self._supervisor = engine.supervisor
        self._terminals = engine.terminals
        self._log_folder = log_folder
        self._log_files = log_files
        self._clock = clock
        self._started = clock()
        self._viewers: dict[str, list[Viewer]] = {}
        self._watched: events.Watched | None = None
        #: What happened last, for those who subscribe.
        self.backlog = Backlog()

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
                    answer = protocol.success(launch=asdict(self.state()))
                case 'shutdown':
                    self._supervisor.stop('requested', drop_timers=True)
                case 'stop':
                    self._acts.stop(_name(message))
                case 'restart':
                    self._acts.restart(_name(message))
                case 'kill':
                    self._acts.kill(_name(message))
                case 'debug':
                    self._acts.debug(_name(message))
                case 'describe':
                    answer = self._description(_name(message))
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
                    task = self._may_attach(_name(message))
                    granted = task.process.label
                    answer = protocol.success(pid=task.group)
                case 'subscribe':
                    granted = self.backlog.cursor(
                        message.get('since'),
                        wants_events=_flag(message, 'events'),
                        wants_output=_flag(message, 'output'),
                        labels=_labels(message),
                        before=cursor,
                    )
                    answer = protocol.success(
                        launch=asdict(self.state()), now=self.backlog.point
                    )
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
            processes=tuple(map(self.state_of, self._supervisor.tasks)),
            components=self._components(),
            watch=self._watch(),
            watch_failed=self._watched is not None and self._watched.failed,
            watch_paused=self._acts.is_watch_paused,
        )

    def state_of(self, task: Task) -> ProcessState:
        """Return the state of a process."""
        process = task.process
        log = self._log_files.get(process.label)
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
            None if log is None else str(log),
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
        self._engine.tell(
            events.Attached(self._supervisor.task(label).process)
        )

    def detach(self, label: str, viewer: Viewer) -> None:
        """Show a process to somebody no more."""
        self._viewers[label].remove(viewer)
        self._terminals.remove_sink(label, viewer.show)
        self._engine.tell(
            events.Detached(self._supervisor.task(label).process)
        )

    def _description(self, name: str) -> dict[str, Any]:
        description = asdict(self._acts.describe(name))
        description['environment'] = dict(description['environment'])
        return protocol.success(description=description)

    def _watch(self) -> str | None:
        if not self._engine.is_changed:
            return None
        return '' if self._watched is None else self._watched.text

    def _change_state(self, message: Mapping[str, Any], reply: Reply) -> None:
        from colcon_yamllaunch.runtime.components.transitions import (
            TRANSITIONS,
        )

        name, transition = _name(message), str(message.get('transition'))
        if transition not in TRANSITIONS:
            known = ', '.join(TRANSITIONS)
            raise ProtocolError(f"the 'transition' is one of {known}")
        composition = self._engine.composition
        if composition is None:
            raise RefusedError(f"there is no lifecycle node '{name}'")

        def tell(reason: str | None) -> None:
            """Answer once the node has done it (None), or has not."""
            reply(
                protocol.success()
                if reason is None
                else protocol.failure(reason)
            )

        composition.change_state(name, transition, tell)

    def _may_attach(self, name: str) -> Task:
        """Return a process that somebody may be attached to."""
        task = self._supervisor.task(name)
        label = task.process.label
        # under a debugger, others have one, too
        if not (
            task.process.emulate_tty or self._terminals.has_keyboard(label)
        ):
            raise RefusedError(
                f'{label} has no keyboard, as it has no terminal: give it '
                "'emulate_tty: true' in the launch file, or start the "
                f'launch with --attach {label}'
            )
        return task

    def _components(self) -> tuple[ComponentState, ...]:
        composition = self._engine.composition
        if composition is None:
            return ()
        return tuple(
            self._component_state(composition, task)
            for task in composition.tasks
        )

    def _component_state(
        self, composition: 'Composition', task: 'ComponentTask'
    ) -> ComponentState:
        component = task.component
        container = composition.container_process(task)
        process = None if container is None else container.label
        log = None if process is None else self._log_files.get(process)
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
            None if log is None else str(log),
            self._lifecycle_of(component.label),
        )

    def _lifecycle_of(self, label: str) -> str | None:
        composition = self._engine.composition
        if composition is None or not composition.is_lifecycle(label):
            return None
        return composition.state(label) or UNKNOWN


def _flag(message: Mapping[str, Any], name: str) -> bool:
    flag = message.get(name, True)
    if not isinstance(flag, bool):
        raise ProtocolError(f"'{name}' is true or false")
    return flag


def _labels(message: Mapping[str, Any]) -> frozenset[str] | None:
    labels = message.get('processes')
    if labels is None:
        return None
    if not isinstance(labels, list) or not all(
        isinstance(label, str) for label in labels
    ):
        raise ProtocolError("'processes' is a list of labels, or null")
    return frozenset(labels)


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
