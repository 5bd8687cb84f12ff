# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import pytest
from support.controlled import ABOUT, Controlled, no_shared_folders

__all__ = ['no_shared_folders']


@pytest.fixture
def controlled(launch, wait_until):
    made = []

    def start(*entries, **settings):
        one = launch(*entries, about=ABOUT, **settings)
        made.append(Controlled(one, wait_until))
        return made[-1]

    yield start
    for one in made:
        for client in one.clients:
            client.close()


@pytest.fixture(scope='module')
def shared(launch_type, tmp_path_factory, wait_until):
    folder = tmp_path_factory.mktemp('shared')
    entries = [{'label': 'a', 'argv': ['sleep', '9999']}]
    one = launch_type(folder / 'launch', entries, about=ABOUT)
    made = Controlled(one, wait_until)
    yield made
    made.client.close()
    one.clean_up()


@pytest.fixture
def idle(shared):
    """Return a launch of `a`, for tests that leave it as it was."""
    shared.becomes('a', 'running')
    yield shared
    for client in shared.clients[1:]:
        client.close()
    del shared.clients[1:]
    assert shared.process('a').phase == 'running'
