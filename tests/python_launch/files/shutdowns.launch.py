# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What happens at the end of a launch, and events of one's own."""

from launch import Event, EventHandler, LaunchDescription
from launch.actions import (
    EmitEvent,
    ExecuteProcess,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
    Shutdown,
)
from launch.event_handlers import OnProcessExit, OnShutdown
from launch.substitutions import LocalSubstitution


class Docked(Event):
    """The robot has come home."""

    name = 'robot_extras.Docked'

    def __init__(self, place):
        self.place = place


def on_shutdown(event, context):
    return [LogInfo(msg=f'note: ends, as {event.reason}')]


def docked(context):
    place = context.locals.event.place
    return [
        LogInfo(msg=f'note: docked in the {place}'),
        ExecuteProcess(
            cmd=['part', 'docked', place],
            on_exit=Shutdown(reason='the robot is at home'),
        ),
    ]


def generate_launch_description():
    # `stays` is to have begun before the launch ends
    drive = ExecuteProcess(cmd=['part', 'drive', '--started', '2'])
    return LaunchDescription(
        [
            RegisterEventHandler(
                OnShutdown(
                    on_shutdown=[
                        LogInfo(
                            msg=[
                                'note: because ',
                                LocalSubstitution('event.reason'),
                            ]
                        )
                    ]
                )
            ),
            RegisterEventHandler(OnShutdown(on_shutdown=on_shutdown)),
            RegisterEventHandler(
                EventHandler(
                    matcher=lambda event: isinstance(event, Docked),
                    entities=[OpaqueFunction(function=docked)],
                )
            ),
            RegisterEventHandler(
                OnProcessExit(
                    target_action=drive,
                    on_exit=[EmitEvent(event=Docked('kitchen'))],
                )
            ),
            drive,
            ExecuteProcess(cmd=['part', 'stays', '--stay']),
        ]
    )
