# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""An arm, which other launch files include."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, SetLaunchConfiguration
from launch.substitutions import (
    LaunchConfiguration,
    ThisLaunchFile,
    ThisLaunchFileDir,
)
from launch_ros.actions import Node


def generate_launch_description():
    prefix = LaunchConfiguration('prefix')
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                'prefix',
                default_value='default_',
                description='Stands before each name',
            ),
            DeclareLaunchArgument(
                'size', default_value='1', choices=['1', '2']
            ),
            SetLaunchConfiguration('set_by_arm', [prefix, 'was here']),
            Node(
                package='robot_parts',
                executable='part',
                name=[prefix, 'arm'],
                arguments=[ThisLaunchFile(), ThisLaunchFileDir()],
                parameters=[
                    {
                        'prefix': prefix,
                        'size': LaunchConfiguration('size'),
                    }
                ],
            ),
        ]
    )
