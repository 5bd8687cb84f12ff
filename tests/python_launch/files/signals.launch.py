# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Processes that are signalled and stopped by handlers."""

import signal

from launch import LaunchDescription
from launch.actions import EmitEvent, ExecuteProcess, RegisterEventHandler
from launch.event_handlers import OnProcessExit, OnProcessIO
from launch.events import matches_action
from launch.events.process import ShutdownProcess, SignalProcess


def generate_launch_description():
    stubborn = ExecuteProcess(
        cmd=['part', 'stubborn', '--stubborn'], sigterm_timeout='0.5'
    )
    stopped = ExecuteProcess(
        cmd=['part', 'stopped', '--say', 'here', '--stay']
    )
    watcher = ExecuteProcess(
        cmd=['part', 'watcher', '--started', '3', '--say', 'all here']
    )
    ended = ExecuteProcess(cmd=['part', 'kill', '--ended', '2'])
    return LaunchDescription(
        [
            RegisterEventHandler(
                OnProcessExit(
                    target_action=watcher,
                    on_exit=[
                        EmitEvent(
                            event=SignalProcess(
                                signal_number=signal.SIGTERM,
                                process_matcher=matches_action(stubborn),
                            )
                        ),
                        EmitEvent(
                            event=ShutdownProcess(
                                process_matcher=matches_action(stopped)
                            )
                        ),
                        ended,
                    ],
                )
            ),
            RegisterEventHandler(
                OnProcessExit(
                    target_action=ended,
                    on_exit=[
                        EmitEvent(
                            event=SignalProcess(
                                signal_number=signal.SIGKILL,
                                process_matcher=matches_action(stubborn),
                            )
                        )
                    ],
                )
            ),
            RegisterEventHandler(
                OnProcessIO(
                    target_action=stopped, on_stdout=lambda event: None
                )
            ),
            stubborn,
            stopped,
            watcher,
        ]
    )
