# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Where the output of processes goes, and what launch files say."""

from launch import LaunchDescription
from launch.actions import ExecuteProcess, LogInfo
from launch.substitutions import EnvironmentVariable, LaunchConfiguration


def speak(word, **more):
    return ExecuteProcess(
        cmd=['part', '--say', f'{word} out', '--warn', f'{word} err'],
        **more,
    )


def generate_launch_description():
    return LaunchDescription(
        [
            LogInfo(msg='note: first'),
            LogInfo(
                msg=[
                    'note: home of ',
                    EnvironmentVariable('T_NOBODY', default_value='nobody'),
                ]
            ),
            speak('default'),
            speak('screen', output='screen'),
            speak('log', output='log'),
            speak('both', output='both'),
            speak('own_log', output='own_log'),
            speak('full', output='full'),
            speak(
                'substituted',
                output=LaunchConfiguration('output', default='screen'),
            ),
            speak(
                'dictionary', output={'stdout': 'screen', 'stderr': 'screen'}
            ),
            speak('terminal', output='screen', emulate_tty=True),
            speak('cached', output='screen', cached_output=True),
            LogInfo(msg='note: last'),
        ]
    )
