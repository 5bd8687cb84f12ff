# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Handlers for what processes write, and for actions that are complete."""

from launch import LaunchDescription
from launch.actions import (
    ExecuteProcess,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
    Shutdown,
)
from launch.event_handlers import OnExecutionComplete, OnProcessIO

SEEN = []


def on_stdout(event):
    text = event.text.decode().strip()
    SEEN.append(text)
    if text == 'said: ready':
        return [ExecuteProcess(cmd=['part', 'when ready'])]
    return None


def on_stderr(event):
    if 'trouble' in event.text.decode():
        return Shutdown(reason='there is trouble')
    return None


def tell(context):
    return [LogInfo(msg='note: a function has run')]


def generate_launch_description():
    speaker = ExecuteProcess(
        cmd=[
            'part',
            'speaker',
            '--say',
            'ready',
            '--started',
            '3',
            '--ended',
            '1',
            '--warn',
            'trouble',
            '--stay',
        ],
        output='screen',
    )
    function = OpaqueFunction(function=tell)
    return LaunchDescription(
        [
            RegisterEventHandler(
                OnProcessIO(
                    target_action=speaker,
                    on_stdout=on_stdout,
                    on_stderr=on_stderr,
                )
            ),
            RegisterEventHandler(
                OnExecutionComplete(
                    target_action=function,
                    on_completion=[
                        ExecuteProcess(cmd=['part', 'complete', '--stay'])
                    ],
                )
            ),
            function,
            speaker,
        ]
    )
