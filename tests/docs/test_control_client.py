# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The clients in docs work as printed."""

import os
from pathlib import Path
import re
import signal
import subprocess
import sys

import pytest
from support.controlled import ABOUT

DOCS = Path(__file__).parents[2] / 'docs'


@pytest.mark.parametrize(
    ('page', 'is_isolated'),
    # the first uses nothing of the project, the other finds the socket
    [('control.md', True), ('python_client.md', False)],
)
def test_printed_client_restarts_a_killed_process(
    launch, sleep, wait_until, tmp_path, page, is_isolated
):
    text = (DOCS / page).read_text(encoding='utf-8')
    code = re.search(r'^```python (\w+\.py)\n(.*?)^```$', text, re.M | re.S)
    assert code is not None
    client = tmp_path / code[1]
    client.write_text(code[2], encoding='utf-8')
    # a launch ends when nothing of it runs any more
    one = launch(sleep('kitchen'), sleep('cellar'), about=ABOUT)
    place = one.folder / f'colcon-launch-{os.getuid()}'
    path = wait_until(lambda: next(place.glob('*.sock'), None))
    # not the whole path, which may be too long for a socket
    words = ['-I', client, path.name] if is_isolated else [client]
    # apart from other launches of the user
    names = ('TMPDIR', 'XDG_RUNTIME_DIR')
    with subprocess.Popen(
        [sys.executable, *words],
        cwd=place,
        env={**os.environ, **dict.fromkeys(names, str(one.folder))},
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
