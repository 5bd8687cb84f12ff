# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What of a plan runs where."""

from colcon_yamllaunch.deployment.deployment import (
    Deployment,
    Machine,
    ProcessRule,
    Setting,
)
from colcon_yamllaunch.deployment.placement import place, Placer, rules_in_vain
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.plan.member_settings import ReadyCondition
from colcon_yamllaunch.plan.plan import (
    Block,
    ChangeState,
    Component,
    Message,
    Plan,
    Process,
    Shutdown,
    SignalProcess,
    Timer,
    WorkerCall,
)
from colcon_yamllaunch.plan.position import Position
import pytest

AT = Position('a.yaml', 1, 1)
ARM = Machine('arm', 'ssh', ('robot@arm',))
GPU = Machine('gpu', 'slurm', ('--gres=gpu:1',))
MACHINES = {'arm': ARM, 'gpu': GPU}


def process(label, **fields):
    fields = {'name': f'{label}-1', **fields}
    return Process(label, (f'/bin/{label}',), '/', AT, **fields)


def component(label, container, **fields):
    return Component(label, 'pkg', 'pkg::Class', container, AT, **fields)


def deployment(*rules, **fields):
    return Deployment(MACHINES, rules, **fields)


def to(machine, name=None, **match):
    return ProcessRule(AT, machine, name=name, **match)


def on(machine):
    return deployment(everything_on=machine)


DRIVER = process('driver', node_name='/base/driver', package='arm_driver')
CAMERA = process('camera', node_name='/perception/camera')
BOX = process('box', node_name='/perception/box', is_container=True)
FILTER = component('filter', '/perception/box', name='filter')


def labels(plan):
    return [p.label for p in (*plan.processes(), *plan.components())]


def test_process_without_rule_runs_here():
    plan = Plan((DRIVER, CAMERA))
    placed = place(plan, deployment(to('arm', 'other')))
    assert placed.local == placed.whole == plan
    assert not placed.parts


@pytest.mark.parametrize(
    'rule',
    [
        to('arm', 'driver'),
        to('arm', 'driver-1'),
        to('arm', '/base/*'),
        to('arm', '/base'),
        to('arm', 'dri*'),
        to('arm', package='arm_driver'),
        to('arm', package='arm_*'),
        to('arm', executable='driver'),
        to('arm', 'driver', package='arm_driver', executable='d*'),
    ],
    ids=str,
)
def test_process_that_a_rule_matches_runs_on_its_machine(rule):
    placed = place(Plan((DRIVER, CAMERA)), deployment(rule))
    assert labels(placed.local) == ['camera']
    assert labels(placed.parts['arm']) == ['arm│driver']
    assert labels(placed.whole) == ['arm│driver', 'camera']
    assert placed.machines == {'arm│driver': 'arm'}


@pytest.mark.parametrize(
    ('rules', 'parts'),
    [
        # all that a rule says must hold
        ([to('arm', 'driver', package='other')], {}),
        # the first rule decides
        (
            [to('gpu', 'driver'), to('arm', '*')],
            {'gpu': ['gpu│driver'], 'arm': ['arm│camera']},
        ),
        # a rule can be an exception
        ([to('here', 'driver'), to('arm', '*')], {'arm': ['arm│camera']}),
    ],
)
def test_rules_select_the_machine_of_a_process(rules, parts):
    placed = place(Plan((DRIVER, CAMERA)), deployment(*rules))
    found = {name: labels(part) for name, part in placed.parts.items()}
    assert found == parts
    assert len(labels(placed.local)) == 2 - len(placed.machines)


def test_a_label_means_that_process_only():
    # as with --stop
    other = process('x', node_name='/other/driver')
    placed = place(Plan((DRIVER, other)), deployment(to('arm', 'driver')))
    assert labels(placed.local) == ['x']


def test_placed_process_has_the_same_ros_name():
    bare = process('thing', name=None)
    part = place(Plan((bare,)), deployment(to('arm', '*'))).parts['arm']
    assert [p.ros_name for p in part.processes()] == ['thing']


def test_component_runs_where_its_container_does():
    # it may stand in front of it
    foreign = component('alien', '/somewhere/else')
    placed = place(Plan((FILTER, foreign, BOX)), deployment(to('arm', 'box')))
    assert labels(placed.parts['arm']) == ['arm│box', 'arm│filter']
    assert labels(placed.local) == ['alien']


def test_signals_and_transitions_go_where_the_process_is():
    entries = (
        DRIVER,
        FILTER,
        BOX,
        SignalProcess('driver-1', 2, AT),
        ChangeState('/base/driver', 'activate', AT),
        ChangeState('/filter', 'activate', AT),
        ChangeState('/unknown', 'activate', AT),
    )
    rules = [to('arm', 'driver'), to('gpu', 'box')]
    placed = place(Plan(entries), deployment(*rules))
    assert placed.parts['arm'].entries[1:] == (entries[3], entries[4])
    assert placed.parts['gpu'].entries[2:] == (entries[5],)
    assert placed.local.entries == (entries[6],)


def test_timer_is_on_the_machines_of_its_processes():
    inner = Timer(2.0, (DRIVER,), cancel_on_shutdown=False)
    timer = Timer(1.0, (Message('INFO', 'hello'), CAMERA, inner, Shutdown('')))
    placed = place(Plan((timer,)), deployment(to('arm', 'driver')))
    (here,) = placed.local.entries
    assert here.entries == (timer.entries[0], CAMERA, timer.entries[3])
    (there,) = placed.parts['arm'].entries
    assert there.period == 1.0
    assert there.entries[0].period == 2.0
    assert not there.entries[0].cancel_on_shutdown
    assert labels(placed.parts['arm']) == ['arm│driver']
    # and its order is kept as it is shown
    assert labels(placed.whole) == ['camera', 'arm│driver']


def test_empty_timer_stays_here():
    plan = Plan((Timer(1.0, ()),))
    assert place(plan, on('arm')).local == plan


def test_blocks_are_in_all_parts():
    blocks = (Block('file', 'a.yaml', AT, None),)
    placed = place(Plan((DRIVER,), blocks), deployment(to('arm', '*')))
    assert placed.local.blocks == placed.parts['arm'].blocks == blocks


def test_launch_on_one_machine_keeps_its_labels():
    plan = Plan(
        (DRIVER, FILTER, BOX, Message('INFO', 'a'), WorkerCall(1, 'call', AT))
    )
    placed = place(plan, on('arm'))
    assert placed.whole == plan
    assert placed.local.entries == plan.entries[3:]
    assert placed.parts['arm'].entries == plan.entries[:3]
    assert placed.machines == dict.fromkeys(['driver', 'filter', 'box'], 'arm')


def test_unknown_node_is_on_the_machine_of_everything():
    change = ChangeState('/unknown', 'activate', AT)
    assert place(Plan((change,)), on('arm')).parts['arm'].entries == (change,)


def test_later_component_follows_its_container():
    placer = Placer(deployment(to('arm', '/perception/*'), to('gpu', 'late')))
    placer.place(Plan((BOX,)))
    late = process('late', node_name='/late')
    placed = placer.place_more((FILTER, late, CAMERA))
    assert labels(placed.parts['arm']) == ['arm│camera', 'arm│filter']
    assert labels(placed.parts['gpu']) == ['gpu│late']


def test_placed_label_keeps_its_machine():
    placer = Placer(deployment(to('arm', 'driver')))
    first = placer.place(Plan((DRIVER, CAMERA)))
    assert placer.place(first.whole) == first
    fresh = Placer(deployment(to('arm', 'driver')))
    assert fresh.place(first.whole) == first


def warnings(plan, *rules):
    found = rules_in_vain(plan, deployment(*rules))
    return [f'{d.severity}: {d.message}: {d.hint}' for d in found]


def test_rule_without_match_is_a_warning():
    plan = Plan((DRIVER, BOX, FILTER))
    assert warnings(plan, to('arm', 'driver'), to('arm', 'drivr')) == [
        "warning: no process of the launch is meant by 'drivr': did you mean "
        "'driver'?"
    ]
    assert warnings(plan, to('arm', package='arm-driver')) == [
        "warning: no process of the launch is meant by 'package: "
        "arm-driver': did you mean 'arm_driver'?"
    ]
    assert warnings(plan, to('arm', 'filter')) == [
        "warning: no process of the launch is meant by 'filter': filter is a "
        'component: it runs where its container /perception/box does'
    ]


def test_rule_with_settings_may_match_components():
    plan = Plan((DRIVER, BOX, FILTER))
    settings = {'nice': Setting(5, AT, 4)}
    assert (
        warnings(plan, ProcessRule(AT, settings=settings, name='filter')) == []
    )
    assert warnings(
        plan, ProcessRule(AT, settings=settings, name='fitler')
    ) == [
        "warning: no process or component of the launch is meant by 'fitler': "
        "did you mean 'filter'?"
    ]


def test_rule_may_match_a_later_process():
    plan = Plan((WorkerCall(1, 'call', AT),))
    assert warnings(plan, to('arm', 'late')) == []


@pytest.mark.parametrize('kind', ['log', 'command'])
def test_component_has_no_output_and_no_command(kind):
    ready = Setting((ReadyCondition(kind, 'x'),), AT, 5)
    rule = ProcessRule(AT, settings={'ready': ready}, name='filter')
    with pytest.raises(LaunchError) as caught:
        place(Plan((BOX, FILTER)), deployment(rule))
    (problem,) = caught.value.diagnostics
    assert problem.message == (
        f"filter is a component: '{kind}' is a condition of processes"
    )
    assert '/perception/box' in str(problem.hint)
