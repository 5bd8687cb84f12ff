# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Each substitution of ROS 2, in the command line of one process."""

from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    ExecuteProcess,
    SetEnvironmentVariable,
    SetLaunchConfiguration,
)
from launch.substitutions import (
    AndSubstitution,
    AnonName,
    Command,
    EnvironmentVariable,
    EqualsSubstitution,
    FindExecutable,
    IfElseSubstitution,
    LaunchConfiguration,
    NotEqualsSubstitution,
    NotSubstitution,
    OrSubstitution,
    PathJoinSubstitution,
    PythonExpression,
    TextSubstitution,
    ThisLaunchFile,
    ThisLaunchFileDir,
)
from launch_ros.actions import SetParameter
from launch_ros.substitutions import (
    ExecutableInPackage,
    FindPackagePrefix,
    FindPackageShare,
    Parameter,
)


def generate_launch_description():
    side = LaunchConfiguration('side')
    return LaunchDescription(
        [
            DeclareLaunchArgument('side', default_value='left'),
            DeclareLaunchArgument(
                'arm', default_value=[side, '_arm'], description='An arm'
            ),
            SetLaunchConfiguration('flag', 'True'),
            SetEnvironmentVariable('T_SET', ['at ', side]),
            SetParameter('speed', 2.5),
            ExecuteProcess(
                cmd=[
                    ExecutableInPackage('part', 'robot_parts'),
                    side,
                    [LaunchConfiguration('arm'), TextSubstitution(text='!')],
                    LaunchConfiguration('nobody', default='default'),
                    PathJoinSubstitution(
                        [FindPackageShare('robot_parts'), 'config', side]
                    ),
                    FindPackagePrefix('robot_parts'),
                    FindExecutable(name='part'),
                    EnvironmentVariable('T_SET'),
                    EnvironmentVariable('T_NONE', default_value='none'),
                    Command(['echo ', side, ' of echo']),
                    PythonExpression(['"', side, '" + str(2 ** 5)']),
                    PythonExpression(['sys.maxsize > 1'], ['sys']),
                    PythonExpression(
                        [
                            '"',
                            AnonName('eye'),
                            '" == "',
                            AnonName('eye'),
                            '"',
                        ]
                    ),
                    ThisLaunchFileDir(),
                    ThisLaunchFile(),
                    NotSubstitution(LaunchConfiguration('flag')),
                    AndSubstitution(LaunchConfiguration('flag'), 'true'),
                    OrSubstitution('false', LaunchConfiguration('flag')),
                    EqualsSubstitution(side, 'left'),
                    NotEqualsSubstitution(side, 'left'),
                    IfElseSubstitution(
                        LaunchConfiguration('flag'), 'so', 'otherwise'
                    ),
                    Parameter('speed'),
                    ['', ''],
                    'two words',
                    '"quoted" \'words\' \\ $HOME',
                    'grüße',
                ],
            ),
        ]
    )
