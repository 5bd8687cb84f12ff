# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""All parts of a launch that run on other machines; see `Elsewhere`."""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
from functools import partial
from itertools import chain
import os
import time
from typing import Any
from typing import cast

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.engine import commands
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.elsewhere import LaunchHere
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import Entry
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.remote.deployment.placement import Placed
from colcon_yamllaunch.remote.link.remote_part import Link
from colcon_yamllaunch.remote.link.remote_part import RemotePart
from colcon_yamllaunch.remote.link.remote_part import soonest

#: Seconds that figures of machines are waited for, by who asks for the state.
MEASURING = 1.0
#: Seconds after which such figures are asked for anew.
FRESH = 2.0

#: Returns what of some entries runs where.
Place = Callable[[Iterable[Entry]], Placed]
#: Returns a plan with the paths of a machine, by its name.
Localise = Callable[[str, Plan], Plan]


class RemoteParts:
    """
    Runs what a plan has on other machines.

    :param links: What leads to the machines; on each its part runs, or is
      about to
    :param placed: The plan, and what of it runs where, with the paths of this
      computer
    :param place_more: Tells where what comes later runs; without it, that is
      here
    :param localise: Returns a plan with the paths of a machine
    :param clock: Returns seconds that never go back
    :param tty: Whether each process gets a terminal
    """

    def __init__(
        self,
        links: Iterable[Link],
        placed: Placed,
        place_more: Place | None = None,
        localise: Localise = lambda _, plan: plan,
        clock: Callable[[], float] = time.monotonic,
        *,
        tty: bool = False,
    ) -> None:
        self._placed = placed
        self._place_more = place_more
        self._clock = clock
        whole = placed.whole
        labels = [process.label for process in whole.processes()]
        labels += [component.label for component in whole.components()]
        #: The place of each label in the whole plan.
        self.order = {label: place for place, label in enumerate(labels)}
        self._launch: LaunchHere | None = None
        self._parts: dict[str, RemotePart] = {}
        for link in links:
            name = link.machine.name
            self._parts[name] = RemotePart(
                link,
                placed.parts.get(name, Plan()),
                partial(localise, name),
                clock,
                tty=tty,
            )
        # those who wait for figures: until when, and how many machines
        self._measured = -FRESH
        self._measuring: list[tuple[float, set[str], Callable[[], None]]] = []
        self._is_closed = False

    @property
    def parts(self) -> Collection[RemotePart]:
        """What runs on each machine."""
        return self._parts.values()

    @property
    def pids(self) -> Collection[int]:
        """The processes of the links, children of ours."""
        return frozenset().union(*(part.link.pids for part in self.parts))

    def whole(self, plan: Plan) -> Plan:  # noqa: ARG002
        """Return the plan with all parts, as it is shown."""
        return self._placed.whole

    def begin(self, launch: LaunchHere, size: os.terminal_size) -> None:
        """Run with a launch from now on."""
        self._launch = launch
        for part in self.parts:
            part.begin(launch, size)

    def handle(self, event: events.Event) -> None:
        """Take note of what happened."""
        if isinstance(event, events.ShuttingDown):
            for part in self.parts:
                part.stop(
                    event.reason,
                    interactive=event.interactive,
                    drop_timers=False,
                )

    def advance(self) -> None:
        """Do what is due."""
        for part in self.parts:
            part.advance()
        if self._measuring:
            self._mind_measuring()

    def seconds_to_wait(self) -> float | None:
        """Return the seconds until :meth:`advance` is to be called again."""
        now = self._clock()
        return soonest(
            chain(
                (part.seconds_to_wait() for part in self.parts),
                (max(0.0, due - now) for due, _, _ in self._measuring),
            )
        )

    def is_waiting(self) -> bool:
        """Tell whether the launch is to go on, though nothing runs here."""
        launch = self._launch
        if launch is None or not launch.is_stopping:
            return any(part.is_busy for part in self.parts)
        for part in self.parts:
            part.finish()
        return not all(part.is_over for part in self.parts)

    def ended(self, pid: int, outcome: Outcome) -> None:
        """Take into account that the process of a link ended."""
        for part in self.parts:
            if pid in part.link.pids:
                part.link.ended(pid, outcome)
                return

    def drop_timers(self) -> None:
        """Wait for no timer that outlasts a shutdown."""
        for part in self.parts:
            part.stop('', interactive=False, drop_timers=True)

    def hurry(self) -> None:
        """Take the next step of stopping at once."""
        for part in self.parts:
            part.hurry()

    def suspend(self, is_suspended: bool) -> None:
        """Hold all processes, or let them go on."""
        for part in self.parts:
            part.suspend(is_suspended)

    def resize(self, size: os.terminal_size) -> None:
        """Give all terminals another size."""
        for part in self.parts:
            part.resize(size)

    def close(self) -> None:
        """End all links."""
        if not self._is_closed:
            self._is_closed = True
            for part in self.parts:
                part.close()

    def disown(self) -> None:
        """Have nothing to do with the links, in a fork of this process."""
        for part in self.parts:
            part.link.disown()

    # who and what

    def has(self, name: str) -> bool:
        """Tell whether a part of the plan runs elsewhere."""
        return self._found(name) is not None

    def part(self, name: str) -> Process | Component:
        """Return a process or component as it is planned now."""
        part, label = self._find(name)
        return part.part(label)

    def processes(self) -> Iterator[Process]:
        """Iterate over the processes as they are planned now."""
        return chain.from_iterable(p.processes() for p in self.parts)

    def components(self) -> Iterator[tuple[Component, Process | None]]:
        """Iterate over the components, with the process of the container."""
        return chain.from_iterable(p.components() for p in self.parts)

    @property
    def machines(self) -> Collection[str]:
        """The names of the machines."""
        return self._parts.keys()

    def machine_of(self, label: str) -> str | None:
        """Return the name of the machine where a part runs."""
        found = self._found(label)
        return None if found is None else found[0].machine.name

    def cpu_shares(self) -> dict[str, float]:
        """
        Return the shares of a processor that are known, by label.

        Asking has them measured anew.
        """
        if self._clock() >= self._measured + FRESH:
            self.measure(lambda: None)
        shares: dict[str, float] = {}
        for part in self.parts:
            usage = part.states.usage()
            shares |= {label: cpu for label, (cpu, _) in usage.items()}
        return shares

    def measure(self, done: Callable[[], None]) -> None:
        """
        Find out what processes use.

        :param done: Is called when that is known, as far as it is soon
        """
        self._measured = self._clock()
        waiting: set[str] = set()
        for name, part in self._parts.items():

            def answered(name: str = name) -> None:
                waiting.discard(name)
                self._mind_measuring()

            # the answer may come at once
            waiting.add(name)
            try:
                part.measure(answered)
            except RefusedError:
                waiting.discard(name)
        self._measuring.append((self._measured + MEASURING, waiting, done))
        self._mind_measuring()

    # commands about one of them

    def ask(
        self,
        command: commands.PartCommand[Any],
        reply: Callable[[Any], object],
    ) -> None:
        """Execute a command about a process or component."""
        part, label = self._find(command.process)

        def done(error: str | None) -> None:
            refused = commands.Refused(error or '')
            reply(commands.DONE if error is None else refused)

        match command:
            case commands.Describe():

                def described(answer: Mapping[str, Any] | str) -> None:
                    reply(self._described(part.part(label), answer))

                part.describe(label, described)
            case commands.ChangeState(transition=transition):
                part.change_state(label, transition, done)
            case commands.Type(keys=keys):
                self.type(label, keys)
                reply(commands.DONE)
            case _:
                part.act(cast('events.Action', command.name), label, done)

    def _described(
        self, part: Process | Component, answer: Mapping[str, Any] | str
    ) -> commands.Described | commands.Refused:
        from colcon_yamllaunch.engine.description import told_description

        if isinstance(answer, str):
            return commands.Refused(answer)
        blocks = () if self._launch is None else self._launch.blocks
        return commands.Described(told_description(part, answer, blocks, None))

    # keyboards

    def has_keyboard(self, label: str) -> bool:
        """Tell whether keys can be typed at a process now."""
        found = self._found(label)
        return found is not None and found[0].has_keyboard(found[1])

    def input_modes(self, label: str) -> int | None:
        """Return the local modes of the terminal that a process reads."""
        found = self._found(label)
        return None if found is None else found[0].input_modes(found[1])

    def attach(self, label: str) -> None:
        """Have its terminal watched, as somebody is attached to it."""
        self._send(label, 'attach')

    def detach(self, label: str) -> None:
        """Have it watched no more."""
        self._send(label, 'detach')

    def type(self, label: str, keys: bytes) -> None:
        """Type at a process."""
        # late, as few are typed at
        from base64 import b64encode

        self._send(label, 'type', keys=b64encode(keys).decode())

    # changes of the plan while it runs

    def extend(self, entries: Iterable[Entry]) -> Sequence[Entry]:
        """Take more into the plan, and return what of it runs here."""
        entries = tuple(entries)
        if self._place_more is None:
            return entries
        placed = self._place_more(entries)
        for name, plan in placed.parts.items():
            if name in self._parts:
                self._parts[name].extend(plan)
        return placed.local.entries

    def revise(self, part: Process | Component, *, at_once: bool) -> None:
        """Have a part be another one from its next start on."""
        self._find(part.label)[0].revise(part, at_once=at_once)

    def replace(self, part: Process | Component) -> None:
        """Have a part be another one, and start or load that anew."""
        self._find(part.label)[0].replace(part)

    def restart(self, labels: Collection[str]) -> tuple[str, ...]:
        """Start and load parts anew after a change; return their labels."""
        restarted = [part.restart(labels) for part in self.parts]
        return tuple(chain.from_iterable(restarted))

    def drop(self, label: str) -> None:
        """Stop or unload a part, and forget it then."""
        self._find(label)[0].drop(label)

    def forget(self, entries: Iterable[Entry]) -> Sequence[Entry]:
        """Do not do what has not been done yet; return what is not its."""
        entries = tuple(entries)
        if self._place_more is None:
            return entries
        placed = self._place_more(entries)
        for name, plan in placed.parts.items():
            if name in self._parts:
                self._parts[name].forget(plan.entries)
        return placed.local.entries

    def renew_environment(self, variables: Mapping[str, str]) -> None:
        """Leave it: each machine has an environment of its own."""

    def _mind_measuring(self) -> None:
        now = self._clock()
        waiting, self._measuring = self._measuring, []
        for due, machines, done in waiting:
            if machines and now < due:
                self._measuring.append((due, machines, done))
            else:
                done()

    def _send(self, label: str, what: str, **content: Any) -> None:
        found = self._found(label)
        if found is not None:
            found[0].send(what, label=label, **content)

    def _found(self, name: str) -> tuple[RemotePart, str] | None:
        for part in self.parts:
            label = part.label_of(name)
            if label is not None:
                return part, label
        return None

    def _find(self, name: str) -> tuple[RemotePart, str]:
        """
        Return what runs a process or component, and its label.

        :raises RefusedError: when there is none
        """
        found = self._found(name)
        if found is None:
            raise RefusedError(f"there is no process '{name}'")
        return found
