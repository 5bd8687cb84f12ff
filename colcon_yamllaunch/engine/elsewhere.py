# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What a launch needs of parts that run on other machines, and these of it.

An :class:`Elsewhere` is beside the engine of the launch that a user has
started. A :class:`Companion` is beside the engine of a part of it, on the
machine where that runs. What lies between the two is their own affair.
"""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
import os
from typing import Protocol
from typing import TypeVar

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.commands import PartCommand
from colcon_yamllaunch.engine.commands import Refused
from colcon_yamllaunch.engine.commands import Response
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.moment import Moment
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.plan import Block
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import Entry
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process

_Part = TypeVar('_Part')
#: Takes None when something has been done or begun, or else why it was not.
Done = Callable[[str | None], None]


def in_order(
    parts: Iterable[_Part],
    order: Mapping[str, int],
    label_of: Callable[[_Part], str],
) -> list[_Part]:
    """
    Return parts of several machines in the order of the whole plan.

    :param order: See `Elsewhere.order`
    """
    last = len(order)
    return sorted(parts, key=lambda part: order.get(label_of(part), last))


class LaunchHere(Protocol):
    """The launch that was started here, to what runs its other parts."""

    #: What the loop of the launch waits for.
    loop: Loop

    @property
    def blocks(self) -> tuple[Block, ...]:
        """The launch files, groups and timers that parts stand in."""

    @property
    def moment(self) -> Moment:
        """When what is told happened."""

    @property
    def is_stopping(self) -> bool:
        """Whether everything is being stopped."""

    def tell(self, event: events.Event) -> None:
        """Tell everybody who listens what happened."""

    def take_output(
        self, process: Process, stream: events.Stream, data: bytes
    ) -> None:
        """Take what a process wrote, as if it had been read here."""

    def end_lines(self, label: str) -> None:
        """Take the last line of a process as whole, as the process ended."""

    def check_conditions(self) -> None:
        """Stop the launch if a condition is met or something failed."""

    def echo(self, label: str, data: bytes) -> None:
        """Show who is attached to a process what its terminal echoed."""

    def accepts(self, key: tuple[str, events.Stream]) -> bool:
        """Tell whether a process, by its label, may write more to a stream."""

    def shut_down(self, reason: str) -> None:
        """Begin to end the launch, as an entry of its plan would."""

    def guard_group(self, group: int) -> None:
        """Have a process group ended with the launch, however that ends."""

    def release_group(self, group: int) -> None:
        """Take into account that nothing of a process group runs."""


class Elsewhere(Protocol):
    """
    The parts of a launch that run on other machines.

    It is told all events in order, those that it has told itself, too. None
    of its methods waits, but the last. Processes and components are known by
    their labels, which are unique over all machines.
    """

    @property
    def pids(self) -> Collection[int]:
        """The processes that it has started, children of ours."""

    def whole(self, plan: Plan) -> Plan:
        """
        Return the plan with all parts, as it is shown.

        :param plan: The part of it that runs here
        """

    def begin(self, launch: LaunchHere, size: os.terminal_size) -> None:
        """
        Run with a launch from now on.

        :param size: Of the terminal that processes are to have
        """

    def handle(self, event: events.Event) -> None:
        """Take note of what happened."""

    def advance(self) -> None:
        """Do what is due; is called once a turn."""

    def seconds_to_wait(self) -> float | None:
        """Return the seconds until :meth:`advance` is to be called again."""

    def is_waiting(self) -> bool:
        """
        Tell whether the launch is to go on, though nothing runs here.

        While it is being stopped, that is until all machines are done.
        """

    def ended(self, pid: int, outcome: Outcome) -> None:
        """Take into account that one of its processes ended."""

    # what concerns everything

    def drop_timers(self) -> None:
        """Wait for no timer that outlasts a shutdown."""

    def hurry(self) -> None:
        """Take the next step of stopping at once."""

    def suspend(self, is_suspended: bool) -> None:
        """
        Hold all processes, or let them go on.

        That has left this machine on return, as this one may be held next.
        """

    def resize(self, size: os.terminal_size) -> None:
        """Give all terminals another size."""

    def close(self) -> None:
        """End all that it has started, and wait for that."""

    # who and what

    @property
    def order(self) -> Mapping[str, int]:
        """The place of each label in the whole plan; later ones are last."""

    def has(self, name: str) -> bool:
        """
        Tell whether a part of the plan runs elsewhere.

        :param name: Its label, what ROS 2 calls it, or the full name of the
          node of a component
        """

    def part(self, name: str) -> Process | Component:
        """
        Return a process or component as it is planned now.

        :param name: As for :meth:`has`
        :raises RefusedError: when there is none
        """

    def cpu_shares(self) -> Mapping[str, float]:
        """Return the shares of one processor, by label, as far as known."""

    def measure(self, done: Callable[[], None]) -> None:
        """
        Find out what processes use, to have it in their states.

        :param done: Is called when that is known, as far as it is soon
        """

    @property
    def machines(self) -> Iterable[str]:
        """The names of the machines."""

    def machine_of(self, label: str) -> str | None:
        """Return the name of the machine where a part runs, if elsewhere."""

    def processes(self) -> Iterable[Process]:
        """Return the processes as they are planned now."""

    def components(self) -> Iterable[tuple[Component, Process | None]]:
        """Return the components, with the process of their container."""

    def ask(
        self,
        command: PartCommand[Response],
        reply: Callable[[Response | Refused], object],
    ) -> None:
        """
        Execute a command about a process or component.

        :param reply: Is called with the response, at once or later
        :raises RefusedError: when it is refused at once
        """

    # keyboards

    def has_keyboard(self, label: str) -> bool:
        """Tell whether keys can be typed at a process now."""

    def input_modes(self, label: str) -> int | None:
        """Return the local modes of the terminal that a process reads."""

    def attach(self, label: str) -> None:
        """Have its terminal watched, as somebody is attached to it."""

    def detach(self, label: str) -> None:
        """Have it watched no more."""

    def type(self, label: str, keys: bytes) -> None:
        """Type at a process."""

    # changes of the plan while it runs, see `plan_changes.RunningLaunch`

    def extend(self, entries: Iterable[Entry]) -> Sequence[Entry]:
        """
        Take more into the plan, and return what of it runs here.

        :raises ValueError: when a label is taken
        """

    def revise(self, part: Process | Component, *, at_once: bool) -> None:
        """Have a part be another one from its next start on."""

    def replace(self, part: Process | Component) -> None:
        """Have a part be another one, and start or load that anew."""

    def restart(self, labels: Collection[str]) -> tuple[str, ...]:
        """
        Start and load parts anew after a change; return their labels.

        Those that run here are passed over.
        """

    def drop(self, label: str) -> None:
        """Stop or unload a part, and forget it then."""

    def forget(self, entries: Iterable[Entry]) -> Sequence[Entry]:
        """Do not do what has not been done yet; return what is not its."""

    def renew_environment(self, variables: Mapping[str, str]) -> None:
        """Give processes that start from now on other variables."""


class Companion(Protocol):
    """
    What is beside the engine of a part that runs for another machine.

    It is told all events in order, after all others. None of its methods
    waits, but the last. See `launch_companion` for what it is given.
    """

    def handle(self, event: events.Event) -> None:
        """Take note of what happened."""

    def record(
        self, process: Process, stream: events.Stream, data: bytes
    ) -> None:
        """Take output of a process as it was read, before it is told."""

    def echoed(self, label: str, data: bytes) -> None:
        """Take what the terminal of a process echoed of what was typed."""

    def accepts(self, label: str) -> bool:
        """Tell whether a process may write more for now."""

    def advance(self) -> None:
        """Do what is due; is called once a turn."""

    def seconds_to_wait(self) -> float | None:
        """Return the seconds until :meth:`advance` is to be called again."""

    def is_waiting(self) -> bool:
        """
        Tell whether the part is to go on; see `supervisor.Host`.

        It is asked only while nothing runs and nothing is due, so that the
        part is idle whenever it is asked.
        """

    def over(self, exit_code: int) -> None:
        """
        Take into account that the part has come to its end.

        :param exit_code: As :func:`run_plan` returns it next
        """
