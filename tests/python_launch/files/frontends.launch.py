# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""YAML and XML files that a launch file in Python includes."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import (
    ExecuteProcess,
    GroupAction,
    IncludeLaunchDescription,
    SetEnvironmentVariable,
)
from launch.launch_description_sources import (
    AnyLaunchDescriptionSource,
    FrontendLaunchDescriptionSource,
)
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import PushRosNamespace
from launch_xml.launch_description_sources import XMLLaunchDescriptionSource
from launch_yaml.launch_description_sources import YAMLLaunchDescriptionSource


def file(name):
    return str(Path(__file__).parent / 'included' / name)


def look(word):
    return ExecuteProcess(
        cmd=[
            'part',
            word,
            LaunchConfiguration('side', default='no side'),
            LaunchConfiguration('set_by_yaml', default='not set'),
        ]
    )


def generate_launch_description():
    return LaunchDescription(
        [
            SetEnvironmentVariable('T_OUTER', 'yes'),
            GroupAction(
                [
                    PushRosNamespace('outer'),
                    IncludeLaunchDescription(
                        AnyLaunchDescriptionSource(file('eye.launch.yaml')),
                        launch_arguments={'side': 'left'}.items(),
                    ),
                    look('behind yaml'),
                ]
            ),
            look('outside'),
            GroupAction(
                [
                    IncludeLaunchDescription(
                        YAMLLaunchDescriptionSource(file('eye.launch.yaml')),
                        launch_arguments={'side': ''}.items(),
                    )
                ]
            ),
            GroupAction(
                [
                    IncludeLaunchDescription(
                        XMLLaunchDescriptionSource(file('eye.launch.xml')),
                        launch_arguments={'side': 'right'}.items(),
                    )
                ]
            ),
            IncludeLaunchDescription(
                FrontendLaunchDescriptionSource(file('eye.launch.xml'))
            ),
            look('end'),
        ]
    )
