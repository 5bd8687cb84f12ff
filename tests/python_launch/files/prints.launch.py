# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A file that prints, warns and logs while it is read."""

import logging
import os
import subprocess
import sys
import warnings

from launch import LaunchDescription
from launch.actions import ExecuteProcess, OpaqueFunction
from launch.logging import get_logger
from launch.substitutions import LaunchConfiguration

print('printed: at the import')
subprocess.run(['echo', 'printed: by a program'], check=True)
os.write(1, b'printed: past Python\n')


def talk(context):
    print('printed: in a function')
    sys.stdout.write('printed: {"say": "done", "id": 1}\n')
    print('printed: to standard error', file=sys.stderr)
    get_logger('somebody').info('printed: by a logger of launch')
    logging.getLogger('other').warning('printed: by a logger')
    warnings.warn('printed: a warning', stacklevel=1)
    # nothing comes from there, and nobody waits
    line = sys.stdin.readline() if not sys.stdin.isatty() else ''
    return [ExecuteProcess(cmd=['part', 'input', repr(line)])]


def generate_launch_description():
    print('printed: in generate_launch_description')
    return LaunchDescription(
        [
            OpaqueFunction(function=talk),
            ExecuteProcess(
                cmd=['part', LaunchConfiguration('word', default='end')]
            ),
        ]
    )
