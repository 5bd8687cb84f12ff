# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What takes part in a launch beside its engine."""

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, TYPE_CHECKING

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.plan.plan import Member, Plan, Process

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.commands import Command
    from colcon_yamllaunch.engine.engine import Engine

#: Takes the response to a command.
Reply = Callable[[Any], object]
#: Executes a command; returns the response, or None if it calls `Reply` later.
Execute = Callable[['Command[Any]', Reply], Any]


class Participant:
    """
    Something that takes part in a launch beside its engine.

    For example, the watcher of `--watch`, the parts on other machines, and
    the worker that runs Python launch files. A participant listens to events,
    executes commands, and can keep the launch running. By default, it does
    nothing. No method blocks, except :meth:`failed`, :meth:`finish` and
    :meth:`close`.
    """

    def children(self) -> Collection[int]:
        """Return the child processes that it started before the launch."""
        return ()

    def whole(self, plan: Plan) -> Plan:
        """Return `plan`, which runs here, with what runs elsewhere."""
        return plan

    def join(self, engine: 'Engine') -> None:
        """Take part in the launch of `engine`, which does not run yet."""

    def begin(self) -> None:
        """Begin, as the launch runs from now on."""

    def handle(self, event: events.Event) -> None:
        """Receive an event, but no output; all of them in order."""

    def handle_output(self, event: events.Output) -> None:
        """Receive whole lines of output."""

    def record(
        self, process: Process, stream: events.Stream, data: bytes
    ) -> None:
        """Receive output as it is read, before :meth:`handle_output`."""

    def accepts(self, label: str) -> bool:  # noqa: ARG002
        """Return whether a process may write more output for now."""
        return True

    def execute(
        self, command: 'Command[Any]', reply: Reply, proceed: Execute
    ) -> Any:
        """
        Execute its share of a command.

        :param reply: Is called with the response if None is returned
        :param proceed: Executes the rest of the command on this machine
        :raises RefusedError: when it refuses the command
        """
        return proceed(command, reply)

    def call(self, number: int) -> None:
        """Call a function of a launch file; see `WorkerCall`."""

    def find(self, name: str) -> Member | None:  # noqa: ARG002
        """
        Return a member of the plan that does not run here, if it has one.

        :param name: Its label, what ROS 2 calls the process, or the full name
          of the component's node
        """
        return None

    def measure(self, done: Callable[[], None]) -> None:
        """Measure the resource usage of its processes, and call `done`."""
        done()

    def cpu_shares(self) -> Mapping[str, float]:
        """Return the shares of a processor of its processes, by label."""
        return {}

    def end_turn(self) -> None:
        """Do what is due at the end of a turn of the loop."""

    def prepare_end(self) -> bool:
        """
        Prepare for the end of the launch, as no process runs.

        It is called before the launch begins to end, and while it ends, and
        only if no participant before it has to go on.

        :return: Whether the launch must go on for now
        """
        return False

    def failed(self, error: Exception) -> None:
        """Report to others that the launch cannot run."""

    def finish(self) -> None:
        """Report the end of the launch to others, after the last event."""

    def close(self) -> None:
        """End the processes that it has started, and wait for that."""


def overridden(participants: Iterable[Participant], name: str) -> list[Any]:
    """Return the methods `name` of those that have one of their own."""
    default = getattr(Participant, name)
    return [
        getattr(participant, name)
        for participant in participants
        if getattr(type(participant), name) is not default
    ]
