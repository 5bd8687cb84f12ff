# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The kernel is kept ready for moves as long as runs are short."""

import os

from colcon_yamllaunch.sweep.move_keeper import MoveKeeper
import pytest


@pytest.mark.parametrize(('seconds', 'begins'), [(0.1, True), (2.0, False)])
def test_it_is_there_for_short_runs(seconds: float, begins: bool) -> None:
    keeper = MoveKeeper()
    for _ in range(9):
        keeper.note(seconds)
    pid = keeper._pid
    try:
        assert bool(pid) == begins
    finally:
        keeper.end()
    keeper.end()
    if begins:
        # there may be other children of whoever runs the tests
        with pytest.raises(ChildProcessError):
            os.waitpid(pid, os.WNOHANG)
