# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A plan divided into the parts of this computer and of other machines."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field, replace
import shlex

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.deployment.applied_settings import AppliedSettings
from colcon_yamllaunch.deployment.deployment import Deployment, ProcessRule
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.plan.labels import MACHINE_SEPARATOR
from colcon_yamllaunch.plan.plan import (
    AfterReady,
    changed_entries,
    ChangeState,
    Component,
    Entry,
    Member,
    Plan,
    Process,
    SignalProcess,
    Timer,
)


@dataclass(frozen=True, slots=True)
class PlacedPlan:
    """
    A plan and its parts.

    :param whole: The plan with the labels of the launch
    :param local: The part that runs here
    :param parts: The parts of other machines, by the names of these
    :param machines: The machines of the processes and components that run
      elsewhere, by label
    """

    whole: Plan
    local: Plan
    parts: Mapping[str, Plan] = field(default_factory=dict)
    machines: Mapping[str, str] = field(default_factory=dict)

    def part(self, machine: str) -> Plan:
        """Return the part of a machine."""
        return self.parts.get(machine) or Plan((), self.whole.blocks)


def place(plan: Plan, deployment: Deployment) -> PlacedPlan:
    """Divide a plan into its parts."""
    return Placer(deployment).place(plan)


class Placer:
    """
    Divides a plan into parts, and later the entries that are added to it.

    The machine of a container, process or node also holds for entries that
    are added later.
    """

    def __init__(self, deployment: Deployment) -> None:
        self._deployment = deployment
        self._settings = AppliedSettings(deployment)
        self._processes: dict[str, Process] = {}
        # the machines by the ROS name of a process, and by the name of a node
        self._by_process: dict[str, str | None] = {}
        self._by_node: dict[str, str | None] = {}

    def place(self, plan: Plan) -> PlacedPlan:
        """
        Divide a plan into its parts; each has all blocks.

        All paths are those of this computer; see `RemotePaths`.

        :param plan: The plan, or entries that are added to it; labels may
          have the names of machines already
        """
        self._learn(plan)
        entries = changed_entries(plan.entries, self._labelled)
        whole = self._settings.apply(replace(plan, entries=entries))
        cut: dict[str | None, list[Entry]] = {}
        for entry in whole.entries:
            for machine, part in self._cut(entry).items():
                cut.setdefault(machine, []).append(part)
        return PlacedPlan(
            whole,
            replace(plan, entries=tuple(cut.get(None, ()))),
            {
                name: Plan(tuple(cut[name]), plan.blocks, (), plan.left_open)
                for name in self._deployment.machines
                if name in cut
            },
            {
                member.label: machine
                for member in whole.members()
                if (machine := self.machine_of(member)) is not None
            },
        )

    def place_more(self, entries: Iterable[Entry]) -> PlacedPlan:
        """Divide entries that are added to the plan while it runs."""
        return self.place(Plan(tuple(entries)))

    def machine_of(self, entry: Entry) -> str | None:
        """
        Return the machine of an entry, None for here.

        Messages, the end of the launch and calls of Python are always here;
        a timer is divided like its entries.
        """
        everything_on = self._deployment.everything_on
        match entry:
            case Process():
                return self._by_process.get(entry.ros_name, everything_on)
            case Component():
                return self._by_node.get(entry.container, everything_on)
            case ChangeState():
                return self._by_node.get(entry.node, everything_on)
            case SignalProcess():
                return self._by_process.get(entry.process, everything_on)
            case _:
                return None

    def _learn(self, plan: Plan) -> None:
        processes = list(plan.processes())
        for process in processes:
            self._processes[process.ros_name] = process
        known = list(self._processes.values())
        machines = self._deployment.machines_of(known)
        for process, machine in zip(known, machines, strict=True):
            # a running process stays where it is
            placed = self._placed(process.label) or machine
            self._by_process.setdefault(process.ros_name, placed)
        for process in processes:
            if process.node_name is not None:
                machine = self._by_process[process.ros_name]
                self._by_node.setdefault(process.node_name, machine)
        for component in plan.components():
            if component.node_name is not None:
                machine = self.machine_of(component)
                self._by_node.setdefault(component.node_name, machine)

    def _placed(self, label: str) -> str | None:
        """Return the machine that a label names, None for a plain label."""
        name, separator, _ = label.partition(MACHINE_SEPARATOR)
        return (
            name if separator and name in self._deployment.machines else None
        )

    def _cut(self, entry: Entry) -> Mapping[str | None, Entry]:
        """Return the parts of an entry by their machines."""
        if not isinstance(entry, Timer | AfterReady):
            return {self.machine_of(entry): entry}
        cut: dict[str | None, list[Entry]] = {}
        for inner in entry.entries:
            for machine, part in self._cut(inner).items():
                cut.setdefault(machine, []).append(part)
        return {
            machine: replace(entry, entries=tuple(part))
            for machine, part in cut.items()
        } or {None: entry}

    def _labelled(self, entry: Entry) -> Entry:
        """Return an entry with the labels of the launch."""
        machine = self.machine_of(entry)
        if (
            machine is None
            or not isinstance(entry, Member)
            or self._placed(entry.label) is not None
            or self._deployment.everything_on is not None
        ):
            return entry
        if isinstance(entry, Process):
            # its ROS name does not depend on the machine
            entry = replace(entry, name=entry.ros_name)
        label = f'{machine}{MACHINE_SEPARATOR}{entry.label}'
        return replace(entry, label=label)


def rules_in_vain(plan: Plan, deployment: Deployment) -> Iterator[Diagnostic]:
    """
    Return warnings about rules that match no member of a plan.

    A rule that sets something for processes may also match components, which
    run where their containers do.

    :param plan: The whole plan; labels may have the names of machines
    """
    if plan.worker_position is not None:
        # they may match a process that is added later
        return
    processes = list(plan.processes())
    components = list(plan.components())
    for rule in deployment.rules:
        has_settings = bool(rule.settings)
        members: list[Member] = [*processes]
        if has_settings:
            members += components
        if not rule.selected(members):
            what = 'process or component' if has_settings else 'process'
            yield Diagnostic(
                'warning',
                f"no {what} of the launch is meant by '{rule}'",
                rule.position,
                _fix_for(rule, members, () if has_settings else components),
                rule.length,
            )


def _fix_for(
    rule: ProcessRule,
    members: Sequence[Member],
    components: Sequence[Component],
) -> str:
    """
    Return what may be wrong with a rule that matches nothing.

    :param members: What it could match
    :param components: What it cannot match
    """
    from colcon_yamllaunch.common.suggestions import did_you_mean

    for component in components:
        words = {
            component.label,
            component.node_name,
            component.package,
            component.plugin,
        }
        if not words.isdisjoint({rule.name, rule.package, rule.executable}):
            return (
                f'{component.label} is a component: it runs where its '
                f'container {component.container} does'
            )
    names = {member.label for member in members}
    names |= {m.node_name for m in members if m.node_name is not None}
    if rule.package is not None:
        names = {m.package for m in members if m.package is not None}
    meant = did_you_mean(str(rule.name or rule.package), names)
    return meant or 'the names of all are shown by --plan'


def placement_to_text(placed: PlacedPlan, deployment: Deployment) -> str:
    """Return the machines and what runs on each, as lines for the user."""
    lines = ['machines:']
    for name, machine in deployment.machines.items():
        words = shlex.join(machine.words)
        kind = '' if machine.kind == 'connect' else machine.kind
        facts = [f'{kind} {words}'.strip()]
        if machine.workspace is not None:
            facts.append(f'workspace {machine.workspace}')
        if machine.sync != 'build':
            facts.append(f'sync {machine.sync}')
        if machine.on_lost != 'stop':
            facts.append(f'on_lost {machine.on_lost}')
        if machine.lost_after is not None:
            facts.append(f'lost_after {machine.lost_after:g}')
        facts.append(_amount(placed.part(name)))
        lines.append(f'    {name}: {", ".join(facts)}')
    lines.append(f'    here: {_amount(placed.local)}')
    return '\n'.join(map(one_line, lines))


def _amount(plan: Plan) -> str:
    """Return how many processes and components a plan has."""
    counts = [
        (sum(1 for _ in plan.processes()), 'process', 'processes'),
        (sum(1 for _ in plan.components()), 'component', 'components'),
    ]
    said = [
        f'{count} {one if count == 1 else many}'
        for count, one, many in counts
        if count
    ]
    return ' and '.join(said) or 'nothing'
