# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The difference between the running plan and a new one.

An edit may move a node to another line or file, and so change the numbers in
the names of ROS 2. So nodes of both plans are matched by their content, and
keep their labels and names.
"""

from collections import Counter
from collections.abc import (
    Callable,
    Collection,
    Hashable,
    Iterable,
    Iterator,
    Mapping,
)
from dataclasses import replace
from typing import Any

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.plan.labels import machine_of
from colcon_yamllaunch.plan.member_settings import (
    is_same_settings,
    MemberSettings,
)
from colcon_yamllaunch.plan.plan import (
    AfterReady,
    changed_entries,
    ChangeState,
    Component,
    Entry,
    Member,
    ParameterFile,
    Plan,
    Process,
    SetParameter,
    SignalProcess,
    Timer,
    WorkerCall,
)

#: Tells what something is known by; None for what is not to be known by that.
_Key = Callable[[Any], Hashable]


@dataclass(frozen=True, slots=True)
class PlanDifference:
    """
    The difference between the running plan and a new one.

    :param plan: The new plan, with the labels and names of the running one
    :param gone: The labels of processes and components that only the running
      plan has
    :param new: The entries that only the new plan has, in order; a timer has
      only its new entries
    :param dropped: Other entries that only the running plan has: messages,
      shutdowns, requests
    :param differs: The labels of those that are started or loaded otherwise,
      in order
    :param same: The labels of all others
    :param revised: Those of `same` that wait for others, are ready or restart
      otherwise
    """

    plan: Plan
    gone: tuple[str, ...] = ()
    new: tuple[Entry, ...] = ()
    dropped: tuple[Entry, ...] = ()
    differs: tuple[str, ...] = ()
    same: tuple[str, ...] = ()
    revised: tuple[str, ...] = ()

    @property
    def is_empty(self) -> bool:
        """Whether nothing changes."""
        return not (
            self.gone
            or self.new
            or self.dropped
            or self.differs
            or self.revised
        )


def plan_difference(
    old: Plan, new: Plan, taken: Collection[str] = ()
) -> PlanDifference:
    """
    Compare the plan that runs with another one.

    :param taken: Labels and names that nothing new may have, besides those
      that the old plan has
    """
    kept = {
        entry.ros_name: earlier
        for earlier, entry in (
            *_matches(old.processes(), new.processes(), _PROCESS_KEYS),
            *_matches(old.components(), new.components(), _COMPONENT_KEYS),
        )
    }
    before = tuple(old.members())
    plan, labels = _relabelled(new, kept, before, taken)
    by_label = {entry.label: entry for entry in before}
    differs: list[str] = []
    same: list[str] = []
    revised: list[str] = []
    for entry in plan.walk():
        if isinstance(entry, Member) and entry.label in by_label:
            earlier = by_label[entry.label]
            is_same = _content(earlier) == _content(entry)
            (same if is_same else differs).append(entry.label)
            if is_same and not is_same_settings(
                earlier.settings, entry.settings
            ):
                revised.append(entry.label)
    stays = {*differs, *same}
    old_others = list(_others(old.entries))
    others = Counter(key for key, _ in old_others)
    fresh = tuple(_new(plan.entries, labels, others))
    # what is left of them is in the old plan only
    dropped = []
    for key, other in reversed(old_others):
        if others[key] > 0:
            others[key] -= 1
            dropped.append(other)
    return PlanDifference(
        plan,
        tuple(entry.label for entry in before if entry.label not in stays),
        fresh,
        tuple(reversed(dropped)),
        tuple(differs),
        tuple(same),
        tuple(revised),
    )


def _matches(
    old: Iterable[Member], new: Iterable[Member], keys: Iterable[_Key]
) -> Iterator[tuple[Member, Member]]:
    """Iterate over the entries in both plans, as pairs."""
    old, new = list(old), list(new)
    for key in keys:
        waiting: dict[Hashable, list[Member]] = {}
        for one in reversed(old):
            # what runs on a machine is none that runs on another one
            place = machine_of(one.label), key(one)
            waiting.setdefault(place, []).append(one)
        matched: set[str] = set()
        left = []
        for other in new:
            known_by = key(other)
            same = waiting.get((machine_of(other.label), known_by))
            if known_by is None or not same:
                left.append(other)
                continue
            one = same.pop()
            matched.add(one.label)
            yield one, other
        old = [one for one in old if one.label not in matched]
        new = left


def _relabelled(
    new: Plan,
    kept: Mapping[str, Member],
    before: Iterable[Member],
    taken: Collection[str],
) -> tuple[Plan, set[str]]:
    """
    Return a plan with the labels that it is to have, and those new in it.

    :param kept: What stays, by the names in the new plan
    """
    used = {*taken}
    for entry in before:
        used |= {entry.label, entry.ros_name}
    names: dict[str, str] = {}
    labels: dict[str, str] = {}
    fresh = set()
    # what settings name
    final: dict[str, str] = {}
    for entry in new.members():
        key = entry.ros_name
        if key in kept:
            names[key], labels[key] = kept[key].ros_name, kept[key].label
            final[entry.label] = labels[key]
            continue
        name = _free(key, used) if isinstance(entry, Process) else key
        machine = machine_of(entry.label)
        label = entry.label if entry.label != machine + key else machine + name
        if label in used:
            label = machine + name
        if label in used:
            label = _free(label, used)
        if isinstance(entry, Component):
            name = label
        used |= {name, label}
        names[key], labels[key] = name, label
        final[entry.label] = label
        fresh.add(label)

    def with_name(entry: Entry) -> Entry:
        match entry:
            case Process():
                key = entry.ros_name
                name = None if entry.name is None else names[key]
                settings = _with_labels(entry.settings, final)
                final_names = labels[key], name, settings
                if (entry.label, entry.name, entry.settings) == final_names:
                    return entry
                return replace(
                    entry, label=labels[key], name=name, settings=settings
                )
            case Component():
                return replace(
                    entry,
                    label=labels[entry.ros_name],
                    settings=_with_labels(entry.settings, final),
                )
            case SignalProcess():
                name = names.get(entry.process, entry.process)
                return replace(entry, process=name)
            case _:
                return entry

    handlers = tuple(
        replace(
            handler,
            processes=tuple(names.get(n, n) for n in handler.processes),
        )
        for handler in new.handlers
    )
    entries = _awaiting(changed_entries(new.entries, with_name), final)
    return replace(new, entries=entries, handlers=handlers), fresh


def _with_labels(
    settings: MemberSettings | None, labels: Mapping[str, str]
) -> MemberSettings | None:
    """Return settings with other labels of the processes that they name."""
    if settings is None:
        return None
    restart = settings.restart
    if restart is not None:
        together = tuple(labels.get(n, n) for n in restart.together)
        restart = replace(restart, together=together)
    after = tuple(labels.get(n, n) for n in settings.after)
    return replace(settings, after=after, restart=restart)


def _awaiting(
    entries: Iterable[Entry], labels: Mapping[str, str]
) -> tuple[Entry, ...]:
    """Return entries with other labels of what they wait for."""
    found: list[Entry] = []
    for entry in entries:
        match entry:
            case Timer():
                inner = _awaiting(entry.entries, labels)
                found.append(replace(entry, entries=inner))
            case AfterReady():
                inner = _awaiting(entry.entries, labels)
                names = tuple(labels.get(n, n) for n in entry.labels)
                found.append(AfterReady(names, inner))
            case _:
                found.append(entry)
    return tuple(found)


def _free(name: str, used: Collection[str]) -> str:
    """Return a name that is not used, by counting on as ROS 2 does."""
    stem, dash, number = name.rpartition('-')
    if not dash or not number.isdecimal():
        stem, number = name, '1'
    count = int(number)
    while name in used:
        count += 1
        name = f'{stem}-{count}'
    return name


def _new(
    entries: Iterable[Entry],
    labels: Collection[str],
    others: Counter[Hashable],
    periods: tuple[float, ...] = (),
) -> Iterator[Entry]:
    """
    Iterate over what is new among entries.

    :param labels: Those of what is new
    :param others: What was there already, which is counted down
    """
    for entry in entries:
        if isinstance(entry, Member):
            if entry.label in labels:
                yield entry
        elif isinstance(entry, Timer):
            inside = (*periods, entry.period)
            inner = tuple(_new(entry.entries, labels, others, inside))
            if inner:
                yield replace(entry, entries=inner)
        elif isinstance(entry, AfterReady):
            inner = tuple(_new(entry.entries, labels, others, periods))
            if inner:
                yield replace(entry, entries=inner)
        else:
            key = _other_content(entry, periods)
            others[key] -= 1
            if others[key] < 0:
                yield entry


def _others(
    entries: Iterable[Entry], periods: tuple[float, ...] = ()
) -> Iterator[tuple[Hashable, Entry]]:
    """Iterate over entries without a label, with their keys."""
    for entry in entries:
        if isinstance(entry, Timer):
            yield from _others(entry.entries, (*periods, entry.period))
        elif isinstance(entry, AfterReady):
            yield from _others(entry.entries, periods)
        elif not isinstance(entry, Member):
            yield _other_content(entry, periods), entry


def _other_content(entry: Entry, periods: tuple[float, ...]) -> Hashable:
    match entry:
        case ChangeState():
            return periods, 'state', entry.node, entry.transition
        case SignalProcess():
            return periods, 'signal', entry.process, entry.signal
        case WorkerCall():
            # another worker has other numbers
            return periods, 'call', entry.title, entry.position.path
        case _:
            return periods, entry


def _content(entry: Member) -> Hashable:
    """Return all that determines how an entry is started or loaded."""
    if isinstance(entry, Process):
        return _process_content(entry)
    return _component_content(entry)


def _process_content(process: Process) -> Hashable:
    argv = tuple(
        ('file', word.content) if isinstance(word, ParameterFile) else word
        for word in process.argv
    )
    settings = process.settings
    # the other settings apply to a process that runs
    limits = settings and (settings.limits, settings.user)
    return (
        *(argv, process.cwd, process.environment, process.emulate_tty),
        None if limits == (None, '') else limits,
        *(process.package, process.node_name, process.is_container),
        *(process.is_lifecycle, process.autostart),
    )


def _component_content(component: Component) -> Hashable:
    return (
        *(component.package, component.plugin, component.container),
        *(component.name, component.namespace, component.remaps),
        _values(component.parameters),
        _values(component.extra_arguments),
        *(component.is_lifecycle, component.autostart),
    )


def _values(parameters: Iterable[SetParameter]) -> Hashable:
    return tuple((one.name, one.value) for one in parameters)


def _program(process: Process) -> Hashable:
    # without the number, which counts all processes
    name = process.ros_name.rpartition('-')[0] or process.ros_name
    return name, process.package, process.node_name


#: What stays is known by the first of these that fits; nodes of other names
#: are others.
_PROCESS_KEYS: tuple[_Key, ...] = (
    lambda p: (_process_content(p), p.position),
    _process_content,
    lambda p: p.node_name and (_program(p), p.position),
    lambda p: p.node_name and _program(p),
    lambda p: p.node_name,
    lambda p: (_program(p), p.position),
    lambda p: (_program(p), p.position.path),
    _program,
)
_COMPONENT_KEYS: tuple[_Key, ...] = (
    lambda c: (_component_content(c), c.position),
    _component_content,
    lambda c: c.node_name and (c.node_name, c.plugin),
    lambda c: c.node_name,
    lambda c: (c.plugin, c.container, c.namespace, c.name, c.position),
    lambda c: (c.plugin, c.container, c.namespace, c.name),
    lambda c: None if c.name else (c.plugin, c.namespace),
)
