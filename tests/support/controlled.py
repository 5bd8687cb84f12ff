# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A real launch, and clients of its socket."""

import os
from pathlib import Path
import time

from colcon_yamllaunch.common import files as common_files
from colcon_yamllaunch.control import socket_folder
from colcon_yamllaunch.control.client import running_launches
import pytest

ABOUT = {
    'title': 'my_pkg demo.yaml',
    'package': 'my_pkg',
    'file': '/ws/demo.yaml',
    'folder': '/ws',
}


@pytest.fixture(autouse=True)
def no_shared_folders(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have no folder for sockets but those that a test names."""
    monkeypatch.setattr(socket_folder, 'USER_FOLDERS', '/does/not/exist')
    monkeypatch.setattr(common_files, 'SHARED_FOLDERS', ())


class Controlled:
    """A launch that others see, and a client of it."""

    def __init__(self, one, wait_until):
        self.one = one
        self.wait_until = wait_until
        # apart from other launches of the user
        self.place = dict.fromkeys(
            ('TMPDIR', 'XDG_RUNTIME_DIR'), str(one.folder)
        )
        self.folder = one.folder / f'colcon-launch-{os.getuid()}'
        self.clients = []
        self.client = self.connect()

    def connect(self):
        def one_launch():
            return running_launches(self.place, pytest.fail)

        (client,) = self.wait_until(one_launch)
        self.clients.append(client)
        return client

    def raw(self):
        """Return a connection that says what the test wants."""
        return self.connect().connection

    def process(self, label):
        state = self.client.refresh()
        return next(p for p in state.processes if p.label == label)

    def becomes(self, label, phase):
        """Wait until a process is in a phase."""
        self.wait_until(lambda: self.process(label).phase == phase)
        return self.process(label)


def memory_of(pid):
    fields = Path(f'/proc/{pid}/statm').read_text().split()
    return int(fields[1]) * os.sysconf('SC_PAGE_SIZE')


def idles(pid):
    """Tell whether a process hardly computes, as one that spins would."""

    def ticks():
        stat = Path(f'/proc/{pid}/stat').read_text().rpartition(') ')[2]
        return sum(map(int, stat.split()[11:13]))

    before = ticks()
    time.sleep(0.5)
    return ticks() - before < 0.3 * os.sysconf('SC_CLK_TCK')


def answer_to(client, name, **more):
    """Return the answer to a request, also while events arrive."""
    answers = []
    client.send_request(name, answers.append, **more)
    while not answers:
        client.read()
        list(client.received())
    return answers[0]
