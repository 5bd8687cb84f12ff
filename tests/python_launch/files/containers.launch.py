# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Component containers, and what they are to load."""

from launch import LaunchDescription
from launch.actions import ExecuteProcess, GroupAction, Shutdown
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import (
    ComposableNodeContainer,
    LoadComposableNodes,
    PushRosNamespace,
    SetParameter,
    SetRemap,
)
from launch_ros.descriptions import ComposableNode
from launch_ros.substitutions import FindPackageShare


def component(name, **more):
    return ComposableNode(
        package='robot_parts', plugin='robot_parts::Part', name=name, **more
    )


def generate_launch_description():
    gains = PathJoinSubstitution(
        [FindPackageShare('robot_parts'), 'config', 'gains.yaml']
    )
    container = ComposableNodeContainer(
        package='robot_parts',
        executable='box',
        name='second',
        namespace='/far',
        parameters=[{'threads': 2}],
    )
    return LaunchDescription(
        [
            GroupAction(
                [
                    PushRosNamespace('arm'),
                    SetParameter('rate', 5),
                    SetRemap('image', 'raw'),
                    ComposableNodeContainer(
                        package='robot_parts',
                        executable='box',
                        name='box',
                        namespace='inner',
                        composable_node_descriptions=[
                            component('plain'),
                            component(
                                [
                                    'made_',
                                    LaunchConfiguration('x', default='up'),
                                ],
                                namespace='sub',
                                parameters=[
                                    {
                                        'text': 'a',
                                        'flag': True,
                                        'real': 1.0,
                                        'list': [1, 2],
                                        'nested': {'deep': 'er'},
                                    },
                                    gains,
                                ],
                                remappings=[('a', 'b')],
                                extra_arguments=[
                                    {'use_intra_process_comms': True}
                                ],
                            ),
                            component('not', condition=IfCondition('false')),
                        ],
                    ),
                    LoadComposableNodes(
                        target_container='/arm/inner/box',
                        composable_node_descriptions=[
                            component('camera', parameters=[gains]),
                        ],
                    ),
                ]
            ),
            container,
            LoadComposableNodes(
                target_container=container,
                composable_node_descriptions=[component('late')],
            ),
            LoadComposableNodes(
                target_container='/far/second',
                composable_node_descriptions=[component('never')],
                condition=IfCondition('0'),
            ),
            ExecuteProcess(
                cmd=['part', 'last', '--components', '4'],
                on_exit=Shutdown(),
            ),
        ]
    )
