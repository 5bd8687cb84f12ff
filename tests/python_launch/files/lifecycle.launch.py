# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Lifecycle nodes, the transitions asked for, and those waited for."""

from launch import LaunchDescription
from launch.actions import EmitEvent, LogInfo, RegisterEventHandler, Shutdown
from launch.event_handlers import OnProcessStart
from launch.events import matches_action
from launch_ros.actions import LifecycleNode, LifecycleTransition, Node
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from lifecycle_msgs.msg import Transition


def change(node, transition):
    return EmitEvent(
        event=ChangeState(
            lifecycle_node_matcher=matches_action(node),
            transition_id=transition,
        )
    )


def generate_launch_description():
    first = LifecycleNode(
        package='robot_parts', executable='cycle', name='first', namespace=''
    )
    second = LifecycleNode(
        package='robot_parts',
        executable='cycle',
        name='second',
        namespace='deep',
    )
    return LaunchDescription(
        [
            RegisterEventHandler(
                OnProcessStart(
                    target_action=first,
                    on_start=[change(first, Transition.TRANSITION_CONFIGURE)],
                )
            ),
            RegisterEventHandler(
                OnStateTransition(
                    target_lifecycle_node=first,
                    start_state='configuring',
                    goal_state='inactive',
                    entities=[
                        LogInfo(msg='note: first is inactive'),
                        change(first, Transition.TRANSITION_ACTIVATE),
                    ],
                )
            ),
            RegisterEventHandler(
                OnStateTransition(
                    target_lifecycle_node=first,
                    goal_state='active',
                    entities=[
                        LogInfo(msg='note: first is active'),
                        second,
                        LifecycleTransition(
                            lifecycle_node_names=['/deep/second'],
                            transition_ids=[
                                Transition.TRANSITION_CONFIGURE,
                                Transition.TRANSITION_ACTIVATE,
                            ],
                        ),
                        RegisterEventHandler(
                            OnStateTransition(
                                target_lifecycle_node=second,
                                goal_state='active',
                                entities=[
                                    LogInfo(msg='note: second is active'),
                                    Node(
                                        package='robot_parts',
                                        executable='part',
                                        name='last',
                                        on_exit=Shutdown(),
                                    ),
                                ],
                            )
                        ),
                    ],
                )
            ),
            first,
        ]
    )
