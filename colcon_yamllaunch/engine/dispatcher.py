# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The dispatcher: executes commands on an engine, with one handler for each.

A handler takes the command and a function for the response. It returns the
response, or None if it calls that function later. Most commands have an
effect at once, and no response but `Done`. Either raises `RefusedError` if it
refuses the command.
"""

from collections.abc import Callable, Mapping
from functools import partial
import os
from typing import Any, TYPE_CHECKING

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.engine import commands
from colcon_yamllaunch.engine.commands import Command, DONE, Refused, Response
from colcon_yamllaunch.engine.loop import do_nothing
from colcon_yamllaunch.engine.participants import Execute, Reply
from colcon_yamllaunch.engine.spawn import StartError
from colcon_yamllaunch.plan.plan import Component, Member

if TYPE_CHECKING:
    # most launches have no components, and few are asked for these
    from colcon_yamllaunch.engine.composition import ComponentTask, Composition
    from colcon_yamllaunch.engine.engine import Engine

Handler = Callable[[Any, Reply], Any]


class Dispatcher:
    """
    Executes commands on an engine.

    Participants execute their share of a command before a handler does, and
    add handlers of their own.
    """

    def __init__(self, engine: 'Engine') -> None:
        self._engine = engine
        self._supervisor = engine.supervisor
        supervisor = engine.supervisor
        effects: dict[type[Command[Any]], Callable[[Any], object]] = {
            commands.Stop: self._stop,
            commands.Restart: self._restart,
            commands.Kill: self._kill,
            commands.Debug: self._debug,
            commands.Type: lambda c: engine.terminals.type(c.member, c.keys),
            commands.Watch: self._watch,
            commands.Shutdown: self._shut_down,
            commands.Escalate: lambda _: supervisor.escalate(),
            commands.Hold: lambda c: engine.hold(is_held=c.is_held),
            commands.Resize: self._resize,
            commands.Extend: self._extend,
            commands.Revise: self._revise,
            commands.Drop: self._drop,
            commands.Forget: lambda c: supervisor.forget(c.entries),
        }
        self._handlers: dict[type[Command[Any]], Handler] = {
            commands.Describe: self._describe,
            commands.ChangeState: self._change_state,
            commands.Tree: self._tree,
            commands.RestartChanged: self._restart_changed,
            **{kind: _at_once(effect) for kind, effect in effects.items()},
        }
        self._execute: Execute = self._handle
        for participant in reversed(engine.participants):
            self._execute = partial(participant.execute, proceed=self._execute)

    def add(self, kind: type[Command[Any]], handler: Handler) -> None:
        """Execute commands of a kind by a handler."""
        self._handlers[kind] = handler

    @property
    def kinds(self) -> Mapping[str, type[Command[Any]]]:
        """The commands that can be executed, by name."""
        return {kind.name: kind for kind in self._handlers}

    def ask(
        self,
        command: Command[Response],
        reply: Callable[[Response | Refused], object] = do_nothing,
    ) -> None:
        """
        Execute a command.

        :param reply: Is called with the response, at once or later
        """
        try:
            response = self._execute(command, reply)
        except RefusedError as error:
            response = Refused(str(error))
        if response is not None:
            reply(response)

    def do(self, command: Command[Response]) -> Response:
        """
        Execute a command that does not take time, and return the response.

        :raises RefusedError: when it is refused
        """
        response: Response = self._execute(command, do_nothing)
        return response

    def _handle(self, command: Command[Any], reply: Reply) -> Any:
        return self._handlers[type(command)](command, reply)

    # -- commands about one process or component

    def _stop(self, command: commands.Stop) -> None:
        if found := self._component(command.member):
            composition, task = found
            composition.unload(task.label)
        else:
            self._supervisor.stop_process(command.member)

    def _restart(self, command: commands.Restart) -> None:
        if found := self._component(command.member):
            composition, task = found
            composition.reload(task.label)
        else:
            self._supervisor.restart_process(command.member)

    def _kill(self, command: commands.Kill) -> None:
        self._refuse_component(command.member, 'killed')
        self._supervisor.kill_process(command.member)

    def _debug(self, command: commands.Debug) -> None:
        from colcon_yamllaunch.engine.debugging import debugged

        self._refuse_component(command.member, 'debugged')
        task = self._supervisor.task(command.member)
        process = task.successor or task.process
        environment = self._engine.starter.environment_of(process)
        once = debugged(process, environment, command.port)
        self._supervisor.restart_process(command.member, once)

    def _describe(
        self, command: commands.Describe, _: Reply
    ) -> commands.Described:
        from colcon_yamllaunch.engine.description import described

        engine = self._engine
        member: Member
        argv: list[str] = []
        if found := self._component(command.member):
            component = found[1]
            member = component.successor or component.component
            node, parameters = component.full_name, member.parameters
        else:
            task = self._supervisor.task(command.member)
            member = task.successor or task.process
            node, parameters = None, tuple(engine.parameters_of(member))
            try:
                argv = engine.starter.command_line(task.number, member)
            except StartError as error:
                raise RefusedError(f'{member.label}: {error}') from error
        log = engine.state.log_of(engine.state.by_label[member.label])
        return commands.Described(
            described(member, node, parameters, engine.blocks, log, argv)
        )

    def _change_state(
        self, command: commands.ChangeState, reply: Reply
    ) -> None:
        composition = self._engine.composition
        if composition is None:
            raise RefusedError(
                f"there is no lifecycle node '{command.member}'"
            )

        def done(error: str | None) -> None:
            reply(DONE if error is None else Refused(error))

        composition.change_state(command.member, command.transition, done)

    # -- commands about the whole launch

    def _tree(self, _: commands.Tree, _reply: Reply) -> commands.PlanTree:
        from colcon_yamllaunch.engine.description import plan_tree

        return commands.PlanTree(
            plan_tree(
                self._engine.blocks,
                self._engine.planned_processes(),
                self._engine.planned_components(),
            )
        )

    def _watch(self, _: commands.Watch) -> None:
        raise RefusedError('no files are watched; that is --watch')

    def _shut_down(self, command: commands.Shutdown) -> None:
        self._supervisor.stop(
            command.reason,
            interactive=command.interactive,
            drop_timers=command.drop_timers,
        )

    def _resize(self, command: commands.Resize) -> None:
        size = os.terminal_size((command.columns, command.lines))
        self._engine.resize(size)

    # -- changes of the plan

    def _extend(self, command: commands.Extend) -> None:
        more = self._engine.planned(command.entries)
        if not self._supervisor.is_stopping:
            self._engine.expect(more)
        try:
            self._supervisor.extend(more)
        except ValueError as error:
            raise RefusedError(str(error)) from error

    def _revise(self, command: commands.Revise) -> None:
        member = command.member
        if isinstance(member, Component):
            self._composition_of(member.label).revise(member)
            self._supervisor.hold_again(member)
        else:
            for process in self._engine.planned((member,)).processes():
                self._supervisor.revise(process, at_once=command.at_once)

    def _restart_changed(
        self, command: commands.RestartChanged, _: Reply
    ) -> commands.Restarted:
        labels, composition = {*command.labels}, self._engine.composition
        if composition is None:
            return commands.Restarted(self._supervisor.restart_changed(labels))
        # a container that has crashed is needed, too
        labels.update(composition.ended_containers(labels))
        restarted = self._supervisor.restart_changed(labels)
        reloaded = composition.reload_changed(labels, restarted)
        return commands.Restarted((*restarted, *reloaded))

    def _drop(self, command: commands.Drop) -> None:
        label = command.label
        if any(t.process.label == label for t in self._supervisor.tasks):
            self._supervisor.drop(label)
        else:
            self._composition_of(label).drop(label)

    # -- components

    def _composition_of(self, label: str) -> 'Composition':
        composition = self._engine.composition
        if composition is None:
            raise RefusedError(f"there is no component '{label}'")
        return composition

    def _component(
        self, name: str
    ) -> 'tuple[Composition, ComponentTask] | None':
        """Return a component, and what loads it, if `name` is one."""
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


def _at_once(effect: Callable[[Any], object]) -> Handler:
    """Return a handler that calls `effect`, and responds that it is done."""

    def handle(command: Any, _: Reply) -> Any:
        effect(command)
        return DONE

    return handle
