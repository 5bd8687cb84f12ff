# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What ROS 2's own actions set for the nodes behind them."""

from launch import LaunchDescription
from launch.actions import ExecuteProcess, GroupAction, SetEnvironmentVariable
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import (
    Node,
    PushRosNamespace,
    SetParameter,
    SetParametersFromFile,
    SetRemap,
)
from launch_ros.substitutions import FindPackageShare


def node(name, **more):
    return Node(package='robot_parts', executable='part', name=name, **more)


def generate_launch_description():
    gains = PathJoinSubstitution(
        [FindPackageShare('robot_parts'), 'config', 'gains.yaml']
    )
    return LaunchDescription(
        [
            node('before'),
            SetParameter(name='use_sim_time', value=True),
            SetParameter(
                name='rate', value=LaunchConfiguration('rate', default='5')
            ),
            GroupAction(
                [
                    PushRosNamespace('arm'),
                    SetRemap('image', 'raw'),
                    SetRemap(src='/tf', dst='tf'),
                    SetParametersFromFile(gains),
                    SetParameter('rate', 7),
                    node('camera', remappings=[('image', 'own'), ('b', 'c')]),
                    node('away', namespace='/elsewhere'),
                    node('below', namespace='hand', parameters=[{'rate': 9}]),
                    GroupAction(
                        [
                            PushRosNamespace('finger'),
                            SetEnvironmentVariable('T_FINGER', 'yes'),
                            node('tip'),
                            Node(package='robot_parts', executable='part'),
                        ]
                    ),
                    GroupAction([PushRosNamespace('/root'), node('absolute')]),
                ]
            ),
            node('after'),
            ExecuteProcess(cmd=['part', 'no_node']),
        ]
    )
