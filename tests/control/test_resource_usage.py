# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What processes use of the machine."""

import os
import subprocess

from colcon_yamllaunch.control.resource_usage import usage_of


def test_usage_is_that_of_the_whole_group():
    busy = subprocess.Popen(
        ['sh', '-c', 'while :; do :; done & while :; do :; done'],
        start_new_session=True,
    )
    try:
        usage = usage_of({busy.pid})[busy.pid]
        assert usage.cpu > 0.02
        assert usage.memory > 100_000
    finally:
        os.killpg(busy.pid, 9)
        busy.wait()
    assert usage_of({busy.pid}) == {}
