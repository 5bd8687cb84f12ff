# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files in Python that include others, with arguments."""

from pathlib import Path

from launch import LaunchDescription, LaunchDescriptionSource
from launch.actions import (
    DeclareLaunchArgument,
    ExecuteProcess,
    GroupAction,
    IncludeLaunchDescription,
    SetLaunchConfiguration,
)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import PushRosNamespace

HERE = Path(__file__).parent


def include(**arguments):
    return IncludeLaunchDescription(
        PythonLaunchDescriptionSource([str(HERE), '/included/arm.launch.py']),
        launch_arguments=arguments.items(),
    )


def look(word):
    return ExecuteProcess(
        cmd=[
            'part',
            word,
            LaunchConfiguration('prefix', default='no prefix'),
            LaunchConfiguration('set_by_arm', default='not set'),
        ]
    )


def generate_launch_description():
    in_memory = LaunchDescription(
        [
            DeclareLaunchArgument('word', default_value='default'),
            ExecuteProcess(cmd=['part', LaunchConfiguration('word')]),
        ]
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument('side', default_value='left'),
            GroupAction([include(), look('inside')]),
            look('outside'),
            GroupAction([include(prefix='')]),
            GroupAction([include(prefix=[LaunchConfiguration('side'), '_'])]),
            GroupAction([PushRosNamespace('robot'), include(size='2')]),
            GroupAction(
                [
                    IncludeLaunchDescription(
                        PathJoinSubstitution(
                            [
                                str(HERE),
                                'included',
                                'arm.launch.py',
                            ]
                        ),
                        launch_arguments={'prefix': 'by_path_'}.items(),
                    )
                ]
            ),
            IncludeLaunchDescription(
                LaunchDescriptionSource(in_memory),
                launch_arguments=[('word', 'from memory')],
            ),
            SetLaunchConfiguration('prefix', 'of_the_scope_'),
            include(),
            look('end'),
        ]
    )
