# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What launch files in Python come to, with ROS 2's own packages."""

from collections.abc import Callable
from pathlib import Path
import sys
import textwrap
import time
from typing import Any

import pytest
from support.talking_worker import lines_of, Message, TalkingWorker

HEAD = """\
import os
from ament_index_python.packages import get_package_share_directory
from launch import *
from launch.actions import *
from launch.conditions import *
from launch.substitutions import *
from launch_ros.actions import *
from launch_ros.descriptions import *

HERE = os.path.dirname(__file__)

def generate_launch_description():
    return LaunchDescription(describe())

"""
#: The packages of a workspace that nobody has built.
UNBUILT = {
    name: {'prefix': f'/nowhere/{name}', 'built': False}
    for name in ('demo', 'rclcpp_components')
}
#: Seconds; a loaded machine needs some.
DEADLINE = 60.0
HAS_COLUMNS = sys.version_info >= (3, 11)

Launch = Callable[..., list[Message]]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / 'demo.launch.py'


@pytest.fixture
def launch(talking_worker: TalkingWorker, path: Path) -> Launch:
    """Return what visits a launch file, given how it describes."""
    talking_worker.begin(UNBUILT)

    def launch(text: str, **scope: Any) -> list[Message]:
        path.write_text(HEAD + textwrap.dedent(text))
        return talking_worker.ask_to_end('visit', path=str(path), scope=scope)

    return launch


def named(told: list[Message], what: str) -> list[Any]:
    return [message for message in told if message['say'] == what]


def line_of(path: Path, text: str) -> int:
    lines = path.read_text().splitlines()
    return next(n for n, line in enumerate(lines, 1) if text in line)


def test_a_process_has_what_the_file_gives_it(
    launch: Launch, path: Path
) -> None:
    told = launch(
        """\
        def describe():
            yield SetLaunchConfiguration('sigkill_timeout', '7')
            yield SetLaunchConfiguration('emulate_tty', 'true')
            yield ExecuteProcess(
                cmd=['prog', LaunchConfiguration('who'), ['a', 'b']],
                name='mine', cwd='/tmp', additional_env={'ONE': '1'},
                output={'both': ['screen', 'log']}, respawn=True,
                respawn_delay=2.0, sigterm_timeout='3', prefix='nice -n 5',
                on_exit=Shutdown())
        """,
        configurations={'who': 'you'},
        environment={'TWO': '2', 'HOME': None},
    )
    (process,) = named(told, 'process')
    position = process.pop('position')
    assert position[:2] == [str(path), line_of(path, 'yield ExecuteProcess')]
    assert position[2] == (11 if HAS_COLUMNS else 5)
    assert process == {
        'say': 'process',
        'id': process['id'],
        'program': 'mine',
        'argv': ['nice', '-n', '5', 'prog', 'you', 'ab'],
        'shell': False,
        'cwd': '/tmp',
        'environment': {'ONE': '1', 'TWO': '2', 'HOME': None},
        'output': 'both',
        'emulate_tty': True,
        'respawn': True,
        'respawn_delay': 2.0,
        'respawn_max_retries': -1,
        'sigterm_timeout': 3.0,
        'sigkill_timeout': 7.0,
        'on_exit_shutdown': True,
        'package': None,
        'node': None,
        'is_container': False,
        'is_lifecycle': False,
        'autostart': False,
        'parameters': [],
    }


def test_a_node_has_its_names_and_parameters(
    launch: Launch, path: Path
) -> None:
    told = launch(
        """\
        def describe():
            yield PushRosNamespace('outer')
            yield SetParameter('shared', 'x')
            yield SetRemap('a', 'b')
            yield LifecycleNode(
                package='demo', executable='talker', name='n', namespace='in',
                parameters=[
                    {'rate': 1.5,
                     'deep': {'list': [1, 2]}},
                ],
                remappings=[('c', 'd')], arguments=['own'])
        """
    )
    (node,) = named(told, 'process')
    words = [w for w in node['argv'] if isinstance(w, str)]
    assert words == [
        '/nowhere/demo/lib/demo/talker',
        'own',
        '--ros-args',
        *('-r', '__node:=n', '-r', '__ns:=/outer/in', '-p', 'shared:=x'),
        *('--params-file', '-r', 'a:=b', '-r', 'c:=d'),
    ]
    file = node['argv'][node['argv'].index('--params-file') + 1]
    assert file['parameters'] == node['parameters'][1:]
    assert node['node'] == '/outer/in/n'
    assert node['package'] == 'demo'
    assert node['is_lifecycle']
    assert not node['autostart']
    names = [(p['name'], p['value']) for p in node['parameters']]
    assert names == [('shared', 'x'), ('rate', 1.5), ('deep.list', [1, 2])]
    if HAS_COLUMNS:
        line = line_of(path, "'deep'")
        assert node['parameters'][2]['position'] == [str(path), line, 23]
    (executable,) = named(told, 'executable')
    assert executable['name'] == 'talker'
    assert executable['path'] == '/nowhere/demo/lib/demo/talker'


def test_components_are_loaded_into_a_container(launch: Launch) -> None:
    told = launch(
        """\
        def describe():
            yield PushRosNamespace('ns')
            yield ComposableNodeContainer(
                package='rclcpp_components', executable='component_container',
                name='box', namespace='', composable_node_descriptions=[
                    ComposableNode(
                        package='demo', plugin='demo::A', name='a',
                        parameters=[{'rate': 2}], remappings=[('c', 'd')],
                        extra_arguments=[{'use_intra_process_comms': True}]),
                    ComposableNode(
                        package='demo', plugin='demo::B',
                        condition=IfCondition('false'))])
            yield LoadComposableNodes(
                target_container='/other', composable_node_descriptions=[
                    ComposableNode(package='demo', plugin='demo::C')])
        """
    )
    (box,) = named(told, 'process')
    assert box['is_container']
    assert box['node'] == '/ns/box'
    first, second = named(told, 'component')
    for component in (first, second):
        assert component.pop('position')[2] > 1
    assert [p.pop('position')[2] > 1 for p in first['parameters']] == [True]
    assert first.pop('extra_arguments')[0]['value'] is True
    assert first == {
        'say': 'component',
        'container': '/ns/box',
        'package': 'demo',
        'plugin': 'demo::A',
        'name': 'a',
        'namespace': '/ns',
        'remaps': ['c:=d'],
        'parameters': [{'name': 'rate', 'value': 2}],
        'is_lifecycle': False,
        'autostart': False,
    }
    assert second['container'] == '/other'
    (condition,) = named(told, 'condition')
    assert (condition['text'], condition['taken']) == ('if: false', False)


def test_scopes_go_through_files_of_all_languages(
    launch: Launch, tmp_path: Path
) -> None:
    (tmp_path / 'inner.launch.py').write_text(
        HEAD + 'def describe():\n'
        "    yield DeclareLaunchArgument('must')\n"
        "    yield LogInfo(msg=['got ', LaunchConfiguration('must')])\n"
        "    yield SetLaunchConfiguration('left', 'over')\n"
        "    yield SetEnvironmentVariable('LEFT', 'over')\n"
    )
    told = launch(
        """\
        def describe():
            inner = os.path.join(HERE, 'inner.launch.py')
            yield GroupAction([
                PushRosNamespace('g'),
                SetLaunchConfiguration('gone', '1'),
                IncludeLaunchDescription(
                    os.path.join(HERE, 'other.launch.yaml'),
                    launch_arguments={'x': 'y'}.items())])
            yield IncludeLaunchDescription(
                inner, launch_arguments=[('must', 'this')])
        """,
        configurations={'given': 'before'},
        parameters=[{'name': 'p', 'value': 1}],
    )
    (include,) = named(told, 'include')
    assert include['path'] == str(tmp_path / 'other.launch.yaml')
    assert include['scope'] == {
        'configurations': {'given': 'before', 'gone': '1', 'x': 'y'},
        'environment': {},
        'namespace': '/g',
        'parameters': [{'name': 'p', 'value': 1}],
        'remaps': [],
        'uses_sim_time': False,
    }
    texts = [message['text'] for message in named(told, 'message')]
    assert texts == ['got this']
    begins = [(m['kind'], m['title']) for m in named(told, 'begin')]
    assert begins == [
        ('group', ''),
        ('file', str(tmp_path / 'inner.launch.py')),
    ]
    assert [m.get('title') for m in named(told, 'end')] == [
        'namespace /g',
        None,
    ]
    assert told[-1]['scope']['configurations'] == {
        'given': 'before',
        'must': 'this',
        'left': 'over',
    }
    assert told[-1]['scope']['environment'] == {'LEFT': 'over'}
    assert told[-1]['scope']['namespace'] is None


def test_arguments_are_listed_with_those_of_includes(
    talking_worker: TalkingWorker, tmp_path: Path, path: Path
) -> None:
    inner = tmp_path / 'inner.launch.py'
    inner.write_text(
        HEAD + "def describe():\n    yield DeclareLaunchArgument('must')\n"
    )
    path.write_text(
        HEAD + 'def describe():\n'
        "    yield DeclareLaunchArgument('mode', description='How',\n"
        "        default_value=['a', LaunchConfiguration('b')],\n"
        "        choices=['x', 'y'])\n"
        '    yield IncludeLaunchDescription(\n'
        "        os.path.join(HERE, 'inner.launch.py'))\n"
    )
    told = talking_worker.ask('arguments', path=str(path))
    mode, must = named(told, 'argument')
    assert mode.pop('position')[:2] == [str(path), line_of(path, "'mode'")]
    assert mode == {
        'say': 'argument',
        'name': 'mode',
        'default': 'a$(var b)',
        'description': 'How.',
        'choices': ['x', 'y'],
        'conditional': False,
        'file': str(path),
    }
    assert must['default'] is None
    assert must['description'] == ''
    assert not must['conditional']
    assert must['file'] == str(inner)


@pytest.mark.parametrize(
    ('text', 'error', 'lines'),
    [
        (
            "def helper():\n    return {}['a']\n"
            'def describe():\n    return [helper()]\n',
            "KeyError: 'a'",
            [
                '    return LaunchDescription(describe())',
                '    return [helper()]',
                "    return {}['a']",
            ],
        ),
        (
            'def describe():\n'
            '    yield GroupAction([\n'
            "        ExecuteProcess(cmd=[PythonExpression('1/0')])])\n",
            'ZeroDivisionError: division by zero',
            ["        ExecuteProcess(cmd=[PythonExpression('1/0')])])"],
        ),
        (
            'def describe():\n'
            "    yield LogInfo(msg=PythonExpression('1 +'))\n",
            'SyntaxError: invalid syntax',
            ["    yield LogInfo(msg=PythonExpression('1 +'))"],
        ),
        (
            "def describe():\n    yield DeclareLaunchArgument(\n'c', "
            "default_value=['z'], choices=['x'])\n",
            'RuntimeError: Argument "c" provided value "z" is not valid. '
            "Valid options are: ['x']",
            ['    yield DeclareLaunchArgument('],
        ),
        (
            'def describe():\n    return (]\n',
            "SyntaxError: closing parenthesis ']' does not match opening "
            "parenthesis '('",
            ['    return (]'],
        ),
    ],
)
def test_an_error_has_the_users_frames(
    launch: Launch, text: str, error: str, lines: list[str]
) -> None:
    told = launch(text)
    assert told[-1]['error']['text'] == error
    frames = told[-1]['error']['frames']
    assert lines_of(frames) == [line.strip() for line in lines]
    # what `launch` logs of it is in the error
    assert named(told, 'message') == []


@pytest.mark.parametrize(
    ('text', 'error', 'line', 'hint'),
    [
        (
            'def describe():\n    return [None]\n',
            'None stands where an action is expected',
            'def generate_launch_description():',
            None,
        ),
        (
            'from launch.event_handlers import *\n'
            'def describe():\n'
            '    yield GroupAction([\n'
            '        OnShutdown(on_shutdown=[])])\n',
            'an OnShutdown stands where an action is expected',
            '        OnShutdown(on_shutdown=[])])',
            'put it into RegisterEventHandler(OnShutdown(…))',
        ),
        (
            'def later(context):\n    return [[]]\n'
            'def describe():\n    yield OpaqueFunction(function=later)\n',
            'a list stands where an action is expected',
            '    yield OpaqueFunction(function=later)',
            "put its actions into the list itself, such as by '*'",
        ),
        (
            'def generate_launch_description():\n    pass\n',
            'generate_launch_description() returned None, '
            'no LaunchDescription',
            'def generate_launch_description():',
            "end it with 'return LaunchDescription([…])'",
        ),
        (
            'del generate_launch_description\n'
            'def generate_launch_descripton():\n    pass\n',
            "the launch file has no function 'generate_launch_description'",
            'def generate_launch_descripton():',
            "did you mean it by 'generate_launch_descripton'?",
        ),
        (
            'def describe():\n'
            "    yield IncludeLaunchDescription(HERE + '/demi.launch.py')\n",
            "the launch file '{}/demi.launch.py' does not exist",
            "    yield IncludeLaunchDescription(HERE + '/demi.launch.py')",
            "did you mean 'demo.launch.py'?",
        ),
    ],
)
def test_what_launch_would_stumble_over_is_told(
    launch: Launch,
    tmp_path: Path,
    text: str,
    error: str,
    line: str,
    hint: str | None,
) -> None:
    told = launch(text)[-1]['error']
    assert told['text'] == error.format(tmp_path)
    assert told['hint'] == hint
    assert [_line_of(frame) for frame in told['frames']] == [line]


def _line_of(frame: Message) -> str:
    path, line, _ = frame['position']
    return Path(path).read_text().splitlines()[line - 1]


def test_what_an_included_file_generates_is_checked(
    launch: Launch, tmp_path: Path
) -> None:
    inner = tmp_path / 'inner.launch.py'
    inner.write_text('def generate_launch_description():\n    return []\n')
    told = launch(
        'def describe():\n'
        "    yield IncludeLaunchDescription(HERE + '/inner.launch.py')\n"
    )[-1]['error']
    assert told['text'].endswith('returned a list, no LaunchDescription')
    assert told['frames'][-1]['position'] == [str(inner), 1, 5]


def test_a_required_argument_is_missed(launch: Launch) -> None:
    told = launch("def describe():\n    yield DeclareLaunchArgument('a')\n")
    assert told[-1]['error']['argument'] == 'a'


def test_files_of_packages_that_are_not_built_are_found(
    launch: Launch, talking_worker: TalkingWorker, tmp_path: Path
) -> None:
    source = tmp_path / 'source.launch.py'
    source.write_text(
        HEAD + "def describe():\n    yield LogInfo(msg='found')\n"
    )
    (tmp_path / 'p.yaml').write_text('/**: {ros__parameters: {a: 1}}')
    share = '/nowhere/demo/share/demo'
    talking_worker.located = {
        f'{share}/a.launch.py': str(source),
        f'{share}/p.yaml': str(tmp_path / 'p.yaml'),
    }
    told = launch(
        """\
        def describe():
            share = get_package_share_directory('demo')
            yield IncludeLaunchDescription(
                PathJoinSubstitution([share, 'a.launch.py']))
            yield Node(package='demo', executable='n', name='n',
                       parameters=[os.path.join(share, 'p.yaml')])
        """
    )
    assert [m['text'] for m in named(told, 'message')] == ['found']
    (node,) = named(told, 'process')
    assert node['argv'][-2:] == ['--params-file', f'{share}/p.yaml']
    assert {m['name'] for m in named(told, 'package')} == {'demo'}
    assert 'scope' in told[-1]


@pytest.mark.parametrize(
    ('text', 'package'),
    [
        ("open(get_package_share_directory('demo') + '/a')", 'demo'),
        ("get_package_share_directory('nobody')", 'nobody'),
        ('__import__("demo.tools")', 'demo'),
    ],
)
def test_the_package_that_is_missed_is_told(
    launch: Launch, text: str, package: str
) -> None:
    told = launch(f'def describe():\n    return [{text}]\n')
    assert told[-1]['error']['package'] == package


@pytest.mark.parametrize(
    ('text', 'refused'),
    [
        (
            'async def wait(context):\n    pass\n'
            'def describe():\n    yield OpaqueCoroutine(coroutine=wait)\n',
            'OpaqueCoroutine (demo.launch.py:{}) needs the event loop of '
            "'ros2 launch'",
        ),
        (
            'from launch_ros.ros_adapters import get_ros_node\n'
            'def talk(context):\n'
            '    try:\n        get_ros_node(context)\n'
            '    except BaseException:\n        pass\n'
            'def describe():\n    yield OpaqueFunction(function=talk)\n',
            'OpaqueFunction (demo.launch.py:{}) needs the ROS node of '
            "'ros2 launch'",
        ),
    ],
)
def test_what_needs_the_launcher_of_ros_is_refused(
    launch: Launch, path: Path, text: str, refused: str
) -> None:
    told = launch(text)
    assert told[-1]['refused'] == refused.format(line_of(path, 'yield'))


def test_actions_of_others_run_as_they_are(launch: Launch, path: Path) -> None:
    told = launch(
        """\
        class Theirs(Action):
            def execute(self, context):
                ExecuteProcess(cmd=['first']).visit(context)
                return [ExecuteProcess(cmd=['second']), LogInfo(msg='third')]

        def describe():
            yield Theirs()
        """
    )
    argvs = [process['argv'] for process in named(told, 'process')]
    assert argvs == [['first'], ['second']]
    assert [m['text'] for m in named(told, 'message')] == ['third']
    assert not (path.parent / '__pycache__').exists()


def test_what_launch_warns_of_has_a_position(
    launch: Launch, path: Path
) -> None:
    told = launch(
        """\
        def describe():
            yield LogInfo(msg='a')

        def generate_launch_description():
            return LaunchDescription(describe(), deprecated_reason='old')
        """
    )
    (warning,) = named(told, 'warning')
    assert warning['text'] == f'launch file [{path}] is deprecated: old'
    assert warning['position'] == [str(path), 1, 1]


def test_a_file_that_goes_elsewhere_takes_its_processes_along(
    launch: Launch, talking_worker: TalkingWorker, tmp_path: Path
) -> None:
    (tmp_path / 'away').mkdir()
    text = """\
        os.chdir(os.path.join(HERE, 'away'))

        def describe():
            yield ExecuteProcess(cmd=['here'])
            yield ExecuteProcess(cmd=['below'], cwd='x')
            yield ExecuteProcess(cmd=['there'], cwd='/tmp')
        """
    told = launch(text)
    away = str(tmp_path / 'away')
    folders = [process['cwd'] for process in named(told, 'process')]
    assert folders == [away, f'{away}/x', '/tmp']
    talking_worker.begin()
    told = launch(text.partition('\n')[2])
    folders = [process['cwd'] for process in named(told, 'process')]
    assert folders == [None, 'x', '/tmp']


def test_helpers_beside_a_file_begin_anew(
    launch: Launch, talking_worker: TalkingWorker, tmp_path: Path, path: Path
) -> None:
    helper = tmp_path / 'a_helper_of_mine.py'
    text = """\
        import sys
        sys.path.insert(0, HERE)
        from a_helper_of_mine import made

        def describe():
            return made()
        """
    for word in ('one', 'other'):
        helper.write_text(
            'from launch.actions import ExecuteProcess\n'
            f"def made():\n    return [ExecuteProcess(cmd=['{word}'])]\n"
        )
        talking_worker.begin()
        (process,) = named(launch(text), 'process')
        assert process['argv'] == [word]
        # where the file calls, and not where others do it for it
        line = line_of(path, 'return made()')
        assert process['position'][:2] == [str(path), line]


def test_it_tells_where_it_is_at_any_time(
    talking_worker: TalkingWorker, path: Path, tmp_path: Path
) -> None:
    path.write_text(
        'import os\nimport time\n\n'
        f'folder = {str(tmp_path)!r}\n\n'
        'def wait():\n'
        "    open(folder + '/waits', 'w').close()\n"
        "    while not os.path.exists(folder + '/done'):\n"
        '        time.sleep(0.01)\n\n'
        'def generate_launch_description():\n'
        '    wait()\n'
        "    raise ValueError('enough')\n"
    )
    talking_worker.send(
        {'do': 'visit', 'id': 0, 'path': str(path), 'scope': {}}
    )
    assert talking_worker.take()['say'] == 'file'
    deadline = time.monotonic() + DEADLINE
    while not (tmp_path / 'waits').exists():
        assert time.monotonic() < deadline
        time.sleep(0.01)
    talking_worker.send({'do': 'where'})
    told = talking_worker.take()
    (tmp_path / 'done').touch()
    assert talking_worker.take()['error']['text'] == 'ValueError: enough'
    assert told['say'] == 'where'
    calls, *_ = lines_of(told['frames'])
    assert calls == 'wait()'
    assert told['frames'][-1]['position'][1] in (8, 9)


def test_a_parameter_file_that_nodes_share_is_made_once(
    launch: Launch, tmp_path: Path
) -> None:
    launch("""
        class Made(Substitution):
            def perform(self, context):
                with open(os.path.join(HERE, 'times'), 'a') as times:
                    times.write('x')
                return os.path.join(HERE, 'made.yaml')

        def describe():
            with open(os.path.join(HERE, 'made.yaml'), 'w') as file:
                file.write('/**: {ros__parameters: {rate: 1}}')
            shared = ParameterFile(Made(), allow_substs=True)
            return [
                Node(
                    package='demo',
                    executable='talker',
                    name=name,
                    parameters=[shared],
                )
                for name in ('one', 'other')
            ]
    """)
    assert (tmp_path / 'times').read_text() == 'x'
