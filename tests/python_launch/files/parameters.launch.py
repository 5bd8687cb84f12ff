# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Parameters of each type, and files with parameters."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, SetEnvironmentVariable
from launch.substitutions import (
    LaunchConfiguration,
    PathJoinSubstitution,
    PythonExpression,
)
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue
from launch_ros.substitutions import FindPackageShare


def node(name, parameters, **more):
    return Node(
        package='robot_parts',
        executable='part',
        name=name,
        parameters=parameters,
        **more,
    )


def generate_launch_description():
    config = PathJoinSubstitution([FindPackageShare('robot_parts'), 'config'])
    who = LaunchConfiguration('who')
    return LaunchDescription(
        [
            DeclareLaunchArgument('who', default_value='12'),
            SetEnvironmentVariable('T_PLACE', 'kitchen'),
            node(
                'literal',
                [
                    {
                        'yes': True,
                        'no': False,
                        'whole': -3,
                        'large': 2**40,
                        'real': 1.0,
                        'small': 1e-7,
                        'text': 'a text',
                        'number_like': '007',
                        'bool_like': 'true',
                        'empty': '',
                        'lines': 'one\ntwo: "three"\n',
                        'unicode': 'Grüße',
                        'truths': [True, False],
                        'wholes': [1, 2, 3],
                        'reals': [1.0, 2.5],
                        'texts': ['a', 'b c', '1'],
                        'tuple': (1, 2),
                        'nested': {'deep': {'er': 1}, 'list': ['x']},
                        'dotted.name': 3,
                    }
                ],
            ),
            node(
                'substituted',
                [
                    {
                        'inferred': who,
                        'joined': [who, ' of ', who],
                        'listed': [[who, 'a'], [who, 'b']],
                        ('key_', who): 'under a made name',
                        'expression': PythonExpression(['1.5 * ', who]),
                        'text': ParameterValue(who, value_type=str),
                        'whole': ParameterValue(who, value_type=int),
                        'real': ParameterValue([who, '.0'], value_type=float),
                        'flag': ParameterValue(
                            PythonExpression([who, ' > 3']), value_type=bool
                        ),
                    }
                ],
            ),
            node(
                'files',
                [
                    PathJoinSubstitution([config, 'gains.yaml']),
                    {'gain': 3.5},
                    ParameterFile(
                        PathJoinSubstitution([config, 'filled_in.yaml']),
                        allow_substs=True,
                    ),
                    Path(__file__).parent / 'parameters' / 'more.yaml',
                    {'last': 'counts'},
                    {'last': 'really'},
                ],
                namespace='arm',
            ),
            node(None, [{'anonymous': True}]),
            node(
                'through_arguments',
                [],
                ros_arguments=['-p', 'from:=arguments', '--log-level', 'warn'],
            ),
        ]
    )
