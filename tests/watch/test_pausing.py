# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Watching that is off for a while."""

from types import SimpleNamespace

from colcon_yamllaunch.control.acts import Acts
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.watch.changes import Batch
from colcon_yamllaunch.watch.changes import Change
from colcon_yamllaunch.watch.changes import merged
from colcon_yamllaunch.watch.knowledge import Knowledge
from colcon_yamllaunch.watch.knowledge import ProcessUse
from colcon_yamllaunch.watch.watching import Watching
import pytest

SCRIPTS = '/home/me/a.sh', '/home/me/b.sh'
KNOWLEDGE = Knowledge(
    tuple(ProcessUse(path[-4], path, may_run_python=True) for path in SCRIPTS),
    (),
)


class PlayedLaunch:
    """A launch that takes note of what it is asked for."""

    def __init__(self):
        self.restarted = []
        self.told = []
        self.saved = None
        self.watches = SimpleNamespace(
            add=lambda *_: None, remove=lambda *_: None
        )

    def watcher(self, _watches, take, *_):
        """Make what watches files; :attr:`saved` is told what it would."""
        self.saved = take
        return SimpleNamespace(
            start=lambda: None, watch=lambda *_: None, pid=0
        )

    def restart(self, labels):
        self.restarted.append(sorted(labels))
        return tuple(labels)

    def tell(self, event):
        self.told.append(event)

    def release_group(self, group):
        raise AssertionError('there is no group')

    def guard_group(self, group):
        assert group == 0


@pytest.fixture
def launch():
    return PlayedLaunch()


@pytest.fixture
def watching(launch, monkeypatch):
    monkeypatch.setattr(
        'colcon_yamllaunch.watch.watching.WatcherLink',
        launch.watcher,
    )
    made = Watching(
        Plan(),
        KNOWLEDGE,
        {},
        SimpleNamespace(pid=0, descriptor=-1),
        None,
        since_ns=0,
        grown_from=None,
        clock=lambda: 50.0,
        why=False,
        cwd='/',
    )
    made.begin(launch)
    return made


def changed(*paths, seen=10.0, kind='changed'):
    changes = tuple(Change(kind, path, path) for path in paths)
    return Batch(changes, int(seen * 1e9))


def test_what_is_saved_meanwhile_follows_later(watching, launch):
    # as keys and clients have it done
    acts = Acts(SimpleNamespace(supervisor=None, changes=watching), {}, None)
    acts.watch(paused=True)
    assert acts.is_watch_paused
    for path in SCRIPTS * 2:
        launch.saved(changed(path))
    assert launch.restarted == []
    acts.watch(paused=False)
    assert not acts.is_watch_paused
    assert launch.restarted == [['a', 'b']]
    launch.saved(changed(SCRIPTS[0]))
    assert launch.restarted[1:] == [['a']]
    texts = [e.text for e in launch.told if isinstance(e, events.Watched)]
    assert texts == ['off: what is saved now has to wait', 'on again']


def test_a_pause_in_which_nothing_was_saved(watching, launch):
    watching.resume()
    watching.pause()
    watching.pause()
    watching.resume()
    assert launch.restarted == []
    assert len(launch.told) == 2


def test_batches_become_one():
    first, second = changed('/a', '/b'), changed('/b', '/c', seen=20.0)
    assert merged([first, second]) == changed('/a', '/b', '/c')


def test_what_comes_again_takes_no_more_room():
    batch = changed('/a', '/b')._replace(notes=('too many files',))
    assert merged([batch, batch]) == batch
