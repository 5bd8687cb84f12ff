# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Handlers for the start and the end of processes."""

from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    ExecuteProcess,
    GroupAction,
    LogInfo,
    RegisterEventHandler,
    SetLaunchConfiguration,
    TimerAction,
    UnregisterEventHandler,
)
from launch.event_handlers import OnProcessExit, OnProcessStart
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node, PushRosNamespace


def ended(event, context):
    context.launch_configurations['code'] = str(event.returncode)
    return [
        LogInfo(msg=f'note: the second ended with {event.returncode}'),
        ExecuteProcess(cmd=['part', 'third', LaunchConfiguration('code')]),
    ]


def of_third(action):
    return 'third' in str(getattr(action, 'process_details', {}).get('cmd'))


def generate_launch_description():
    first = ExecuteProcess(cmd=['part', 'first'])
    second = ExecuteProcess(cmd=['part', 'second', '--exit', '7'])
    never = OnProcessExit(
        target_action=first,
        on_exit=[ExecuteProcess(cmd=['part', 'never'])],
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument('word', default_value='default'),
            RegisterEventHandler(never),
            RegisterEventHandler(
                OnProcessStart(
                    target_action=first,
                    on_start=[
                        LogInfo(msg='note: the first has started'),
                        SetLaunchConfiguration('word', 'set by a handler'),
                    ],
                )
            ),
            RegisterEventHandler(
                OnProcessStart(
                    target_action=second,
                    on_start=lambda event, context: LogInfo(
                        msg=f'note: {event.process_name} has started'
                    ),
                )
            ),
            RegisterEventHandler(
                OnProcessExit(
                    target_action=first,
                    on_exit=[
                        GroupAction(
                            [
                                PushRosNamespace('behind'),
                                second,
                                Node(
                                    package='robot_parts',
                                    executable='part',
                                    name='beside',
                                    arguments=[LaunchConfiguration('word')],
                                ),
                            ]
                        )
                    ],
                )
            ),
            RegisterEventHandler(
                OnProcessExit(target_action=second, on_exit=ended)
            ),
            RegisterEventHandler(
                OnProcessExit(
                    target_action=of_third,
                    on_exit=[
                        TimerAction(
                            period=0.1,
                            actions=[
                                ExecuteProcess(
                                    cmd=['part', 'fourth'],
                                    on_exit=lambda event, context: LogInfo(
                                        msg=f'note: {event.process_name} was '
                                        'the last'
                                    ),
                                )
                            ],
                        )
                    ],
                    handle_once=True,
                )
            ),
            UnregisterEventHandler(never),
            first,
        ]
    )
