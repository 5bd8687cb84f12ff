# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A real launch on the full screen."""

import os
import signal

from colcon_yamllaunch.control.subscription import BEGINNING
from colcon_yamllaunch.terminal.full_screen.launch_screen import LaunchApp
import pytest
from support.shown_screen import Around, run_app

#: Writes as fast as it can, until a file is there.
FLOOD = (
    'import os, sys\n'
    'while not os.path.exists(sys.argv[1]):\n'
    '    os.write(1, b"x" * 99 + b"\\n")\n'
    'os.write(1, b"dry\\n")\n'
    'import time; time.sleep(99)\n'
)


@pytest.mark.full
def test_a_launch_is_shown_from_its_beginning_to_its_end(controlled, sh):
    c = controlled(sh('a', 'echo one; sleep 99'), sh('b', 'echo two; exit 3'))
    c.becomes('b', 'ended')
    c.client.subscribe(BEGINNING, states=True)
    app = LaunchApp(c.client, Around())
    # others may look, too
    other = c.connect()
    other.subscribe()
    model = app.panes.model

    def lines():
        return [(line.label, line.text) for line in model.view.lines]

    async def act(shown):
        await shown.until(lambda: ('a', 'one') in lines() and model.tree)
        assert model.failed == {'b'}
        await shown.until(lambda: model.usage.get('a'))
        pid = model.member('a').pid
        await shown.types('r')
        await shown.until(lambda: model.member('a').pid not in (None, pid))
        await shown.types('s')
        await shown.until(
            lambda: model.state.exit_code is not None and model.ending
        )
        assert ('b', 'two') in lines()

    run_app(app, act)
    assert c.one.ends() == 1
    other.close()


@pytest.mark.full
def test_a_flood_drowns_neither_the_screen_nor_the_launch(
    controlled, python, tmp_path
):
    dry = tmp_path / 'dry'
    flood = python('a', FLOOD, output='own_log')
    flood['argv'].append(str(dry))
    c = controlled(flood)
    c.becomes('a', 'running')
    c.client.subscribe(states=True)
    app = LaunchApp(c.client, Around())
    model = app.panes.model

    async def act(shown):
        await shown.until(lambda: model.missed_bytes > 1 << 20)
        assert model.store.size < 1 << 24
        await shown.types('L', 'L')
        await shown.until(lambda: 'level WARN' in model.view.filtering.text)
        dry.touch()
        await shown.types('escape')
        await shown.until(lambda: model.view.lines[-1].text == 'dry')
        os.kill(c.one.popen.pid, signal.SIGKILL)
        await shown.until(lambda: model.ending)
        assert 'launcher is gone' in model.ending

    run_app(app, act)
