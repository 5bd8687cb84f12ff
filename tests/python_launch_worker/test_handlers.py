# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is told of event handlers, and of what they do, before it happens."""

from collections.abc import Callable
from functools import partial
from typing import Any

from colcon_yamllaunch.python_launch.worker.descriptions import Describer
from colcon_yamllaunch.python_launch.worker.visit import Marker
import pytest


def made(kind: str, **fields: Any) -> Any:
    """Return an object of a class of that name, in a module of `launch`."""
    one = type(kind, (), {'__module__': 'launch.actions'})()
    for name, value in fields.items():
        private = name.startswith('_')
        setattr(one, f'_{kind}{name}' if private else name, value)
    return one


def process(name: str) -> Any:
    description = made('Executable', name=None, cmd=[f'/bin/{name} -v'])
    return made('ExecuteLocal', process_description=description)


def described(entity: Any, processes: Any = None) -> list[str]:
    known = {'rate': '5'}
    return Describer(lambda _: None, known, processes or {}).actions(entity)


def spawn_more(context: Any) -> None:
    raise NotImplementedError


RATE = made('LaunchConfiguration', variable_name='rate')
UNKNOWN = made('LaunchConfiguration', variable_name='speed')
SHUTDOWN = made('Shutdown', reason='reason not given')
TALKER = process('talker')
LINE = spawn_more.__code__.co_firstlineno
CALL = f'call spawn_more (test_handlers.py:{LINE})'


def emitted(event: Any) -> Any:
    return made('EmitEvent', event=event)


def only(action: Any) -> Callable[[Any], bool]:
    return lambda one: one is action


SAYS = made('LogInfo', msg=['at ', RATE, ' and ', UNKNOWN])
LATER = made('TimerAction', period=RATE, actions=[TALKER, TALKER])
SETS = made('SetLaunchConfiguration', name='a', value=RATE)
SOURCE = made('LaunchDescriptionSource', __location='/a/b.launch.py')
INCLUDES = made('IncludeLaunchDescription', launch_description_source=SOURCE)
LOADS = made(
    'LoadComposableNodes',
    __composable_node_descriptions=[1, 2],
    __target_container='/box',
)
CHANGES = made(
    'LifecycleTransition',
    __transition_ids=['1', '3'],
    __lifecycle_node_names=['/a', '/b'],
)
STOPS = made('ShutdownProcess', process_matcher=only(TALKER))
SIGNALS = made(
    'SignalProcess',
    process_matcher=lambda one: one is not None,
    signal_name='SIGUSR1',
)
ACTIVATES = made(
    'ChangeState', lifecycle_node_matcher=only(TALKER), transition_id=3
)


@pytest.mark.parametrize(
    ('entity', 'lines'),
    [
        (None, []),
        ([TALKER, process('b')], ['start talker', 'start b']),
        (SAYS, ['say "at 5 and $(var speed)"']),
        (LATER, ['after 5 s: start talker, start talker']),
        (made('GroupAction', __actions=[TALKER]), ['start talker']),
        (made('LaunchDescription', entities=[TALKER]), ['start talker']),
        (LOADS, ['load 2 components into /box']),
        (INCLUDES, ['include b.launch.py']),
        (made('OpaqueFunction', __function=spawn_more), [CALL]),
        (made('OpaqueFunction', __function=partial(spawn_more, 1)), [CALL]),
        (CHANGES, ['configure, activate /a, /b']),
        (SETS, ["set 'a' to '5'"]),
        (made('SomethingElse'), ['SomethingElse']),
        (emitted(SHUTDOWN), ['shut down']),
        (emitted(made('Shutdown', reason='done')), ['shut down: done']),
        (emitted(STOPS), ['stop talker']),
        (emitted(SIGNALS), ['send SIGUSR1 to talker']),
        (emitted(ACTIVATES), ['activate talker']),
        (emitted(made('Ping')), ['emit Ping']),
    ],
)
def test_actions_are_described(entity: Any, lines: list[str]) -> None:
    assert described(entity, {1: TALKER}) == lines


def test_functions_of_launch_are_not_told() -> None:
    own = made('OpaqueFunction', __function=Marker.visit)
    assert described(own) == [
        'call visit (visit.py:LINE)'.replace(
            'LINE', str(Marker.visit.__code__.co_firstlineno)
        )
    ]
    inner = type('f', (), {'__module__': 'launch_ros.actions'})()
    assert described(made('OpaqueFunction', __function=inner)) == []
