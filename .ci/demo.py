#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Launch demo.yaml of sample_ws, and let its nodes talk for a while.

The exit code is 0 only if a message crossed and nothing failed.
"""

import os
from pathlib import Path
import random

SAMPLE_WS = Path(__file__).resolve().parents[1] / 'sample_ws'
#: What `double` prints for each message that it receives.
MESSAGE = 'Received .* which double is'
#: Seconds until the first message; a busy machine needs some.
TIMEOUT = 120
#: Seconds that the nodes talk for after it.
TALK_TIME = 15


def main() -> None:
    """Become the launch."""
    # apart from what else talks on this machine or in its network
    if not os.environ.get('ROS_DOMAIN_ID'):
        os.environ['ROS_DOMAIN_ID'] = str(random.randint(1, 101))
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.chdir(SAMPLE_WS)
    command = ['colcon', 'launch', 'my_pkg', 'demo.yaml', '--until', MESSAGE]
    command += ['--timeout', str(TIMEOUT), '--for', str(TALK_TIME)]
    os.execvp(command[0], command)


if __name__ == '__main__':
    main()
