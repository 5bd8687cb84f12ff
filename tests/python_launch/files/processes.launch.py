# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Programs that are no nodes, with all that may be said of them."""

from launch import LaunchDescription
from launch.actions import ExecuteLocal, ExecuteProcess
from launch.descriptions import Executable
from launch.substitutions import EnvironmentVariable, ThisLaunchFileDir


def generate_launch_description():
    return LaunchDescription(
        [
            ExecuteProcess(
                cmd=['part', 'plain', ['a', 'b'], 'two words'],
                name='named',
                cwd=[ThisLaunchFileDir(), '/parameters'],
                additional_env={'T_B': 'more'},
                output='screen',
                log_cmd=True,
                sigterm_timeout='2',
                sigkill_timeout='3',
            ),
            ExecuteProcess(
                cmd=['part', 'env'],
                env={
                    'RECORDS': EnvironmentVariable('RECORDS'),
                    'PATH': EnvironmentVariable('PATH'),
                    'T_ALONE': 'yes',
                },
            ),
            ExecuteProcess(
                cmd=['T_SHELL=yes part shell | cat && part $((1 + 2)) "a  b"'],
                shell=True,
            ),
            ExecuteProcess(cmd=['part', 'a && b'], prefix='env T_PREFIX=yes'),
            ExecuteProcess(cmd=['part', 'terminal'], emulate_tty=True),
            ExecuteLocal(
                process_description=Executable(
                    cmd=['part', 'local'], additional_env={'T_LOCAL': 'yes'}
                ),
                output='log',
            ),
        ]
    )
