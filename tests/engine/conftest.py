# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import pytest
from support.history import History


@pytest.fixture
def history():
    """Return a function that begins a launch without a process."""

    def begin(*entries, refused=()):
        made = History(*entries)
        made.host.refused.update(refused)
        made.turn()
        return made

    return begin
