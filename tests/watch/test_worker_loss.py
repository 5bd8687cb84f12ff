# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What follows from changes when what prepares launches was killed."""

from pathlib import Path

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.watch.changes import Batch
from colcon_yamllaunch.watch.changes import Change
from colcon_yamllaunch.watch.knowledge import Knowledge
from colcon_yamllaunch.watch.knowledge import PackageUse
from colcon_yamllaunch.watch.knowledge import ProcessUse
from colcon_yamllaunch.watch.watching import Watching
import pytest

SCRIPT, SOURCE = '/ws/src/arm/a.py', '/ws/src/arm/a.cpp'
LAUNCH_FILE = '/ws/src/arm/demo.yaml'
WORKER = 77


class PlayedWorker:
    """A worker that is at a job for ever, or has been killed."""

    job_descriptors = ()
    descriptor = -1
    written = b''

    def __init__(self):
        self.pid = WORKER
        self.asked = 0

    def ask(self, _):
        self.asked += 1

    def take(self):
        # what the socket of a job that was killed says
        raise EOFError

    def forget(self):
        pass

    def lost(self):
        self.pid = 0


class PlayedLaunch:
    """A launch in which all goes well."""

    def __init__(self):
        self.told = []
        self.restarted = []

    def tell(self, event):
        if isinstance(event, events.Watched):
            self.told.append((event.failed, event.text.rpartition(' (')[0]))

    def groups(self):
        return {}

    def release_group(self, group):
        pass

    def restart(self, labels):
        self.restarted += labels
        return ()


class Story:
    def __init__(self, *, reads_more=False):
        self.worker, self.launch = PlayedWorker(), PlayedLaunch()
        knowledge = Knowledge(
            (ProcessUse('a', SCRIPT, 'arm'),),
            (PackageUse('arm', '/ws/src/arm', frozenset(('a.py',))),),
            frozenset((LAUNCH_FILE,)),
            reads_more=reads_more,
        )
        self.watching = Watching(
            Plan(()),
            knowledge,
            {},
            self.worker,
            None,
            since_ns=0,
            grown_from=None,
            clock=lambda: 1.0,
            why=False,
            cwd='/',
        )
        # nothing is watched really
        self.watching._launch = self.launch

    def change(self, path):
        self.watching._take(Batch((Change('changed', path, path),), 0))
        self.watching.advance()

    def lose_worker(self):
        outcome = Outcome(None, 9, core_dumped=False)
        self.watching.ended(WORKER, outcome)
        self.watching.advance()


@pytest.mark.parametrize('path', [SOURCE, LAUNCH_FILE])
def test_what_it_was_at_is_not_done(path):
    story = Story()
    story.change(path)
    assert story.launch.told == []
    story.lose_worker()
    name = Path(path).name
    line = (True, f'{name} changed: what builds for --watch is gone')
    assert story.launch.told == [line]
    # nor is what comes later
    story.change(path)
    assert story.launch.told == [line, line]
    assert story.worker.asked == 1


@pytest.mark.parametrize('reads_more', [False, True])
def test_what_needs_none_of_it_is_restarted(reads_more):
    story = Story(reads_more=reads_more)
    story.lose_worker()
    story.change(SCRIPT)
    assert story.launch.restarted == ['a']
    assert [failed for failed, _ in story.launch.told] == [reads_more]


def test_a_job_that_was_killed_is_done_at_the_next_change():
    story = Story()
    story.change(SOURCE)
    story.watching._take_answers(0)
    assert story.launch.told == [
        (
            True,
            'a.cpp changed: what prepares it was killed, '
            'everything runs on as before',
        )
    ]
    story.change('/ws/src/arm/README.md')
    assert story.worker.asked == 2
