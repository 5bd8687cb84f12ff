# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a node takes beside parameters."""

from launch import LaunchDescription
from launch.actions import SetLaunchConfiguration
from launch.substitutions import (
    EnvironmentVariable,
    LaunchConfiguration,
    ThisLaunchFileDir,
)
from launch_ros.actions import Node


def generate_launch_description():
    records = {
        'RECORDS': EnvironmentVariable('RECORDS'),
        'PATH': EnvironmentVariable('PATH'),
    }
    return LaunchDescription(
        [
            Node(
                package='robot_parts',
                executable='part',
                name='eye',
                exec_name='seeing',
                namespace='head',
                remappings=[('a', 'b'), ('/c', '~/d')],
                arguments=['--flag', LaunchConfiguration('x', default='y z')],
                ros_arguments=['--log-level', 'info'],
                output='screen',
                cwd=ThisLaunchFileDir(),
                additional_env={'T_MORE': ['a', 'b']},
            ),
            Node(
                package='robot_parts',
                executable='part',
                arguments=['only this'],
                env={**records, 'T_ONLY': 'this'},
            ),
            Node(executable='part', arguments=['on the PATH']),
            Node(
                package='robot_parts',
                executable='part',
                name='prefixed',
                prefix=['env T_PREFIX=', '"two words"'],
                respawn=False,
            ),
            SetLaunchConfiguration('launch-prefix', 'env T_GENERAL=1'),
            Node(package='robot_parts', executable='part', name='general'),
            Node(
                package='robot_parts',
                executable='part',
                name='own',
                prefix='env T_OWN=1',
            ),
            SetLaunchConfiguration('launch-prefix-filter', 'nobody'),
            Node(package='robot_parts', executable='part', name='filtered'),
        ]
    )
