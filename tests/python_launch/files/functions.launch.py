# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Functions that make entities when their turn comes."""

from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    ExecuteProcess,
    GroupAction,
    LogInfo,
    OpaqueFunction,
    SetLaunchConfiguration,
)
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
import yaml


def arms(context, prefix, *, suffix):
    count = int(LaunchConfiguration('count').perform(context))
    names = yaml.safe_load(LaunchConfiguration('names').perform(context))
    context.launch_configurations['last'] = names[count - 1]
    return [
        Node(
            package='robot_parts',
            executable='part',
            name=f'{prefix}{name}{suffix}',
            namespace=name,
            parameters=[{'index': index}],
        )
        for index, name in enumerate(names[:count])
    ]


def nothing(context):
    context.environment['T_FUNCTION'] = 'has run'


def nested(context):
    return [
        LogInfo(
            msg=f'note: last is {LaunchConfiguration("last").perform(context)}'
        ),
        OpaqueFunction(function=deeper, args=['inner']),
        ExecuteProcess(cmd=['part', 'behind']),
    ]


def deeper(context, word):
    return [
        SetLaunchConfiguration('last', word),
        GroupAction(
            [ExecuteProcess(cmd=['part', LaunchConfiguration('last')])]
        ),
    ]


def generate_launch_description():
    description = LaunchDescription()
    description.add_action(DeclareLaunchArgument('count', default_value='2'))
    description.add_action(
        DeclareLaunchArgument('names', default_value='[left, right, third]')
    )
    description.add_action(
        OpaqueFunction(function=arms, args=['arm_'], kwargs={'suffix': '_x'})
    )
    description.add_action(OpaqueFunction(function=nothing))
    description.add_action(OpaqueFunction(function=nested))
    description.add_action(
        ExecuteProcess(cmd=['part', 'last', LaunchConfiguration('last')])
    )
    return description
