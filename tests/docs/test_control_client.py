# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The client in plain Python in docs/control.md works as printed."""

import os
from pathlib import Path
import re
import signal
import subprocess
import sys

from support.controlled import ABOUT

PAGE = Path(__file__).parents[2] / 'docs/control.md'


def test_printed_client_restarts_a_killed_process(
    launch, sleep, wait_until, tmp_path
):
    text = PAGE.read_text(encoding='utf-8')
    code = re.search(r'^```python (\w+\.py)\n(.*?)^```$', text, re.M | re.S)
    assert code is not None
    client = tmp_path / code[1]
    client.write_text(code[2], encoding='utf-8')
    # a launch ends when nothing of it runs any more
    one = launch(sleep('kitchen'), sleep('cellar'), about=ABOUT)
    place = one.folder / f'colcon-launch-{os.getuid()}'
    path = wait_until(lambda: next(place.glob('*.sock'), None))
    with subprocess.Popen(
        [sys.executable, '-I', client, path],
        stdout=subprocess.PIPE,
        text=True,
    ) as popen:
        try:
            first, _ = wait_until(
                lambda: one.events('started')[1:] and one.events('started')
            )
            assert popen.stdout is not None
            assert popen.stdout.readline() == 'watching my_pkg demo.yaml\n'
            os.kill(first['pid'], signal.SIGKILL)
            wait_until(lambda: len(one.events('started')) == 3)
            one.popen.send_signal(signal.SIGINT)
            one.ends()
            output, _ = popen.communicate(timeout=60)
        finally:
            popen.kill()
    assert output == 'kitchen was killed\nthe launch has ended\n'
