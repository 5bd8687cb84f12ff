# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The clock that files get their times from."""

import time

#: CLOCK_REALTIME_COARSE of Linux, for which Python has no name.
_CLOCK = 5


def wait_for_tick() -> None:
    """Wait until a file that is written gets another time than any before."""
    before = time.clock_gettime_ns(_CLOCK)
    while time.clock_gettime_ns(_CLOCK) == before:
        time.sleep(0.001)
