# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Conditions on processes, groups, arguments and includes."""

from launch import Condition, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    ExecuteProcess,
    GroupAction,
    IncludeLaunchDescription,
    LogInfo,
    SetLaunchConfiguration,
)
from launch.conditions import (
    IfCondition,
    LaunchConfigurationEquals,
    LaunchConfigurationNotEquals,
    UnlessCondition,
)
from launch.substitutions import (
    LaunchConfiguration,
    PythonExpression,
    ThisLaunchFileDir,
)
from launch_ros.actions import Node


def part(word, condition):
    return ExecuteProcess(cmd=['part', word], condition=condition)


def generate_launch_description():
    use = LaunchConfiguration('use')
    robot = LaunchConfiguration('robot')
    return LaunchDescription(
        [
            DeclareLaunchArgument('use', default_value='true'),
            DeclareLaunchArgument(
                'robot', default_value='small', choices=['small', 'large']
            ),
            part('if', IfCondition(use)),
            part('unless', UnlessCondition(use)),
            part('one', IfCondition('1')),
            part('zero', IfCondition('0')),
            part('large', LaunchConfigurationEquals('robot', 'large')),
            part('not_large', LaunchConfigurationNotEquals('robot', 'large')),
            part('none', LaunchConfigurationEquals('nobody', None)),
            part(
                'expression',
                IfCondition(PythonExpression(['"', robot, '" == "large"'])),
            ),
            part(
                'predicate',
                Condition(
                    predicate=lambda context: (
                        len(context.launch_configurations['robot']) == 5
                    )
                ),
            ),
            SetLaunchConfiguration('use', 'false', condition=IfCondition(use)),
            GroupAction(
                [part('in_group', None)], condition=UnlessCondition(use)
            ),
            GroupAction(
                [part('in_no_group', None)], condition=IfCondition(use)
            ),
            Node(
                package='robot_parts',
                executable='part',
                arguments=['node'],
                condition=UnlessCondition(use),
            ),
            LogInfo(msg='note: shown', condition=UnlessCondition(use)),
            LogInfo(msg='note: hidden', condition=IfCondition(use)),
            IncludeLaunchDescription(
                [ThisLaunchFileDir(), '/not_there.launch.py'],
                condition=IfCondition(use),
            ),
        ]
    )
