# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What runs on, what ends and what begins when a launch file changes."""

from collections import Counter
from dataclasses import replace
from typing import Any

from colcon_yamllaunch.plan.labels import with_labels
from colcon_yamllaunch.plan.member_settings import (
    MemberSettings,
    ResourceLimits,
    Restart,
)
from colcon_yamllaunch.plan.plan import (
    AfterReady,
    Component,
    Entry,
    EventHandler,
    Message,
    ParameterFile,
    Plan,
    Process,
    SetParameter,
    Shutdown,
    SignalProcess,
    Timer,
)
from colcon_yamllaunch.plan.plan_difference import (
    plan_difference,
    PlanDifference,
)
from colcon_yamllaunch.plan.position import Position
from hypothesis import given, strategies
from support.random_cases import RANDOM


def node(
    program: str, name: str = '', *args: str, line: int = 1, **more: Any
) -> Process:
    return Process(
        '',
        (f'/ws/{program}', *args),
        '/ws',
        Position('demo.yaml', line, 3),
        program,
        package='arm',
        node_name=f'/{name}' if name else None,
        **more,
    )


def component(plugin: str, name: str = '', *values: int) -> Component:
    position = Position('demo.yaml', 7, 3)
    parameters = tuple(SetParameter('p', str(v), position) for v in values)
    return Component(
        plugin, 'arm', plugin, '/box', position, name, '/', (), parameters
    )


def plan(*entries: Entry, **more: Any) -> Plan:
    """Return a plan, with names as the evaluation gives them."""
    count = 0
    seen: Counter[str] = Counter()

    def named(entry: Entry) -> Entry:
        nonlocal count
        if isinstance(entry, Timer | AfterReady):
            inner = tuple(map(named, entry.entries))
            return replace(entry, entries=inner)
        if isinstance(entry, Process):
            count += 1
            name = f'{entry.name}-{count}'
            return replace(entry, label=name, name=name)
        if isinstance(entry, Component):
            seen[entry.label] += 1
            number = seen[entry.label]
            suffix = f'#{number}' if number > 1 else ''
            return replace(entry, label=entry.label + suffix)
        return entry

    return with_labels(Plan(tuple(map(named, entries)), **more))


def entry_of(found: PlanDifference, label: str) -> Process | Component:
    parts = (*found.plan.processes(), *found.plan.components())
    return next(part for part in parts if part.label == label)


def labels(entries: tuple[Entry, ...]) -> list[str]:
    return [e.label for e in entries if isinstance(e, Process | Component)]


A, B, C = node('a.py', 'a'), node('b.py', 'b'), node('c.py')


def test_moved_entry_is_the_same() -> None:
    old = plan(A, B, C)
    moved = [replace(e, position=Position('x.yaml', 9, 9)) for e in (C, B, A)]
    found = plan_difference(old, plan(*moved))
    assert found.is_empty
    assert found.same == ('c.py-3', 'b', 'a')
    assert [p.name for p in found.plan.processes()] == [
        *('c.py-3', 'b.py-2', 'a.py-1'),
    ]


def test_labels_of_what_stays_do_not_change() -> None:
    found = plan_difference(plan(C, C, A), plan(B, C, C, C, A))
    assert found.new == (
        replace(B, label='b', name='b.py-1'),
        replace(C, label='c.py-4', name='c.py-4'),
    )
    assert found.same == ('c.py-1', 'c.py-2', 'a')


def test_removed_and_changed_entries_are_found() -> None:
    found = plan_difference(plan(A, B, C), plan(node('a.py', 'a', '-x'), C))
    assert (found.gone, found.differs) == (('b',), ('a',))
    assert found.same == ('c.py-3',)
    assert entry_of(found, 'a').argv == ('/ws/a.py', '-x')


def test_unnamed_nodes_are_matched_by_position() -> None:
    old = plan(node('n', '', '1', line=1), node('n', '', '2', line=2))
    new = plan(node('n', '', '0', line=1), node('n', '', '2', line=2))
    found = plan_difference(old, new)
    assert (found.differs, found.same) == (('n-1',), ('n-2',))
    # the first one is gone, not the second one another
    found = plan_difference(old, plan(node('n', '', '2', line=1)))
    assert (found.gone, found.same) == (('n-1',), ('n-2',))


def test_renamed_node_is_a_new_node() -> None:
    found = plan_difference(plan(A), plan(node('a.py', 'other')))
    assert found.gone == ('a',)
    assert labels(found.new) == ['other']


def test_label_in_use_is_not_reused() -> None:
    # the process of that name ends while the component is loaded
    old = plan(A)
    found = plan_difference(old, plan(component('Talker', 'a')))
    assert found.gone == ('a',)
    assert labels(found.new) == ['a-2']
    found = plan_difference(plan(), plan(A), taken=('a', 'a.py-1'))
    assert labels(found.new) == ['a.py-2']


def test_changed_launcher_options_need_no_restart() -> None:
    new = node('a.py', 'a', respawn=True, output='log', sigterm_timeout=1.0)
    found = plan_difference(plan(A), plan(new))
    assert found.is_empty
    assert next(found.plan.processes()).respawn


def test_other_settings_restart_only_what_must_be() -> None:
    def deployed(entry: Process, **fields: Any) -> Process:
        position = fields.pop('position', Position('robot.yaml', 3, 5))
        return replace(entry, settings=MemberSettings(position, **fields))

    high = ResourceLimits(memory=1 << 30)
    before = plan(
        deployed(A, critical=True),
        deployed(B, after=('a',)),
        C,
    )
    moved = plan(
        deployed(A, critical=True, position=Position('robot.yaml', 9, 5)),
        deployed(B, after=('a',)),
        C,
    )
    assert plan_difference(before, moved).is_empty
    found = plan_difference(
        before,
        plan(deployed(A, limits=high), deployed(B), deployed(C, user='me')),
    )
    assert found.differs == ('a', 'c.py-3')
    assert (found.same, found.revised) == (('b',), ('b',))
    assert not found.is_empty


def test_settings_name_others_by_their_labels() -> None:
    def waiting(for_: str) -> AfterReady:
        restart = Restart('failure', together=(for_,))
        position = Position('robot.yaml', 3, 5)
        settings = MemberSettings(position, after=(for_,), restart=restart)
        return AfterReady((for_,), (replace(A, settings=settings),))

    old = plan(C, waiting('c.py-1'))
    found = plan_difference(old, plan(B, C, waiting('c.py-2')))
    assert labels(found.new) == ['b']
    assert (found.differs, found.revised) == ((), ())
    entry = found.plan.entries[-1]
    assert isinstance(entry, AfterReady)
    assert entry.labels == ('c.py-1',)
    settings = entry_of(found, 'a').settings
    assert settings is not None
    assert settings.after == ('c.py-1',)
    assert settings.restart is not None
    assert settings.restart.together == ('c.py-1',)


def test_position_of_a_parameter_does_not_matter() -> None:
    def file(text: str, line: int) -> Process:
        position = Position('demo.yaml', line, 1)
        content = ParameterFile(text, (SetParameter('p', text, position),))
        return replace(A, argv=('/ws/a.py', content))

    old = plan(file('1', 5))
    assert plan_difference(old, plan(file('1', 6))).is_empty
    assert plan_difference(old, plan(file('2', 5))).differs == ('a',)


def test_entries_of_different_machines_are_different() -> None:
    def there(*labels: str) -> Plan:
        return Plan(
            tuple(
                replace(node('a'), label=label, name=label.rpartition('│')[2])
                for label in labels
            )
        )

    old = there('here-1', 'arm│a-2', 'arm│b-3')
    found = plan_difference(old, there('arm│a-1', 'here-2'))
    assert found.gone == ('arm│b-3',)
    assert found.same == ('arm│a-2', 'here-1')
    # what is new keeps its machine, whatever it is called there
    found = plan_difference(old, there('here-1', 'gpu│a-2'))
    (new,) = found.new
    assert (new.label, new.name) == ('gpu│a-3', 'a-3')


def test_components() -> None:
    old = plan(component('X', 'x', 1), component('Y'), component('Y'))
    new = plan(component('Y'), component('X', 'x', 2), component('Z'))
    found = plan_difference(old, new)
    assert found.gone == ('Y#2',)
    assert found.differs == ('x',)
    assert found.same == ('Y',)
    assert labels(found.new) == ['Z']


def test_timer_has_only_its_new_entries() -> None:
    old = plan(A, Timer(2.0, (B, Message('INFO', 'hello'))))
    new = plan(A, Timer(2.0, (B, Timer(1.0, (C,)), Message('INFO', 'hello'))))
    found = plan_difference(old, new)
    (timer,) = found.new
    assert isinstance(timer, Timer)
    (inner,) = timer.entries
    assert isinstance(inner, Timer)
    assert labels(inner.entries) == ['c.py-3']
    assert found.same == ('a', 'b')
    # what has been started needs no timer any more
    assert plan_difference(old, plan(A, B)).same == ('a', 'b')


def test_messages_and_shutdowns_are_executed_once() -> None:
    message = Message('INFO', 'hello')
    old = plan(message, message, Timer(9.0, (Shutdown('enough'),)))
    assert plan_difference(old, old).is_empty
    new = plan(message, Timer(5.0, (Shutdown('enough'),)))
    found = plan_difference(old, new)
    assert found.new == (Timer(5.0, (Shutdown('enough'),)),)
    assert found.dropped == (message, Shutdown('enough'))


def test_references_to_processes_use_their_labels() -> None:
    position = Position('demo.yaml', 1, 1)

    def signalling(name: str) -> SignalProcess:
        return SignalProcess(name, 2, position)

    def handlers(name: str) -> tuple[EventHandler, ...]:
        return (EventHandler('exit', (name,), '', (), position),)

    old = plan(A, signalling('a.py-1'), handlers=handlers('a.py-1'))
    new = plan(B, A, signalling('a.py-2'), handlers=handlers('a.py-2'))
    found = plan_difference(old, new)
    assert labels(found.new) == ['b']
    assert len(found.new) == 1
    assert found.plan.entries[2] == signalling('a.py-1')
    assert found.plan.handlers == handlers('a.py-1')


NODES = strategies.builds(
    lambda program, name, args, line: node(program, name, *args, line=line),
    strategies.sampled_from(('a.py', 'b.py')),
    strategies.sampled_from(('', '', 'x', 'y', 'n/x')),
    strategies.lists(strategies.sampled_from('123'), max_size=1),
    strategies.integers(1, 3),
)
COMPONENTS = strategies.builds(
    lambda plugin, name, values: component(plugin, name, *values),
    strategies.sampled_from('XY'),
    strategies.sampled_from(('', 'x', 'z')),
    strategies.lists(strategies.integers(1, 2), max_size=1),
)
ENTRIES = strategies.recursive(
    NODES | COMPONENTS | strategies.just(Message('INFO', 'hello')),
    lambda inner: strategies.builds(
        Timer,
        strategies.sampled_from((1.0, 2.0)),
        strategies.lists(inner, max_size=3).map(tuple),
    ),
)
PLANS = strategies.lists(ENTRIES, max_size=6).map(lambda e: plan(*e))


def runs(of: Plan) -> list[Process | Component]:
    return [*of.processes(), *of.components()]


def what(entry: Process | Component) -> Any:
    if isinstance(entry, Process):
        return entry.argv, entry.node_name
    return entry.plugin, entry.name, entry.parameters


def new_leaves(entries: tuple[Entry, ...]) -> list[Process | Component]:
    return runs(Plan(entries))


@RANDOM
@given(PLANS, PLANS)
def test_difference_leads_to_the_new_plan(old: Plan, new: Plan) -> None:
    found = plan_difference(old, new)
    running = {e.label: what(e) for e in runs(old)}
    for label in found.gone:
        del running[label]
    for label in found.differs:
        assert running[label] != what(entry_of(found, label))
        running[label] = what(entry_of(found, label))
    for entry in new_leaves(found.new):
        assert entry.label not in {e.label for e in runs(old)}
        running[entry.label] = what(entry)
    assert running == {e.label: what(e) for e in runs(found.plan)}
    assert Counter(map(what, runs(found.plan))) == Counter(
        map(what, runs(new))
    )


@RANDOM
@given(PLANS, PLANS)
def test_difference_starts_only_what_is_needed(old: Plan, new: Plan) -> None:
    found = plan_difference(old, new)
    both = Counter(map(what, runs(old))) & Counter(map(what, runs(new)))
    assert len(found.same) == both.total()


@RANDOM
@given(PLANS, PLANS)
def test_labels_and_names_are_unique(old: Plan, new: Plan) -> None:
    found = plan_difference(old, new)
    for names in (
        [e.label for e in runs(found.plan)],
        [e.ros_name for e in runs(found.plan)],
    ):
        assert len(set(names)) == len(names)
    then = {e.label: e.ros_name for e in runs(old)}
    for entry in runs(found.plan):
        assert then.get(entry.label, entry.ros_name) == entry.ros_name


@RANDOM
@given(PLANS, PLANS)
def test_second_difference_is_empty(old: Plan, new: Plan) -> None:
    found = plan_difference(old, new)
    again = plan_difference(found.plan, new)
    assert again.is_empty
    assert runs(again.plan) == runs(found.plan)
    assert plan_difference(old, old).plan == old
