# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""All parts of a launch that run on other machines."""

from collections.abc import Callable, Collection, Iterable
from dataclasses import replace
from functools import partial
from itertools import chain
import os
from typing import Any

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.deployment.placement import PlacedPlan
from colcon_yamllaunch.engine import commands, events
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.participants import Execute, Participant, Reply
from colcon_yamllaunch.engine.terminals import Keyboards
from colcon_yamllaunch.plan.plan import Entry, Member, Plan
from colcon_yamllaunch.remote.machine_link import MachineLink
from colcon_yamllaunch.remote.part_protocol import Show
from colcon_yamllaunch.remote.remote_part import RemotePart

#: Seconds that a request for the state waits for measurements of machines.
MEASURING = 1.0
#: Seconds after which they are measured again.
FRESH = 2.0

#: Returns what of some entries runs where.
PlaceEntries = Callable[[Iterable[Entry]], PlacedPlan]
#: Returns a plan with the paths of a machine, by its name.
Localise = Callable[[str, Plan], Plan]


class RemoteParts(Participant, Keyboards):
    """
    Runs the parts of a plan on other machines.

    :param links: The links to the machines
    :param placed: The plan and its parts, with the paths of this computer
    :param place_more: Places entries that are added later; without it, all
      run here
    :param localise: Returns a plan with the paths of a machine
    """

    _launch: Engine

    def __init__(
        self,
        links: Iterable[MachineLink],
        placed: PlacedPlan,
        place_more: PlaceEntries | None = None,
        localise: Localise = lambda _, plan: plan,
    ) -> None:
        self._placed = placed
        self._place_more = place_more
        whole = placed.whole
        labels = [process.label for process in whole.processes()]
        labels += [component.label for component in whole.components()]
        # the place of each label in the whole plan
        self._order = {label: place for place, label in enumerate(labels)}
        self._parts: dict[str, RemotePart] = {}
        for link in links:
            name = link.machine.name
            self._parts[name] = RemotePart(
                link,
                placed.parts.get(name, Plan()),
                partial(localise, name),
            )
        # when processes were measured last, by the clock of the loop
        self._measured = -FRESH

    @property
    def parts(self) -> Collection[RemotePart]:
        """What runs on each machine."""
        return self._parts.values()

    def children(self) -> Collection[int]:
        """Return the processes of the links, children of ours."""
        return frozenset().union(*(part.link.pids for part in self.parts))

    def whole(self, plan: Plan) -> Plan:  # noqa: ARG002
        """Return the plan with all parts, as it is shown."""
        return self._placed.whole

    def join(self, engine: Engine) -> None:
        """Connect the parts with the launch."""
        self._launch = engine
        engine.state.machine_of = self.machine_of
        engine.state.add_machines(self._parts)
        engine.terminals.elsewhere = self
        for part in self.parts:
            part.join(engine)

    def begin(self) -> None:
        """Start the parts."""
        size = self._launch.terminal_size()
        for part in self.parts:
            part.begin(size)

    def handle(self, event: events.Event) -> None:
        """Forward a shutdown of the launch to the machines."""
        if isinstance(event, events.ShuttingDown):
            for part in self.parts:
                part.stop(
                    commands.Shutdown(
                        event.reason, event.interactive, drop_timers=False
                    )
                )

    def end_turn(self) -> None:
        """Resume links, and let parts know what they wait for elsewhere."""
        for part in self.parts:
            part.end_turn()
            part.note_elsewhere()

    def prepare_end(self) -> bool:
        """Return whether the launch is to go on, though nothing runs here."""
        if not self._launch.is_stopping:
            return any(part.is_busy for part in self.parts)
        for part in self.parts:
            part.finish()
        return not all(part.is_over for part in self.parts)

    def close(self) -> None:
        """End all links."""
        for part in self.parts:
            part.close()

    def detach_fork(self) -> None:
        """Detach a fork of this process from the links."""
        for part in self.parts:
            part.link.detach_fork()

    # lookups

    def find(self, name: str) -> Member | None:
        """Return a process or component as it is planned now."""
        found = self._find_member(name)
        return None if found is None else found[0].member(found[1])

    def machine_of(self, label: str) -> str | None:
        """Return the name of the machine where a member runs."""
        found = self._find_member(label)
        return None if found is None else found[0].machine.name

    def cpu_shares(self) -> dict[str, float]:
        """
        Return the shares of a processor that are known, by label.

        They are measured again for the next call.
        """
        if self._launch.loop.time() >= self._measured + FRESH:
            self.measure(lambda: None)
        return {
            state.label: state.cpu
            for state in self._launch.state.processes
            if state.cpu is not None
        }

    def measure(self, done: Callable[[], None]) -> None:
        """
        Measure what processes use.

        :param done: Is called when all machines have answered, or after
          :data:`MEASURING` seconds
        """
        loop = self._launch.loop
        self._measured = loop.time()
        timer = loop.call_later(MEASURING, done)
        pending = {*self._parts}

        def answered(name: str) -> None:
            pending.discard(name)
            if not (pending or timer.cancelled()):
                timer.run()

        for name, part in self._parts.items():
            try:
                part.measure(partial(answered, name))
            except RefusedError:
                answered(name)

    # commands

    def execute(
        self, command: commands.Command[Any], reply: Reply, proceed: Execute
    ) -> Any:
        """Execute the share of a command that concerns machines."""
        match command:
            case commands.MemberCommand() if found := self._find_member(
                command.member
            ):
                part, label = found
                part.execute(replace(command, member=label), reply)
                return None
            case commands.Revise() if found := self._find_member(
                command.member.label
            ):
                found[0].revise(command.member, at_once=command.at_once)
                return commands.DONE
            case commands.Drop() if found := self._find_member(command.label):
                found[0].drop(command.label)
                return commands.DONE
            case commands.Extend() | commands.Forget():
                command = self._send_shares(command)
            case commands.Tree():
                return self._tree()
            case _:
                pass
        response = proceed(command, reply)
        match command:
            case commands.RestartChanged(labels=labels):
                restarted = (part.restart(labels) for part in self.parts)
                return commands.Restarted(
                    (*response.labels, *chain.from_iterable(restarted))
                )
            case commands.Shutdown(drop_timers=True):
                for part in self.parts:
                    part.stop(commands.Shutdown(''))
            case commands.Escalate():
                for part in self.parts:
                    part.escalate()
            case commands.Hold(is_held=is_held):
                # before this machine is suspended
                for part in self.parts:
                    part.suspend(is_held)
            case commands.Resize(columns=columns, lines=lines):
                for part in self.parts:
                    part.resize(os.terminal_size((columns, lines)))
            case _:
                pass
        return response

    def _send_shares(
        self, command: commands.Extend | commands.Forget
    ) -> commands.Extend | commands.Forget:
        """
        Send machines their shares of the entries; return that of here.

        :raises RefusedError: when a label is taken
        """
        if self._place_more is None:
            return command
        placed = self._place_more(command.entries)
        for name, plan in placed.parts.items():
            part = self._parts.get(name)
            if part is not None and isinstance(command, commands.Extend):
                part.extend(plan)
            elif part is not None:
                part.forget(plan)
        return replace(command, entries=placed.local.entries)

    def _tree(self) -> commands.PlanTree:
        from colcon_yamllaunch.engine.description import plan_tree

        launch, order = self._launch, self._order
        processes = chain(
            launch.planned_processes(), *(p.processes() for p in self.parts)
        )
        components = chain(
            launch.planned_components(), *(p.components() for p in self.parts)
        )
        last = len(order)
        return commands.PlanTree(
            plan_tree(
                launch.blocks,
                sorted(processes, key=lambda p: order.get(p.label, last)),
                sorted(components, key=lambda c: order.get(c[0].label, last)),
            )
        )

    # keyboards

    def has_keyboard(self, label: str) -> bool:
        """Return whether keys can be typed at a process now."""
        found = self._find_member(label)
        return found is not None and found[0].has_keyboard(found[1])

    def input_modes(self, label: str) -> int | None:
        """Return the local modes of the terminal that a process reads."""
        found = self._find_member(label)
        return None if found is None else found[0].input_modes(found[1])

    def attach(self, label: str) -> None:
        """Watch the terminal of a process, as somebody is attached to it."""
        self._send(Show(label))

    def detach(self, label: str) -> None:
        """Stop watching the terminal of a process."""
        self._send(Show(label, is_shown=False))

    def type(self, label: str, keys: bytes) -> None:
        """Type at a process."""
        self._send(commands.Type(label, keys))

    def _send(self, command: commands.MemberCommand[Any]) -> None:
        found = self._find_member(command.member)
        if found is not None:
            found[0].send(command)

    def _find_member(self, name: str) -> tuple[RemotePart, str] | None:
        for part in self.parts:
            label = part.label_of(name)
            if label is not None:
                return part, label
        return None
