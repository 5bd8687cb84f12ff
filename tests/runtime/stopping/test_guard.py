# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from colcon_yamllaunch.common.escalation import Timeouts
from colcon_yamllaunch.runtime.stopping.guard import GuardedLaunch


def test_the_guard_knows_what_it_was_told():
    launch = GuardedLaunch('identity', 1)
    for line in (
        'start 0 100 5.0 2.5',
        'start 1 200 1.0 1.0',
        'folder /tmp/a folder',
        'end 100',
        'end 300',
        'something newer',
    ):
        launch.note(line)
    assert launch.made == {200: 1}
    assert launch.timeouts == {0: Timeouts(5.0, 2.5), 1: Timeouts(1.0, 1.0)}
    assert launch.folder == '/tmp/a folder'
