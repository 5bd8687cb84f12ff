# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Processes that are started again, and the end of a launch by one."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description():
    return LaunchDescription(
        [
            DeclareLaunchArgument('again', default_value='true'),
            ExecuteProcess(
                cmd=['part', 'twice more'],
                respawn=True,
                respawn_max_retries=2,
            ),
            Node(
                package='robot_parts',
                executable='part',
                name='delayed',
                respawn=LaunchConfiguration('again'),
                respawn_delay=0.1,
                respawn_max_retries=1,
            ),
            ExecuteProcess(cmd=['part', 'once'], respawn=False),
            ExecuteProcess(cmd=['part', 'stays', '--stay']),
            ExecuteProcess(
                cmd=['part', 'required', '--started', '9', '--ended', '6'],
                on_exit=Shutdown(reason='the required one has ended'),
            ),
            Node(
                package='robot_parts',
                executable='part',
                arguments=['stays too', '--stay'],
                on_exit=[Shutdown()],
            ),
        ]
    )
