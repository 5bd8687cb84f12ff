# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon launch` as the entry point of a container."""

import os

import pytest
from support.user import User


@pytest.mark.hostile
@pytest.mark.skipif(os.getuid() != 0, reason='needs a namespace of processes')
@pytest.mark.parametrize(('number', 'code'), [(15, 143), (1, 129)])
def test_signals_to_process_1_end_it(
    user: User, number: int, code: int
) -> None:
    # while the launch file is read
    script = user.write('end.sh', f'kill -{number} 1; sleep 99')
    message = f'$(command "sh {script}")'
    user.write('a.yaml', f"launch: [log: {{message: '{message}'}}]")
    container = ('unshare', '--pid', '--fork', '--mount-proc')
    started = user.start(*container, 'colcon', 'launch', 'a.yaml')
    assert started.end() == code, started.output
    assert 'Traceback' not in started.output
