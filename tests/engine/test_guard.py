# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import os
import signal

from colcon_yamllaunch.common.escalation import Timeouts
from colcon_yamllaunch.engine.guard import GuardedLaunch
from colcon_yamllaunch.engine.guard_link import GuardLink, GuardProcess
from colcon_yamllaunch.engine.own_files import OwnFile
import pytest


def test_the_guard_knows_what_it_was_told():
    launch = GuardedLaunch('identity', 1)
    for frame in (
        ['start', 0, 100, 5.0, 2.5],
        ['start', 1, 200, 1.0, 1.0],
        ['folder', '/tmp/a\nfolder', 7, 8],
        ['adopted', 300, 99, 1],
        ['end', 100],
        ['end', 300],
        ['something newer'],
    ):
        launch.note(frame, [])
    assert launch.started_groups == {200: 1}
    assert launch.timeouts == {0: Timeouts(5.0, 2.5), 1: Timeouts(1.0, 1.0)}
    assert launch.own_files == {'folder': [OwnFile('/tmp/a\nfolder', 7, 8)]}
    assert launch.known == {(300, 99): 1}


def test_the_guard_closes_what_the_launcher_closes():
    launch = GuardedLaunch('identity', 1)
    reader, writer = os.pipe()
    launch.note(['output', 17, 0, 'a', [], None], [reader])
    # one that came without a descriptor, as there were too many
    launch.note(['output', 18, 0, 'a', [], None], [])
    assert list(launch.outputs) == [17]
    for key in (17, 17, 18):
        launch.note(['closed', key], [])
    assert launch.outputs == {}
    with pytest.raises(BrokenPipeError):
        os.write(writer, b'x')
    os.close(writer)


def test_guard_process_guards_one_launch_after_another():
    process = GuardProcess(is_kept=True)
    try:
        first = GuardLink(f'{1:016x}', process)
        first.start()
        pid = first.pid
        first.dismiss()
        second = GuardLink(f'{2:016x}', process)
        second.start()
        assert second.pid == pid
        # Ctrl-C and the like are for others
        os.kill(pid, signal.SIGTERM)
        os.kill(pid, signal.SIGKILL)
        assert os.waitpid(pid, 0)[1] == signal.SIGKILL
        second.restart()
        assert second.pid != pid
        second.dismiss()
    finally:
        process.close()
        _, status = os.waitpid(process.pid, 0)
    assert status == 0
