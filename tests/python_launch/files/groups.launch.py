# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What groups keep in, let out and let in: configurations, environment."""

from launch import LaunchDescription
from launch.actions import (
    AppendEnvironmentVariable,
    DeclareLaunchArgument,
    ExecuteProcess,
    GroupAction,
    PopEnvironment,
    PopLaunchConfigurations,
    PushEnvironment,
    PushLaunchConfigurations,
    ResetEnvironment,
    ResetLaunchConfigurations,
    SetEnvironmentVariable,
    SetLaunchConfiguration,
    UnsetEnvironmentVariable,
    UnsetLaunchConfiguration,
)
from launch.substitutions import LaunchConfiguration


def look(word):
    return ExecuteProcess(
        cmd=[
            'part',
            word,
            LaunchConfiguration('a', default='no a'),
            LaunchConfiguration('b', default='no b'),
        ]
    )


def change(value):
    return [
        SetLaunchConfiguration('a', value),
        SetEnvironmentVariable('T_A', value),
    ]


def generate_launch_description():
    return LaunchDescription(
        [
            DeclareLaunchArgument('b', default_value='b of the file'),
            *change('outside'),
            GroupAction([*change('inside'), look('inside')]),
            look('after'),
            GroupAction([*change('let out')], scoped=False),
            look('after unscoped'),
            GroupAction(
                [look('given'), *change('lost')],
                launch_configurations={'a': 'given', 'c': 'given'},
            ),
            GroupAction(
                [look('not forwarded')],
                forwarding=False,
                launch_configurations={'b': LaunchConfiguration('a')},
            ),
            PushLaunchConfigurations(),
            PushEnvironment(),
            *change('pushed'),
            AppendEnvironmentVariable('T_A', 'more'),
            AppendEnvironmentVariable('T_A', 'first', prepend=True),
            AppendEnvironmentVariable('T_A', 'last', separator=';'),
            AppendEnvironmentVariable('T_NEW', 'alone'),
            look('pushed'),
            PopEnvironment(),
            PopLaunchConfigurations(),
            look('popped'),
            GroupAction(
                [
                    UnsetEnvironmentVariable('T_A'),
                    UnsetEnvironmentVariable('T_NOBODY'),
                    UnsetLaunchConfiguration('a'),
                    look('unset'),
                    GroupAction([ResetEnvironment(), look('reset')]),
                    ResetLaunchConfigurations({'b': 'kept'}),
                    look('kept'),
                ]
            ),
            look('end'),
        ]
    )
