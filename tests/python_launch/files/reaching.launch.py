# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What actions of ROS 2 in Python set for files in YAML and XML."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import AnyLaunchDescriptionSource
from launch_ros.actions import (
    PushRosNamespace,
    SetParameter,
    SetParametersFromFile,
    SetRemap,
)

HERE = Path(__file__).parent


def generate_launch_description():
    return LaunchDescription(
        [
            PushRosNamespace('outer'),
            SetParameter('rate', 4),
            SetParameter('text', 'four'),
            SetParametersFromFile(str(HERE / 'parameters/more.yaml')),
            SetRemap('image', 'raw'),
            *(
                IncludeLaunchDescription(
                    AnyLaunchDescriptionSource(
                        str(HERE / 'included' / f'eye.launch.{suffix}')
                    )
                )
                for suffix in ('yaml', 'xml')
            ),
        ]
    )
