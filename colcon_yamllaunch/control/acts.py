# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What users do with single processes and components of a launch that runs."""

from collections.abc import Callable
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from typing import Literal
from typing import TYPE_CHECKING

from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.process.spawn import StartError
from colcon_yamllaunch.engine.tasks import RefusedError
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import ParametersOf
from colcon_yamllaunch.plan.plan import Process

if TYPE_CHECKING:
    # few launches are asked for these, or have components
    from colcon_yamllaunch.control.description import Description
    from colcon_yamllaunch.control.plan_tree import Branch
    from colcon_yamllaunch.engine.components.composition import ComponentTask
    from colcon_yamllaunch.engine.components.composition import Composition
    from colcon_yamllaunch.engine.elsewhere import Done

#: What can be done with one of them.
Act = Literal['stop', 'restart', 'kill', 'debug']


class Acts:
    """
    What the control socket and the keys in the terminal both do.

    Names are labels, or what ROS 2 calls a process, or the full name of the
    node of a component. All of it begins at once and waits for nothing.

    :param log_files: For each label the log with all output
    :param parameters_of: Tells which parameters a process is given, and where
    """

    def __init__(
        self,
        engine: Engine,
        log_files: Mapping[str, Path],
        parameters_of: ParametersOf,
    ) -> None:
        self._engine = engine
        self._supervisor = engine.supervisor
        self._log_files = log_files
        self._parameters_of = parameters_of

    def act(self, action: Act, name: str, done: 'Done') -> None:
        """
        Do what one of the next methods does, wherever the part runs.

        :param done: Is told that it has begun, or why another machine refused
          it; that may be later
        :raises RefusedError: when it is refused here
        """
        elsewhere = self._engine.elsewhere
        if elsewhere is not None and elsewhere.has(name):
            elsewhere.act(action, name, done)
            return
        match action:
            case 'stop':
                self.stop(name)
            case 'restart':
                self.restart(name)
            case 'kill':
                self.kill(name)
            case 'debug':
                self.debug(name)
        done(None)

    def stop(self, name: str) -> None:
        """
        Stop a process, or unload a component, and keep it so.

        Once more takes the next step of stopping at once.

        :raises RefusedError: when there is nothing to stop
        """
        component = self._component(name)
        if component is None:
            self._supervisor.stop_process(name)
        else:
            composition, task = component
            composition.unload(task.label)

    def restart(self, name: str) -> None:
        """
        Start a process, or load a component, anew.

        :raises RefusedError: when that cannot be now
        """
        component = self._component(name)
        if component is None:
            self._supervisor.restart_process(name)
        else:
            composition, task = component
            composition.reload(task.label)

    def kill(self, name: str) -> None:
        """
        End a process and all that it started by SIGKILL, as if by `stop`.

        :raises RefusedError: when there is nothing to end, or it is a
          component
        """
        self._refuse_component(name, 'killed')
        self._supervisor.kill_process(name)

    def debug(self, name: str) -> None:
        """
        Start a process anew under a debugger, in a terminal of its own.

        A program in Python runs under `pdb`, any other under `gdb`, which
        waits for commands. Its next start is as ever.

        :raises RefusedError: when there is no debugger, when it cannot be
          started now, or it is a component
        """
        from colcon_yamllaunch.control.debugger import debugged

        self._refuse_component(name, 'debugged')
        task = self._supervisor.task(name)
        process = task.successor or task.process
        environment = self._engine.starter.environment_of(process)
        once = debugged(process, environment)
        self._supervisor.restart_process(name, once)

    @property
    def is_watch_paused(self) -> bool:
        """Whether nothing follows from changes of files for the time being."""
        changes = self._engine.changes
        return changes is not None and changes.is_paused

    def watch(self, *, paused: bool) -> None:
        """
        Have something follow from changes of files, or nothing.

        :raises RefusedError: when no files are watched
        """
        changes = self._engine.changes
        if changes is None:
            raise RefusedError('no files are watched; that is --watch')
        if paused:
            changes.pause()
        else:
            changes.resume()

    def describe(self, name: str) -> 'Description':
        """
        Tell all of a process or component, as it is planned now.

        :raises RefusedError: when there is none, or its parameter file cannot
          be written
        """
        from colcon_yamllaunch.control.description import component_description
        from colcon_yamllaunch.control.description import process_description

        blocks = self._engine.blocks
        found = self._component(name)
        if found is not None:
            composition, component = found
            container = composition.container_process(component)
            place = component.label if container is None else container.label
            return component_description(
                component, blocks, self._log_files.get(place)
            )
        task = self._supervisor.task(name)
        process = task.successor or task.process
        try:
            argv = self._engine.starter.command_line(task.number, process)
        except StartError as error:
            raise RefusedError(f'{process.label}: {error}') from error
        return process_description(
            process,
            argv,
            self._parameters_of(process),
            blocks,
            self._log_files.get(process.label),
        )

    def describe_to(
        self, name: str, done: 'Callable[[Description | str], None]'
    ) -> None:
        """
        Tell all of a process or component, wherever it runs.

        :param done: Takes that, or why another machine does not tell it; that
          may be later
        :raises RefusedError: when it is refused here
        """
        elsewhere = self._engine.elsewhere
        if elsewhere is None or not elsewhere.has(name):
            done(self.describe(name))
            return
        from colcon_yamllaunch.control.description import told_description

        part = elsewhere.part(name)

        def described(told: Mapping[str, Any] | str) -> None:
            if isinstance(told, str):
                done(told)
                return
            log = self._log_files.get(part.label)
            done(told_description(part, told, self._engine.blocks, log))

        elsewhere.describe(name, described)

    def tree(self) -> 'tuple[Branch, ...]':
        """Return the plan as a tree."""
        from colcon_yamllaunch.control.plan_tree import plan_tree

        composition, elsewhere = (
            self._engine.composition,
            self._engine.elsewhere,
        )
        processes = [t.successor or t.process for t in self._supervisor.tasks]
        components: list[tuple[Component, Process | None]] = []
        if composition is not None:
            components += [
                (t.successor or t.component, composition.container_process(t))
                for t in composition.tasks
            ]
        if elsewhere is not None:
            from colcon_yamllaunch.engine.elsewhere import in_order

            processes = in_order(
                [*processes, *elsewhere.processes()],
                elsewhere.order,
                lambda process: process.label,
            )
            components = in_order(
                [*components, *elsewhere.components()],
                elsewhere.order,
                lambda one: one[0].label,
            )
        return plan_tree(self._engine.blocks, processes, components)

    def _component(
        self, name: str
    ) -> 'tuple[Composition, ComponentTask] | None':
        """Return a component, and what loads it, if it is one."""
        composition = self._engine.composition
        if composition is not None:
            for task in composition.tasks:
                node = task.full_name or task.component.node_name
                if name in (task.label, node):
                    return composition, task
        return None

    def _refuse_component(self, name: str, what: str) -> None:
        found = self._component(name)
        if found is not None:
            composition, task = found
            container = composition.container_process(task)
            where = task.component.container
            raise RefusedError(
                f'{task.label} is a component, which cannot be {what} '
                'alone; its container is '
                f'{where if container is None else container.label}'
            )
