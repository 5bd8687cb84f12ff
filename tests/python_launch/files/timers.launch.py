# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Timers, and what they find when their time has come."""

from launch import LaunchDescription
from launch.actions import (
    EmitEvent,
    ExecuteProcess,
    GroupAction,
    LogInfo,
    OpaqueFunction,
    SetEnvironmentVariable,
    SetLaunchConfiguration,
    TimerAction,
)
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import RosTimer


def in_time(context):
    return [
        LogInfo(msg='note: called in time'),
        ExecuteProcess(cmd=['part', 'made in time']),
    ]


def generate_launch_description():
    return LaunchDescription(
        [
            SetLaunchConfiguration('period', '0.4'),
            SetLaunchConfiguration('word', 'outside'),
            TimerAction(period=1.2, actions=[LogInfo(msg='note: the third')]),
            TimerAction(
                period=LaunchConfiguration('period'),
                actions=[
                    LogInfo(msg='note: the first'),
                    ExecuteProcess(cmd=['part', LaunchConfiguration('word')]),
                    TimerAction(
                        period=0.4, actions=[LogInfo(msg='note: the second')]
                    ),
                ],
            ),
            TimerAction(
                period=1.6, actions=[OpaqueFunction(function=in_time)]
            ),
            RosTimer(
                period=2.0,
                actions=[
                    LogInfo(msg='note: on ROS time'),
                    ExecuteProcess(cmd=['part', 'ros time', '--stay']),
                ],
            ),
            TimerAction(
                period=100.0,
                actions=[ExecuteProcess(cmd=['part', 'never'])],
            ),
            ExecuteProcess(
                cmd=['part', 'last', '--started', '5', '--ended', '2'],
                on_exit=[EmitEvent(event=Shutdown(reason='all was seen'))],
            ),
            GroupAction(
                [
                    SetEnvironmentVariable('T_GROUP', 'yes'),
                    ExecuteProcess(cmd=['part', 'in a group', '--stay']),
                ]
            ),
        ]
    )
