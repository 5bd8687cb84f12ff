# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Plans as JSON, as text and as drawings."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from itertools import count, repeat
import json
import subprocess
from typing import Any, get_args, get_origin, get_type_hints, Literal

from colcon_yamllaunch.language.policies.evaluate import evaluate
from colcon_yamllaunch.plan.member_settings import (
    MemberSettings,
    ReadyCondition,
    ResourceLimits,
    Restart,
    Scheduling,
)
from colcon_yamllaunch.plan.plan import (
    AfterReady,
    Block,
    ChangeState,
    Component,
    Entry,
    EvaluatedCondition,
    EventHandler,
    Message,
    ParameterFile,
    Plan,
    Process,
    SetParameter,
    Shutdown,
    SignalProcess,
    Timer,
    Variables,
    WorkerCall,
)
from colcon_yamllaunch.plan.plan_graph import plan_to_dot, plan_to_mermaid
from colcon_yamllaunch.plan.plan_json import (
    plan_from_json,
    plan_to_json,
    PlanFormatError,
)
from colcon_yamllaunch.plan.plan_text import command, plan_to_text
from colcon_yamllaunch.plan.position import Position
from hypothesis import given
from hypothesis import strategies as st
import pytest
from support.language_fixtures import Launcher

HERE = Position('/ws/demo.yaml', 14, 9)
THERE = Position('/ws/bringup.yaml', 30, 7)
RATE = SetParameter('rate', '10', HERE, (THERE,))
NODE = Process(
    label='driver',
    name='usb_driver-1',
    argv=(
        '/ws/driver',
        "it's",
        '--ros-args',
        '--params-file',
        ParameterFile('"/**":\n', (RATE,)),
    ),
    cwd='/ws/a folder',
    position=HERE,
    environment=(('A', '1 2'), ('B', None)),
    respawn=True,
    respawn_delay=0.5,
    node_name='/left/driver',
    package='drivers',
    parameters=(RATE,),
    block=1,
)
TWIN = replace(NODE, label='twin')
PLAN = Plan(
    (
        Message('INFO', 'hello'),
        NODE,
        Timer(2.0, (Shutdown('done'),), cancel_on_shutdown=False),
    ),
    (
        Block('file', '/ws/demo.yaml', HERE, None),
        Block('group', 'namespace /left', HERE, 0),
    ),
    (EvaluatedCondition('if: $(var "x")', True, HERE),),
)

SIMPLE = {
    str: st.text(max_size=4),
    int: st.integers(),
    float: st.floats(min_value=0, max_value=9),
    bool: st.booleans(),
    type(None): st.none(),
    Variables: st.dictionaries(
        st.text(max_size=3), st.none() | st.text(max_size=3)
    ).map(lambda variables: tuple(sorted(variables.items()))),
}


@cache
def values(hint: Any) -> st.SearchStrategy[Any]:
    """Return a strategy for the values of a type."""
    arguments = get_args(hint)
    if hint in SIMPLE:
        return SIMPLE[hint]
    if get_origin(hint) is Literal:
        return st.sampled_from(arguments)
    if get_origin(hint) is tuple:
        inner = st.deferred(lambda: values(arguments[0]))
        return st.lists(inner, max_size=2).map(tuple)
    if arguments:
        return st.one_of(*map(values, arguments))
    hints = get_type_hints(hint)
    return st.builds(hint, **{name: values(hints[name]) for name in hints})


def numbered(entry: Entry, numbers: Iterator[int]) -> Entry:
    """Return an entry with a label of its own."""
    if isinstance(entry, Timer | AfterReady):
        inner = tuple(numbered(e, numbers) for e in entry.entries)
        return replace(entry, entries=inner)
    if isinstance(entry, Process | Component):
        return replace(entry, label=f'{entry.label}{next(numbers)}')
    return entry


plans = values(Plan).map(
    lambda plan: replace(
        plan, entries=tuple(map(numbered, plan.entries, repeat(count())))
    )
)


@given(plans)
def test_json_tells_all_of_a_plan(plan: Plan) -> None:
    assert plan_from_json(plan_to_json(plan)) == plan


def test_json_of_a_plan_with_everything() -> None:
    text = plan_to_json(PLAN)
    assert plan_from_json(text) == PLAN
    data = json.loads(text)
    assert data['version'] == 1
    assert [entry['type'] for entry in data['entries']] == [
        'message',
        'process',
        'timer',
    ]
    assert data['entries'][1]['environment'] == {'A': '1 2', 'B': None}


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('{', 'not JSON'),
        ('[]', "no 'version'"),
        ('{"version": 2}', 'its version is 2'),
        ('{"version": 1, "entries": 3}', 'plan.entries is not a list'),
        ('{"version": 1, "x": 3}', "unknown field 'x'"),
        (
            '{"version": 1, "entries": [{"type": "timer"}]}',
            'plan.entries[0].period is missing',
        ),
        (
            '{"version": 1, "entries": [{"type": "dance"}]}',
            'plan.entries[0] is not a process or a component or a message',
        ),
        (
            '{"version": 1, "entries": [{"type": "shutdown", "reason": 1}]}',
            'plan.entries[0].reason is not of the type str',
        ),
        ('[' * 100_000, 'not JSON'),
        (
            plan_to_json(Plan((TWIN, Timer(1.0, (TWIN,))))),
            "2 processes or components have the label 'twin'",
        ),
    ],
)
def test_json_that_is_no_plan(text: str, reason: str) -> None:
    with pytest.raises(PlanFormatError) as caught:
        plan_from_json(text)
    assert reason in str(caught.value)


@given(st.recursive(st.none() | st.text(max_size=3), st.lists, max_leaves=5))
def test_json_of_anything_is_refused_in_one_way(value: object) -> None:
    text = json.dumps({'version': 1, 'entries': value})
    try:
        plan_from_json(text)
    except PlanFormatError as e:
        assert 'plan.entries' in str(e)
    else:
        assert value == []


def test_text_names_what_a_user_asks_for() -> None:
    lines = plan_to_text(PLAN, '/ws').splitlines()
    assert lines[0] == 'INFO: hello'
    assert lines[1] == (
        'driver, process usb_driver-1, node /left/driver, package drivers'
        '  (demo.yaml:14:9)'
    )
    assert '    respawn: without end, after 0.5 s' in lines
    wanted = 'rate: 10  (demo.yaml:14:9, passed by bringup.yaml:30:7)'
    assert f'        {wanted}' in lines
    assert lines[-5:] == [
        'after 2 s:',
        '    the launch ends: done',
        '',
        'conditions:',
        '    if: $(var "x")  taken  (demo.yaml:14:9)',
    ]


BOX = Process(
    label='container-1',
    argv=('/ws/container',),
    cwd='/ws',
    position=HERE,
    node_name='/box',
    is_container=True,
)
TALKER = Component(
    label='talker',
    package='demo',
    plugin='demo::Talker',
    container='/box',
    position=HERE,
    name='talker',
    namespace='/ns',
    remaps=('a:=b',),
    parameters=(RATE, SetParameter('text', '"a b"', HERE)),
    extra_arguments=(SetParameter('intra', 'true', HERE),),
    is_lifecycle=True,
    autostart=True,
)
COMPONENTS = Plan(
    (
        BOX,
        TALKER,
        Timer(2.0, (replace(TALKER, container='/far'),), on_ros_time=True),
    )
)


def test_text_of_components() -> None:
    lines = plan_to_text(COMPONENTS, '/ws').splitlines()
    assert lines[2:12] == [
        'talker, node /ns/talker, package demo, plugin demo::Talker, loaded '
        'into /box  (demo.yaml:14:9)',
        '    ros2 component load /box demo demo::Talker -n talker '
        '--node-namespace /ns -r a:=b -p rate:=10 -p \'text:="a b"\' '
        '-e intra:=true',
        '    its node is configured and activated',
        '    parameters:',
        '        rate: 10  (demo.yaml:14:9, passed by bringup.yaml:30:7)',
        '        text: "a b"  (demo.yaml:14:9)',
        '    extra arguments:',
        '        intra: true  (demo.yaml:14:9)',
        'after 2 s on /clock:',
        '    talker, node /ns/talker, package demo, plugin demo::Talker, '
        'loaded into /far  (demo.yaml:14:9)',
    ]


def test_drawings_of_components() -> None:
    assert plan_to_mermaid(COMPONENTS, '/ws').splitlines()[1:] == [
        '  process0["container-1<br/>/box"]',
        '  component0(["talker<br/>/ns/talker"])',
        '  component1(["talker<br/>/ns/talker<br/>in /far"])',
        '  process0 --> component0',
    ]
    assert plan_to_dot(COMPONENTS, '/ws').splitlines()[2:-1] == [
        '  process0 [label="container-1\\n/box"];',
        '  component0 [shape=ellipse, label="talker\\n/ns/talker"];',
        '  component1 [shape=ellipse, label="talker\\n/ns/talker\\nin /far"];',
        '  process0 -> component0;',
    ]


PYTHON = Position('/ws/a.launch.py', 7, 5)
HANDLERS = (
    EventHandler('exit', ('usb_driver-1',), '', ('start rviz2',), PYTHON),
    EventHandler('start', ('a-2', 'b-3'), 'once', ('call f', 'x'), PYTHON),
    EventHandler('output', (), '', ('call g',), PYTHON),
    EventHandler('state', ('/lc',), 'inactive', ('activate /lc',), PYTHON),
    EventHandler('state', (), 'active to inactive', ('x',), PYTHON),
    EventHandler('complete', (), '', ('x',), PYTHON),
    EventHandler('shutdown', (), '', ('say "bye"',), PYTHON),
    EventHandler('other', (), 'my_event', (), PYTHON),
)
ENTRIES = (
    ChangeState('/lc', 'configure', PYTHON),
    SignalProcess('usb_driver-1', 2, PYTHON),
    SignalProcess('usb_driver-1', 0, PYTHON),
    SignalProcess('usb_driver-1', 99, PYTHON),
    Timer(2.0, (WorkerCall(3, 'call spawn (a.launch.py:3)', PYTHON),)),
)


DRIVER_SETTINGS = MemberSettings(
    HERE,
    ready=(
        ReadyCondition('topic', 'scan', message=True),
        ReadyCondition('port', '7447'),
    ),
    restart=Restart('failure', 5, 60.0, 0.5, 30.0, 'leave', ('nav',), ('x',)),
    critical=True,
    limits=ResourceLimits(
        2 << 30, 1 << 30, 1.5, (2, 3), 50, 9, -5, Scheduling('fifo', 7), 1000
    ),
    user='robot',
)
NAV = replace(
    NODE,
    label='nav',
    name='nav-2',
    respawn=False,
    parameters=(),
    settings=MemberSettings(
        HERE,
        after=('driver',),
        ready_timeout=30.0,
        on_timeout='fail',
        optional=True,
    ),
)
DEPLOYED = Plan(
    (
        replace(NODE, settings=DRIVER_SETTINGS, parameters=()),
        AfterReady(('driver',), (NAV,)),
    ),
    PLAN.blocks,
)


def test_text_of_settings() -> None:
    lines = plan_to_text(DEPLOYED, '/ws').splitlines()
    # the command is above them
    assert [line for line in lines if '&&' not in line] == [
        'driver, process usb_driver-1, node /left/driver, package drivers  '
        '(demo.yaml:14:9)',
        '    ready: a message on scan and the port 7447',
        '    restart: when it fails, after 0.5 s, doubled up to 30 s, at most '
        '5 times in 60 s, else it stays down, once this succeeds: x, together '
        'with nav',
        '    critical: the launch ends when it fails',
        '    limits: memory 2.0 GiB, memory_high 1.0 GiB, cpu 150%, cpus 2 3, '
        'io 50, tasks 9, nice -5, scheduling fifo 7, oom 1000',
        '    user: robot',
        'once driver is ready:',
        '    nav, process nav-2, node /left/driver, package drivers  '
        '(demo.yaml:14:9)',
        '        after: driver',
        '        not ready after 30 s: the launch ends',
        '        optional: its failure does not count',
        '',
        'stages:',
        '    1: driver',
        '    2: nav',
    ]


def test_drawings_of_the_start_order() -> None:
    arrow = '  process0 ==>|"a message on scan<br/>the port 7447"| process1'
    assert arrow in plan_to_mermaid(DEPLOYED, '/ws').splitlines()
    arrow = (
        '  process0 -> process1 [style=bold, label="a message on scan\\n'
        'the port 7447"];'
    )
    assert arrow in plan_to_dot(DEPLOYED, '/ws').splitlines()


def test_text_of_what_happens_when() -> None:
    place = '  (a.launch.py:7:5)'
    plan = Plan(ENTRIES, handlers=HANDLERS)
    assert plan_to_text(plan, '/ws').splitlines() == [
        f'configure /lc{place}',
        f'SIGINT to usb_driver-1{place}',
        f'stop usb_driver-1{place}',
        f'signal 99 to usb_driver-1{place}',
        'after 2 s:',
        f'    at its time: call spawn (a.launch.py:3){place}',
        f'when usb_driver-1 ends: start rviz2{place}',
        f'when a-2 or b-3 starts (once):{place}',
        '    call f',
        '    x',
        f'when a process writes something: call g{place}',
        f'when /lc is inactive: activate /lc{place}',
        'when a lifecycle node changes its state (active to inactive): '
        f'x{place}',
        f'when something is done: x{place}',
        f'when the launch ends: say "bye"{place}',
        f'when my_event:{place}',
    ]


def test_drawings_of_what_happens_when() -> None:
    node = replace(NODE, block=None)
    plan = Plan((node,), handlers=HANDLERS[:2])
    assert plan_to_mermaid(plan, '/ws').splitlines()[2:] == [
        '  handler0>"when usb_driver-1 ends:<br/>start rviz2"]',
        '  process0 -.-> handler0',
        '  handler1>"when a-2 or b-3 starts (once):<br/>call f<br/>x"]',
    ]
    assert '  process0 -> handler0 [style=dashed];' in plan_to_dot(plan, '/ws')


def test_what_happens_while_a_plan_runs_may_need_python() -> None:
    assert Plan(ENTRIES[:4]).worker_position is None
    assert Plan(ENTRIES).worker_position == PYTHON
    plan = Plan((NODE,), handlers=HANDLERS)
    assert plan.worker_position == PYTHON
    assert plan_from_json(plan_to_json(plan)) == plan


def test_text_of_an_empty_plan() -> None:
    assert plan_to_text(Plan(), '/ws') == 'nothing would run'
    setup = '/ws/it is/setup.bash'
    assert plan_to_text(Plan(), '/ws', setup) == 'nothing would run'
    first = plan_to_text(PLAN, '/ws', setup).splitlines()[1]
    assert first.strip() == ". '/ws/it is/setup.bash'"


def test_command_can_be_pasted(tmp_path) -> None:
    folder = tmp_path / 'a folder'
    folder.mkdir()
    code = 'pwd; echo "$A" "${B-unset}"; printf "<%s>" "$@"'
    process = Process(
        label='sh-1',
        argv=(
            'sh',
            '-c',
            code,
            'sh',
            "it's",
            '--params-file',
            ParameterFile('ignored', (RATE,)),
        ),
        cwd=str(folder),
        position=HERE,
        environment=(('A', '1 2'), ('B', None)),
    )
    done = subprocess.run(
        ['bash', '-c', command(process)],
        env={'PATH': '/usr/bin:/bin', 'B': 'set'},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == f"{folder}\n1 2 unset\n<it's><-p><rate:=10>"


def test_command_with_a_file_whose_substitutions_are_made() -> None:
    process = Process(
        label='cat-1',
        argv=('cat', ParameterFile("it's: 1\n")),
        cwd='/',
        position=HERE,
    )
    done = subprocess.run(
        ['bash', '-c', command(process)],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "it's: 1\n"


def test_mermaid() -> None:
    assert plan_to_mermaid(PLAN, '/ws').splitlines() == [
        'flowchart TB',
        '  subgraph block0 ["demo.yaml"]',
        '    subgraph block1 ["group namespace /left"]',
        '      process0["driver<br/>/left/driver"]',
        '    end',
        '  end',
    ]


def test_dot() -> None:
    assert plan_to_dot(PLAN, '/ws').splitlines() == [
        'digraph launch {',
        '  node [shape=box];',
        '  subgraph cluster0 { label="demo.yaml";',
        '    subgraph cluster1 { label="group namespace /left";',
        '      process0 [label="driver\\n/left/driver"];',
        '    }',
        '  }',
        '}',
    ]


def test_a_drawing_names_launch_files_by_their_source(
    launcher: Launcher,
) -> None:
    request = launcher.request('launch: []\n')
    installed = replace(request, name='/install/alpha/launch/main.yaml')
    for draw in (plan_to_mermaid, plan_to_dot):
        drawing = draw(evaluate(installed).plan, str(launcher.folder))
        assert '"main.yaml"' in drawing
        assert '/install' not in drawing


def _timer(period: str) -> str:
    entry = f'{{"type": "timer", "period": {period}, "entries": []}}'
    return f'{{"version": 1, "entries": [{entry}]}}'


@pytest.mark.hostile
@pytest.mark.parametrize(
    'text',
    [
        *map(_timer, ('NaN', 'Infinity', '-Infinity', '-1', '1e999')),
        *map(_timer, ('9' * 400, '9' * 5000, 'true', '"1"')),
        '[' * 100_000,
        '{"version": 1, "entries": ' + '[' * 900 + ']' * 900 + '}',
        '[' + '{},' * 2_000_000,
    ],
)
def test_a_plan_that_nobody_can_run(text: str) -> None:
    with pytest.raises(PlanFormatError) as caught:
        plan_from_json(text)
    assert len(str(caught.value)) < 1000


@pytest.mark.hostile
def test_a_plan_that_waits_for_centuries() -> None:
    (timer,) = plan_from_json(_timer('1e300')).entries
    assert isinstance(timer, Timer)
    assert timer.period == 1e300
