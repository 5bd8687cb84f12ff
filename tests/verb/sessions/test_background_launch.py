# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon launch --ui`, with what is to be launched and without."""

from collections.abc import Callable
import importlib.util
import os
from pathlib import Path
import re
import signal
import time

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.control.client import running_launches
from colcon_yamllaunch.engine.commands import Shutdown
from colcon_yamllaunch.terminal.full_screen.session import MISSING, need_screen
import pytest
from support.terminal import DEADLINE, Terminal
from support.user import User

TWO = """\
launch:
- executable: {cmd: sleep 4321, name: kitchen, output: screen}
- executable: {cmd: sh -c 'echo bo''om; exit 3', name: bomb}
"""


def test_a_new_launch_is_shown_and_stopped(
    user: User, terminal: Callable[..., Terminal]
) -> None:
    user.write('two.yaml', TWO)
    t = terminal('--ui', 'two.yaml').shows('kitchen-1').shows('1 failed')
    t.types('q').shows('leave it running').types('s')
    assert t.ends() == 1
    # how it ended is told where one can still read it
    end = t.screen.rpartition('failed: bomb-2 exited with code 3')[2]
    assert 'stdout_stderr.log' in end
    assert '\x1b[?1049' not in end
    assert t.modes() == t.modes_before
    assert running_launches(user.environment, pytest.fail) == []


def test_a_new_launch_is_left_running_and_shown_again(
    user: User, terminal: Callable[..., Terminal]
) -> None:
    user.write('two.yaml', TWO)
    t = terminal('--ui', 'two.yaml').shows('kitchen-1')
    t.types('q').shows('leave it running').types('l')
    assert t.ends() == 0
    assert 'the launch runs on: colcon launch --ui --of' in t.screen
    assert t.modes() == t.modes_before
    second = terminal('--ui').shows('kitchen-1').shows('q ')
    (launch,) = running_launches(user.environment, pytest.fail)
    launch.do(Shutdown())
    launch.close()
    second.shows('exit code 1').types('\x03')
    assert second.ends() == 0


def test_a_new_launch_ends_with_its_terminal(
    user: User, terminal: Callable[..., Terminal]
) -> None:
    user.write('two.yaml', TWO)
    t = terminal('--ui', 'two.yaml').shows('[?1049h').shows('kitchen-1')
    assert t.hangs_up() == 128 + signal.SIGHUP
    deadline = time.monotonic() + DEADLINE
    while launches := running_launches(user.environment, pytest.fail):
        for launch in launches:
            launch.close()
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_what_cannot_be_launched_is_told_as_ever(
    user: User, terminal: Callable[..., Terminal]
) -> None:
    user.write('two.yaml', 'launch: 5\n')
    t = terminal('--ui', 'two.yaml')
    assert t.ends() == 1
    assert 'two.yaml:1:9: error:' in t.screen
    assert '\x1b[?1049h' not in t.screen


def test_what_is_missing_is_told_with_the_way_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with pytest.raises(UserError, match='--ui needs a terminal, but'):
        monkeypatch.setattr(os, 'isatty', lambda _: False)
        need_screen({'TERM': 'xterm'})
    monkeypatch.setattr(os, 'isatty', lambda _: True)
    with pytest.raises(UserError, match='TERM says'):
        need_screen({'TERM': 'dumb'})
    need_screen({'TERM': 'xterm'})
    monkeypatch.setattr(importlib.util, 'find_spec', lambda _: None)
    with pytest.raises(UserError) as caught:
        need_screen({'TERM': 'xterm'})
    assert str(caught.value) == MISSING
    required = (Path(__file__).parents[3] / 'setup.cfg').read_text()
    (requirement,) = re.findall(r"pip install '(.*)'", MISSING)
    assert f'\n    {requirement}\n' in required


def test_what_is_wrong_with_a_change_is_shown_again(
    user: User, terminal: Callable[..., Terminal]
) -> None:
    user.write('two.yaml', TWO)
    t = terminal('--watch', 'two.yaml').shows('kitchen-1').shows('? help')
    user.write('two.yaml', 'launch: 5\n')
    error = 'two.yaml:1:9: error:'
    t.shows(error).shows('E errors').types('E').shows(error, times=2)
    t.types('qq')
    assert t.ends() == 1
