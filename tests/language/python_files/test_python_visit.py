# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files in Python become a part of the plan."""

from colcon_yamllaunch.language.evaluation.request import (
    NoWorkerError,
    WorkerError,
    WorkerTimeoutError,
)
from colcon_yamllaunch.language.syntax.diagnostics import render
from colcon_yamllaunch.plan.plan import (
    Block,
    ChangeState,
    Component,
    EvaluatedCondition,
    ParameterFile,
    Process,
    SetParameter,
    Shutdown,
    SignalProcess,
    Timer,
    WorkerCall,
)
from colcon_yamllaunch.plan.position import Position
import pytest
from support.language_fixtures import Launcher
from support.played_worker import (
    Message,
    Play,
    PlayedWorker,
    position,
    process,
)

from tests.language.python_files.conftest import Played


def test_a_process_is_one_of_the_plan(played: Played) -> None:
    at = position(played.path, 7, 9)
    value = {'name': 'rate', 'value': 1.0, 'position': at}
    words = ['/bin/talker', {'content': 'rate: 1', 'parameters': [value]}]
    played.says(
        process(
            3,
            argv=words,
            position=at,
            environment={'SET': None, 'MORE': 'x'},
            respawn=True,
            sigterm_timeout=2.0,
            package='alpha',
            node='/ns/talker',
            parameters=[value],
        )
    )
    evaluation = played.good(
        'launch:\n- executable: {cmd: echo}\n'
        '- include: {file: robot.launch.py}\n- executable: {cmd: echo}\n'
    )
    before, it, behind = evaluation.plan.processes()
    place = Position(played.path, 7, 9)
    rate = SetParameter('rate', '1.0', place)
    assert it == Process(
        label='talker',
        argv=('/bin/talker', ParameterFile('rate: 1', (rate,))),
        cwd=str(played.launcher.folder),
        position=place,
        name='talker-2',
        environment=(('MORE', 'x'), ('SET', None)),
        output='screen',
        respawn=True,
        sigterm_timeout=2.0,
        package='alpha',
        node_name='/ns/talker',
        parameters=(rate,),
        block=1,
    )
    assert (before.name, behind.name) == ('echo-1', 'echo-3')
    _, block = evaluation.plan.blocks
    include = Position(str(played.launcher.folder / 'main.yaml'), 3, 19)
    assert block == Block('file', played.path, include, 0)
    assert evaluation.growing is None


def test_shell_gets_the_files_made_for_a_process(played: Played) -> None:
    file = {'content': 'rate: 1', 'parameters': []}
    played.says(process(1, argv=['a', file, '&&', 'b', file], shell=True))
    text = 'launch:\n- include: {file: robot.launch.py}\n'
    (it,) = played.good(text).plan.processes()
    script, made = 'a "${1}" && b "${2}"', ParameterFile('rate: 1', ())
    assert it.argv == ('/bin/sh', '-c', script, 'sh', made, made)


def test_blocks_timers_and_the_rest(played: Played) -> None:
    at = position(played.path, 2, 3)
    place = Position(played.path, 2, 3)

    played.says(
        {'say': 'condition', 'text': 'x', 'taken': True, 'position': at},
        {'say': 'begin', 'kind': 'group', 'title': '', 'position': at},
        {
            'say': 'begin',
            'kind': 'timer',
            'title': '',
            'position': at,
            'period': 2.5,
            'cancel_on_shutdown': False,
            'on_ros_time': True,
        },
        process(1, position=at),
        {'say': 'end'},
        {'say': 'end', 'title': 'namespace /a'},
        {'say': 'message', 'level': 'INFO', 'text': 'hello'},
        {
            'say': 'change_state',
            'node': '/n',
            'transition': 'configure',
            'position': at,
        },
        {'say': 'signal', 'process': 1, 'signal': 2, 'position': at},
        {'say': 'signal', 'process': 9, 'signal': 2, 'position': at},
        {
            'say': 'component',
            'id': 2,
            'container': '/box',
            'package': 'alpha',
            'plugin': 'a::B',
            'name': 'b',
            'namespace': '/n',
            'remaps': ['x:=y'],
            'parameters': [{'name': 'p', 'value': [1, 2]}],
            'position': at,
        },
        {'say': 'something', 'new': 1},
        {'say': 'call', 'number': 4, 'title': 'it', 'position': at},
        {'say': 'shutdown', 'reason': 'done'},
    )
    evaluation = played.evaluate()
    plan = evaluation.plan
    timer, _, state, sign, component, call, shutdown = plan.entries
    assert isinstance(timer, Timer)
    assert (timer.period, timer.cancel_on_shutdown) == (2.5, False)
    assert timer.on_ros_time
    (late,) = timer.entries
    assert isinstance(late, Process)
    _, _, group, after = plan.blocks
    assert (late.block, after.kind, after.title) == (3, 'timer', '2.5 s')
    assert (group.title, after.parent) == ('namespace /a', 2)
    assert plan.conditions == (EvaluatedCondition('x', True, place),)
    assert state == ChangeState('/n', 'configure', place)
    assert sign == SignalProcess('talker-1', 2, place)
    assert component == Component(
        label='b',
        package='alpha',
        plugin='a::B',
        container='/box',
        position=place,
        name='b',
        namespace='/n',
        remaps=('x:=y',),
        parameters=(SetParameter('p', '[1, 2]', place),),
        block=1,
    )
    assert call == WorkerCall(4, 'it', place)
    assert shutdown == Shutdown('done')
    (use,) = evaluation.plugins
    assert (use.package, use.plugin) == ('alpha', 'a::B')
    (warning,) = evaluation.diagnostics
    assert "the container '/box'" in warning.message


SCOPE = """launch:
- let: {name: empty, value: ''}
- let: {name: kept, value: '1'}
- let: {name: unset, value: x}
- set_env: {name: MORE, value: x}
- unset_env: {name: SET}
- push_ros_namespace: {namespace: a}
- set_parameter: {name: p, value: 1.0}
- set_parameters_from_file: {filename: p.yaml}
- set_remap: {from: x, to: y}
- include: {file: robot.launch.py}
- node: {pkg: alpha, exec: talker, name: $(var name), args: $(var kept)}
"""


def test_the_scope_goes_in_and_comes_back(played: Played) -> None:
    file = str(played.launcher.write('p.yaml', '/**: {ros__parameters: {}}'))

    def play(request: Message) -> Play:
        scope = request['scope']
        assert scope == {
            'configurations': {'empty': '', 'kept': '1', 'unset': 'x'},
            'environment': {'MORE': 'x', 'SET': None},
            'namespace': '/a',
            'parameters': [{'name': 'p', 'value': 1.0}, {'file': file}],
            'remaps': [['x', 'y']],
            'uses_sim_time': False,
            'processes': 0,
        }
        yield from ()
        return {
            'scope': {
                'configurations': {'empty': '', 'kept': '1', 'name': 'n'},
                'environment': {'SET': 'new'},
                'namespace': '/b',
                'parameters': [
                    *scope['parameters'],
                    {'name': 'q', 'value': [True, False]},
                ],
                'remaps': [['x', 'y'], ['z', 'w']],
                'uses_sim_time': True,
            }
        }

    played.does(play)
    (node,) = played.good(SCOPE).plan.processes()
    assert node.node_name == '/b/n'
    assert node.environment == (('SET', 'new'),)
    words = [w for w in node.argv if isinstance(w, str)]
    assert words[1] == '1'
    assert words[-4:] == ['-r', 'x:=y', '-r', 'z:=w']
    assert file in words
    places = {p.name: p.position for p in node.parameters}
    assert places['p'].line == 8
    assert places['q'].line == 11


def test_what_it_unsets_is_not_set(played: Played) -> None:
    def play(request: Message) -> Play:
        yield from ()
        return {'scope': {**request['scope'], 'configurations': {}}}

    played.does(play)
    (error,) = played.evaluate(
        'launch:\n- let: {name: a, value: x}\n'
        '- include: {file: robot.launch.py}\n- log: {message: $(var a)}\n'
    ).errors
    assert "'a' does not exist" in error.message


def test_files_in_yaml_within_python_within_yaml(played: Played) -> None:
    low = played.launcher.write(
        'low.yaml',
        """launch:
- arg: {name: given}
- let: {name: deep, value: $(var given)!}
- node: {pkg: alpha, exec: talker, name: low, args: $(var deep)}
- include: {file: inner.launch.py}
""",
    )
    inner = played.file('inner.launch.py')

    def play(request: Message) -> Play:
        scope = request['scope']
        given = {**scope['configurations'], 'given': 'x'}
        answer = yield {
            'say': 'include',
            'ask': 1,
            'path': str(low),
            'scope': {**scope, 'configurations': given, 'namespace': '/in'},
            'position': position(played.path, 4, 5),
        }
        assert answer['scope']['configurations']['deep'] == 'x!'
        return {'scope': {**scope, **answer['scope'], 'namespace': None}}

    def play_inner(request: Message) -> Play:
        assert request['scope']['namespace'] == '/in'
        assert request['scope']['configurations']['deep'] == 'x!'
        yield process(5, 'inner')

    played.does(play)
    played.does(play_inner, inner)
    evaluation = played.good(
        'launch:\n- include: {file: robot.launch.py}\n'
        '- executable: {cmd: echo $(var deep)}\n'
    )
    node, other, last = evaluation.plan.processes()
    assert (node.node_name, node.argv[1]) == ('/in/low', 'x!')
    assert (other.name, last.argv) == ('inner-2', ('echo', 'x!'))
    titles = [block.title for block in evaluation.plan.blocks[1:]]
    assert titles == [played.path, str(low), inner]
    assert [r['do'] for r in played.worker.requests] == [
        'start',
        'visit',
        'visit',
    ]


def test_mistakes_in_what_it_includes_are_told_once(played: Played) -> None:
    low = played.launcher.write(
        'low.yaml', 'launch: [log: {message: $(var x)}]'
    )
    asked = []

    def play(request: Message) -> Play:
        for path in (low, 'nowhere.yaml'):
            answer = yield {
                'say': 'include',
                'ask': 1,
                'path': str(path),
                'scope': request['scope'],
                'position': position(played.path, 4, 5),
            }
            asked.append(answer)
        return {'failed': True}

    played.does(play)
    errors = played.evaluate(
        'launch:\n- include: {file: robot.launch.py}\n'
        '- log: {message: $(var set_by_it)}\n'
    ).errors
    first, second = errors
    assert "'x' does not exist" in first.message
    assert first.includes[0] == Position(played.path, 4, 5)
    assert first.includes[1].line == 2
    assert 'nowhere.yaml' in second.message
    assert asked == [{'answer': 1, 'failed': True}] * 2


ROBOT = """def rate(text):
    return int(text)


rate('ten')
get_package_share_directory('alpha')
"""
FRAMES = [
    {'position': ['robot', 5, 1], 'end_column': 12},
    {'position': ['robot', 2, 12], 'end_column': 21},
]


def failing(played: Played, said: Message) -> None:
    def play(_request: Message) -> Play:
        yield process(1)
        return {'error': said}

    played.file('robot.launch.py', ROBOT)
    for frame in said.get('frames', ()):
        frame['position'][0] = played.path
    played.does(play)


def test_an_exception_is_told_by_the_users_lines(played: Played) -> None:
    failing(played, {'text': 'ValueError: no', 'frames': FRAMES})
    evaluation = played.evaluate()
    (error,) = evaluation.errors
    assert error.may_pass_after_build
    assert evaluation.packages['alpha'].line == 6
    assert render([error], str(played.launcher.folder)) == (
        'robot.launch.py:2:12: error: ValueError: no\n'
        '  2 |     return int(text)\n'
        '    |            ^^^^^^^^^\n'
        '  called from robot.launch.py:5:1\n'
        '  included from main.yaml:1:26'
    )
    (error,) = played.evaluate_itself().errors
    assert error.includes == ()


def test_a_file_that_cannot_be_read_as_python(played: Played) -> None:
    failing(played, {'text': 'SyntaxError: invalid syntax'})
    (error,) = played.evaluate().errors
    assert not error.may_pass_after_build
    assert error.position == Position(played.path, 1, 1)


def test_packages_that_are_not_built_or_not_there(played: Played) -> None:
    failing(played, {'text': 'LookupError: no', 'package': 'my_pkg'})
    evaluation = played.evaluate()
    (error,) = evaluation.errors
    assert error.may_pass_after_build
    assert evaluation.packages.keys() == {'alpha', 'my_pkg'}
    failing(played, {'text': 'LookupError: no', 'package': 'alpa'})
    (error,) = played.evaluate().errors
    assert not error.may_pass_after_build
    assert "there is no package 'alpa'" in error.message
    assert error.hint == "did you mean 'alpha'?"


def test_an_argument_that_is_not_given(played: Played) -> None:
    failing(played, {'text': 'RuntimeError: no', 'argument': 'robot'})
    (error,) = played.evaluate_itself().errors
    assert error.message == (
        "launch argument 'robot' is required, and was not given"
    )
    assert error.hint == 'give it: robot:=…'
    assert not error.may_pass_after_build


def test_an_argument_that_is_no_choice_is_shown_where_it_is_given(
    played: Played,
) -> None:
    failing(
        played,
        {
            'text': 'RuntimeError: Argument "mode" provided value "fst" is '
            "not valid. Valid options are: ['slow', 'fast']"
        },
    )
    (error,) = played.evaluate_itself(mode='fst').errors
    assert error.position is None
    assert error.message == (
        "launch argument 'mode' cannot be 'fst', as 'mode:=fst' of the "
        'command line says'
    )
    assert error.hint == "did you mean 'fast'?"
    given = 'arg: [{name: mode, value: fst}]'
    include = f'launch:\n- include: {{file: robot.launch.py, {given}}}\n'
    (error,) = played.evaluate(include).errors
    assert error.message == "launch argument 'mode' cannot be 'fst'"
    assert error.position is not None
    assert (error.position.line, error.length) == (2, 3)
    assert error.includes == ()
    (error,) = played.evaluate(include.replace('fst', 'other')).errors
    assert error.message.startswith('RuntimeError: ')


def refused(played: Played) -> None:
    program = played.launcher.write('bin/ros2', '')
    program.chmod(0o755)
    played.launcher.environment['PATH'] = str(program.parent)

    played.says(
        process(1, node='/n'),
        {'say': 'warning', 'text': 'odd'},
        {'say': 'begin', 'kind': 'group', 'title': ''},
        end={'refused': 'Odd needs the event loop'},
    )


def test_what_it_refuses_runs_as_a_process(played: Played) -> None:
    refused(played)
    evaluation = played.evaluate(
        'launch:\n- include: {file: robot.launch.py}\n'
        '- node: {pkg: alpha, exec: talker, name: n, namespace: /}\n'
    )
    (warning,) = evaluation.diagnostics
    assert warning.severity == 'warning'
    assert warning.message == (
        "'robot.launch.py' is run by 'ros2 launch', as one process: "
        'Odd needs the event loop'
    )
    launcher, _ = evaluation.plan.processes()
    assert launcher.argv == ('ros2', 'launch', played.path)
    assert launcher.name == 'robot.launch.py-1'
    assert len(evaluation.plan.blocks) == 2


def test_without_launch_it_is_as_without_a_worker(played: Played) -> None:
    refused(played)

    def send(_message: Message) -> None:
        raise NoWorkerError('there is no launch')

    played.worker.send = send  # type: ignore[method-assign, assignment]
    (it,) = played.good().plan.processes()
    assert it.argv[:2] == ('ros2', 'launch')
    played.launcher.environment['PATH'] = '/nowhere'
    (error,) = played.evaluate().errors
    assert "there is no 'ros2' on the PATH" in error.message


def test_a_worker_that_ends(played: Played) -> None:
    def play(_request: Message) -> Play:
        yield from ()
        raise WorkerError('died by SIGSEGV')

    played.does(play)
    (error,) = played.evaluate(
        'launch:\n- include: {file: robot.launch.py}\n'
        '- include: {file: robot.launch.py}\n'
    ).errors
    assert error.message == (
        'the process that reads launch files in Python died by SIGSEGV'
    )
    assert error.position == Position(played.path, 1, 1)


def test_a_file_that_takes_too_long(played: Played) -> None:
    def play(_request: Message) -> Play:
        yield from ()
        raise WorkerTimeoutError('more than 60 s')

    played.does(play)
    played.file('robot.launch.py', ROBOT)
    frame = {'position': position(played.path, 2, 12), 'end_column': 21}
    played.worker.where = {'frames': [frame]}
    (error,) = played.evaluate().errors
    assert error.message == (
        "the launch file 'robot.launch.py' takes more than 60 s to be read, "
        'and is here'
    )
    assert (error.position, error.length) == (
        Position(played.path, 2, 12),
        9,
    )
    assert 'COLCON_LAUNCH_PYTHON_TIMEOUT' in (error.hint or '')


def test_arguments_that_nothing_declares(played: Played) -> None:
    played.file(
        'robot.launch.py',
        "DeclareLaunchArgument('rate')\nLaunchConfiguration('mode')\n",
    )

    played.says({'say': 'argument', 'name': 'said'})
    (warning,) = played.evaluate_itself(
        rate='1', mode='x', said='y', rat='2'
    ).diagnostics
    assert "the launch argument 'rat'" in warning.message
    assert warning.hint == "did you mean 'rate'?"


def test_paths_that_are_not_installed_yet(played: Played) -> None:
    answers = []

    def play(_request: Message) -> Play:
        for path in (played.path, '/nowhere'):
            answers.append((yield {'say': 'locate', 'ask': 3, 'path': path}))
        return None

    played.does(play)
    played.good()
    assert answers == [
        {'answer': 3, 'path': played.path},
        {'answer': 3, 'path': None},
    ]


def test_nodes_of_one_name_are_warned_of(played: Played) -> None:
    at = position(played.path, 2, 3)
    played.says(process(1, node='/n', position=at))
    (warning,) = played.evaluate(
        'launch:\n- node: {pkg: alpha, exec: talker, name: n, namespace: /}\n'
        '- include: {file: robot.launch.py}\n'
    ).diagnostics
    assert "the name '/n' too" in warning.message
    assert warning.position == Position(played.path, 2, 3)


def test_files_that_include_one_another_for_ever(played: Played) -> None:
    def play(request: Message) -> Play:
        answer = yield {
            'say': 'include',
            'ask': 1,
            'path': str(played.launcher.folder / 'main.yaml'),
            'scope': request['scope'],
        }
        return {'failed': True} if 'failed' in answer else None

    played.does(play)
    (error,) = played.evaluate().errors
    assert 'include one another' in error.message


def test_the_worker_is_started_anew_for_each_evaluation(
    launcher: Launcher,
) -> None:
    played = Played(launcher)
    played.good()
    worker: PlayedWorker = played.worker
    played.good()
    start, visit, *again = worker.requests
    assert again == [start, visit]
    assert start['packages']['alpha'] == {
        'prefix': '/install/alpha',
        'built': False,
    }


@pytest.mark.parametrize(
    'name', ['respawn_delay', 'sigterm_timeout', 'sigkill_timeout']
)
def test_a_time_of_a_process_is_a_number(played: Played, name: str) -> None:
    at = position(played.path, 3, 5)
    played.says(process(1, position=at, **{name: float('nan')}))
    (problem,) = played.evaluate().diagnostics
    assert problem.message == f"'{name}' is not a number"
    assert problem.position == Position(played.path, 3, 5)


def test_the_period_of_a_timer_is_a_number(played: Played) -> None:
    at = position(played.path, 2, 3)
    period = float('nan')
    played.says(
        {
            'say': 'begin',
            'kind': 'timer',
            'position': at,
            'period': period,
        },
        process(1, position=at),
        {'say': 'end'},
    )
    (problem,) = played.evaluate().diagnostics
    assert problem.message == "'period' is not a number"
