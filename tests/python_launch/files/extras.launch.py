# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Actions, conditions and substitutions of another package."""

from launch import LaunchDescription
from launch.actions import ExecuteProcess, GroupAction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import PushRosNamespace
from robot_extras import CameraPair, Guarded, IsLong, Shout


def generate_launch_description():
    return LaunchDescription(
        [
            GroupAction(
                [
                    PushRosNamespace('robot'),
                    CameraPair(rate=['2', '0']),
                    ExecuteProcess(
                        cmd=['part', LaunchConfiguration('pair_rate')]
                    ),
                ]
            ),
            ExecuteProcess(cmd=['part', Shout(['qui', 'et'])]),
            ExecuteProcess(cmd=['part', 'long'], condition=IsLong('four')),
            ExecuteProcess(cmd=['part', 'short'], condition=IsLong('two')),
            Guarded(word=Shout('halt')),
            ExecuteProcess(cmd=['part', 'end']),
        ]
    )
