# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""From a change to what is asked of the launch, without a process."""

from collections.abc import Callable
from collections.abc import Mapping
from dataclasses import dataclass
from dataclasses import field
from dataclasses import replace
import signal
from typing import Any

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.watch import watching
from colcon_yamllaunch.watch.changes import Batch
from colcon_yamllaunch.watch.changes import Change
from colcon_yamllaunch.watch.jobs import Announced
from colcon_yamllaunch.watch.jobs import Failed
from colcon_yamllaunch.watch.jobs import Prepared
from colcon_yamllaunch.watch.knowledge import Knowledge
from colcon_yamllaunch.watch.knowledge import PackageUse
from colcon_yamllaunch.watch.knowledge import ProcessUse
from colcon_yamllaunch.watch.watching import Watching
import pytest

ARM = '/ws/src/arm'
SHARE = '/ws/install/arm/share/arm'
WORKER, WATCHER, JOB = 71, 72, 73


def process(name: str, program: str, **more: Any) -> Process:
    here = Position('demo.yaml', 1, 1)
    return Process(name, (program,), '/ws', here, name, package='arm', **more)


TALK = process('talk', f'{ARM}/talk.py')
LOOP = process('loop', '/ws/install/arm/lib/arm/loop')
KNOWN = Knowledge(
    (
        ProcessUse('talk', f'{ARM}/talk.py', 'arm', frozenset(('arm',))),
        ProcessUse(
            'loop', '/ws/install/arm/lib/arm/loop', 'arm', frozenset(('arm',))
        ),
    ),
    (PackageUse('arm', ARM, frozenset(('talk.py',)), share=SHARE),),
    frozenset((f'{ARM}/demo.yaml',)),
)


@dataclass
class PlayedWorker:
    pid: int = WORKER
    descriptor: int = 5
    job_descriptors: tuple[int, ...] = (6, 7)
    asked: int = 0
    written: bytes = b''
    is_busy: bool = False
    answers: list[object] = field(default_factory=list)
    closing: Callable[[int], None] = print

    def ask(self, job: object) -> None:
        if not self.pid:
            raise OSError
        self.asked += 1
        self.is_busy = True

    def take(self) -> Any:
        while self.answers:
            yield self.answers.pop(0)

    def take_children(self) -> list[int]:
        return [JOB]

    def cancel(self) -> None:
        self.is_busy = False

    forget = cancel

    def lost(self) -> None:
        self.pid = 0

    def close(self) -> None:
        self.lost()


@dataclass
class PlayedWatches:
    handlers: dict[int, Callable[[int], None]] = field(default_factory=dict)

    def add(self, descriptor: int, handler: Callable[[int], None]) -> None:
        self.handlers[descriptor] = handler

    def remove(self, descriptor: int) -> None:
        del self.handlers[descriptor]


class PlayedWatcher:
    """What tells of changes, when a test says so."""

    def __init__(self, _: object, take: Any, *__: object) -> None:
        self.take = take
        self.pid = WATCHER
        self.seen: list[str] = []

    def start(self) -> None:
        pass

    def watch(self, *wanted: object) -> None:
        pass

    def advance(self) -> None:
        pass

    def ended(self, outcome: Outcome) -> None:
        self.seen.append(str(outcome))

    def hang_up(self) -> None:
        self.seen.append('hung up')

    def seconds_to_wait(self) -> None:
        return None


class Played:
    """A launch of two processes, and what is asked of it."""

    def __init__(
        self,
        *,
        grown_from: Mapping[str, str] | None = None,
        why: bool = False,
    ) -> None:
        self.now = 10.0
        self.worker = PlayedWorker()
        self.watches = PlayedWatches()
        self.told: list[events.Event] = []
        self.asked: list[Any] = []
        self.guarded: set[int] = set()
        self.is_ended_by_others = False
        self.plan = Plan((TALK, LOOP))
        self.watching = Watching(
            self.plan,
            KNOWN,
            {},
            self.worker,  # type: ignore[arg-type]
            None,
            since_ns=0,
            grown_from=grown_from,
            clock=lambda: self.now,
            why=why,
            cwd='/ws',
        )
        self.watching.begin(self)  # type: ignore[arg-type]
        self.watcher: PlayedWatcher = self.watching._watcher  # type: ignore
        for part in (TALK, LOOP):
            self.watching.handle(events.Started(part, 1))

    # what it asks of the launch

    def tell(self, event: events.Event) -> None:
        self.told.append(event)

    def restart(self, labels: tuple[str, ...]) -> tuple[str, ...]:
        self.asked += [f'restart {label}' for label in labels]
        return labels

    def revise(self, part: Process, *, at_once: bool) -> None:
        if part not in (TALK, LOOP):
            when = 'at once' if at_once else 'when it starts'
            self.asked.append(f'another {part.label} {when}')

    def drop(self, label: str) -> None:
        self.asked.append(f'drop {label}')

    def extend(self, entries: tuple[Any, ...]) -> None:
        self.asked += [f'start {entry.label}' for entry in entries]

    def stop(self, reason: str) -> None:
        self.asked.append(f'stop: {reason}')

    def forget(self, entries: object) -> None:
        pass

    def renew_environment(self, variables: object) -> None:
        pass

    def groups(self) -> dict[str, int]:
        return {}

    def guard_group(self, group: int) -> None:
        self.guarded.add(group)

    def release_group(self, group: int) -> None:
        self.guarded.discard(group)

    # what happens

    def save(self, *names: str, kind: Any = 'changed') -> list[Any]:
        """Save files of the package; return what is asked at once."""
        paths = [f'{ARM}/{name}' for name in names]
        changes = tuple(Change(kind, path, path) for path in paths)
        self.watcher.take(Batch(changes, int(self.now * 1e9)))
        return self.was_asked()

    def answer(self, *answers: object) -> list[Any]:
        """Have the worker answer; return what is asked at once."""
        self.worker.answers += answers
        self.watches.handlers[6](0)
        return self.was_asked()

    def prepared(self, *parts: Process, **more: Any) -> list[Any]:
        plan = Plan(parts) if parts else self.plan
        answer = Prepared(plan, {}, KNOWN, {}, {}, (), 0)
        return self.answer(replace(answer, **more))

    def was_asked(self) -> list[Any]:
        asked, self.asked = self.asked, []
        return asked

    def lines(self, *started: Process) -> list[str]:
        """Return what was said since, once some have started anew."""
        for part in started:
            self.watching.handle(events.Started(part, 1))
        self.watching.advance()
        told, self.told = self.told, []
        return [line for event in told for line in event.lines()]


def paths_without(gone: str) -> Callable[[str], bool]:
    return lambda path: path != gone


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch) -> Played:
    monkeypatch.setattr(watching, 'WatcherLink', PlayedWatcher)
    # there is no workspace
    monkeypatch.setattr('os.path.exists', paths_without(''))
    return Played()


def test_what_needs_no_build_is_restarted_at_once(played: Played) -> None:
    assert played.save('talk.py') == ['restart talk']
    assert not played.worker.asked
    assert played.lines() == []
    played.now += 0.25
    assert played.lines(TALK) == ['talk.py changed: restarted talk (0.25 s)']


def test_what_a_build_touches_is_restarted_when_it_is_done(
    played: Played,
) -> None:
    assert played.save('loop.c') == []
    assert played.answer(Announced('building 1 package')) == []
    assert played.lines() == ['loop.c changed: building 1 package']
    changed = {'/ws/install/arm/lib/arm/loop': 'arm'}
    assert played.prepared(changed=changed, packages=('arm',)) == [
        'restart loop'
    ]
    assert played.lines(LOOP) == [
        'loop.c changed: built arm, restarted loop (0.00 s)'
    ]


def test_it_is_told_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watching, 'WatcherLink', PlayedWatcher)
    played = Played(why=True)
    played.save('loop.c')
    played.prepared(changed={'/ws/install/arm/lib/arm/loop': 'arm'})
    assert played.lines() == [
        'src/arm/loop.c changed: build arm, as arm is built from it',
        'restart loop, as its program was built',
    ]


def test_a_change_during_a_build_makes_it_void(played: Played) -> None:
    played.save('loop.c')
    # what needs no build does not wait for it
    assert played.save('talk.py') == ['restart talk']
    assert played.worker.asked == 1
    played.save('loop.h')
    assert played.worker.asked == 2
    assert played.lines(TALK) == ['talk.py changed: restarted talk (0.00 s)']
    played.prepared()
    assert played.lines() == [
        'loop.c, loop.h changed: nothing that runs differs (0.00 s)'
    ]


def test_what_a_build_has_taken_away_is_restarted_when_it_is_done(
    played: Played, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr('os.path.exists', paths_without(f'{ARM}/talk.py'))
    played.save('CMakeLists.txt')
    assert played.save('talk.py') == []
    assert played.lines() == []
    assert played.prepared() == ['restart talk']
    assert played.lines(TALK) == [
        'CMakeLists.txt, talk.py changed: restarted talk (0.00 s)'
    ]


@pytest.mark.parametrize('gone', [f'{ARM}/talk.py', SHARE])
def test_what_is_not_installed_any_more_is_built_before_a_restart(
    played: Played, monkeypatch: pytest.MonkeyPatch, gone: str
) -> None:
    # as by `rm -rf install`
    monkeypatch.setattr('os.path.exists', paths_without(gone))
    assert played.save('talk.py') == []
    assert played.worker.asked == 1
    assert played.prepared(packages=('arm',)) == ['restart talk']
    # without a worker all runs on
    played.watching.ended(WORKER, Outcome(code=1))
    assert played.save('talk.py') == []


def broken(monkeypatch: pytest.MonkeyPatch, *paths: str) -> None:
    """Have some files be such that do not compile."""
    monkeypatch.setattr(watching, 'compiles', lambda path: path not in paths)


def test_what_does_not_compile_restarts_nothing(
    played: Played, monkeypatch: pytest.MonkeyPatch
) -> None:
    talk, error = f'{ARM}/talk.py', 'talk.py:1:7: error: invalid syntax'
    broken(monkeypatch, talk)
    assert played.save('talk.py') == []
    assert played.prepared(broken={talk: error}) == []
    left = 'not restarted, as Python code does not compile: talk (0.00 s)'
    played.watching.advance()
    (event,) = [e for e in played.told if isinstance(e, events.Watched)]
    assert (event.failed, event.details) == (True, error)
    assert played.lines() == [f'talk.py changed: {left}']
    # nor does another change of what it uses
    played.save('loop.c', 'talk.yaml')
    both = {'/ws/install/arm/lib/arm/loop': 'arm'}
    assert played.prepared(broken={talk: error}, changed=both) == [
        'restart loop'
    ]
    played.lines(LOOP)
    # a build that fails forgets nothing
    played.save('loop.c', 'talk.py')
    played.answer(Failed('build'))
    played.lines()
    played.save('loop.c')
    assert played.prepared(broken={talk: error}) == []
    assert played.lines() == [f'loop.c changed: {left}']
    broken(monkeypatch)
    assert played.save('talk.py') == ['restart talk']


def test_the_python_of_the_process_decides_what_compiles(
    played: Played, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken(monkeypatch, f'{ARM}/talk.py')
    assert played.save('talk.py') == []
    assert played.prepared() == ['restart talk']


def test_a_copy_of_what_does_not_compile_restarts_nothing(
    played: Played, monkeypatch: pytest.MonkeyPatch
) -> None:
    # it is installed as a file of its own, here or on another machine
    source, copy = f'{ARM}/src/loop', '/ws/install/arm/lib/arm/loop'
    broken(monkeypatch, source)
    assert played.save('src/loop') == []
    answer = {'broken': {source: 'error'}, 'changed': {copy: 'arm'}}
    assert played.prepared(**answer) == []
    # that which is as it was now has been mended elsewhere
    played.save('loop.h')
    assert played.prepared(broken={source: 'error'}) == []
    broken(monkeypatch)
    played.save('src/loop')
    assert played.prepared(changed={copy: 'arm'}) == ['restart loop']


def failed(part: Process) -> events.Exited:
    return events.Exited(part, 1, Outcome(1), 0.4, asked=False, failed=True)


def test_what_fails_once_it_was_restarted_is_told(played: Played) -> None:
    played.save('talk.py')
    assert played.lines(TALK) == ['talk.py changed: restarted talk (0.00 s)']
    played.now += 0.5
    played.watching.handle(failed(TALK))
    (event,) = [e for e in played.told if isinstance(e, events.Watched)]
    assert event.failed
    line = 'talk.py changed: failed once started: talk (0.50 s)'
    assert played.lines() == [line]
    # once only, and not of what was not restarted
    for part in (TALK, LOOP):
        played.watching.handle(failed(part))
    assert played.lines() == []


def test_what_fails_much_later_is_not_told(played: Played) -> None:
    played.save('talk.py')
    played.lines(TALK)
    played.now += 60
    played.watching.handle(failed(TALK))
    assert played.lines() == []


def test_what_fails_before_all_are_restarted_is_told_once(
    played: Played,
) -> None:
    played.save('talk.py', 'loop.c')
    played.prepared(changed={'/ws/install/arm/lib/arm/loop': 'arm'})
    assert played.lines(TALK) == []
    played.watching.handle(failed(TALK))
    assert played.lines(LOOP) == [
        'talk.py, loop.c changed: restarted loop, '
        'failed once started: talk (0.00 s)'
    ]


def test_warnings_of_a_build_are_shown(played: Played) -> None:
    played.save('loop.c')
    played.worker.written = b'loop.c:1: warning: unused\n'
    played.prepared(packages=('arm',))
    played.watching.advance()
    (event,) = [e for e in played.told if isinstance(e, events.Watched)]
    assert (event.failed, event.details) == (
        False,
        'loop.c:1: warning: unused',
    )


def test_what_a_failed_build_owes_follows_the_next(played: Played) -> None:
    played.save('loop.c', 'talk.py')
    played.worker.written = b'loop.c:1: error'
    assert played.answer(Failed('build')) == []
    played.worker.written = b''
    (event,) = [e for e in played.told if isinstance(e, events.Watched)]
    assert (event.failed, event.details) == (True, 'loop.c:1: error')
    assert 'everything runs on as before' in event.text
    played.told.clear()
    played.save('loop.c')
    assert played.prepared() == ['restart talk']


def test_what_failed_is_started_anew_when_its_package_is_built(
    played: Played,
) -> None:
    end = events.Exited(TALK, 1, Outcome(1), 0.4, asked=False, failed=True)
    played.watching.handle(end)
    played.now += 60
    played.save('loop.c')
    # another package brings nothing that it has
    assert played.prepared(packages=('leg',)) == []
    played.save('loop.c')
    assert played.prepared(packages=('arm',)) == ['restart talk']
    played.lines(TALK)
    played.save('loop.c')
    assert played.prepared(packages=('arm',)) == []


def test_another_plan_is_done_in_its_order(played: Played) -> None:
    played.save('demo.yaml')
    more = process('more', '/bin/true')
    loud = replace(TALK, argv=(*TALK.argv, '--loud'))
    again = replace(LOOP, respawn=True)
    assert played.prepared(again, loud, more) == [
        'another loop at once',
        'another talk when it starts',
        'restart talk',
        'start more',
    ]
    assert played.lines(loud, more) == [
        'demo.yaml changed: started more, restarted talk (0.00 s)'
    ]
    played.save('demo.yaml')
    assert played.prepared(again, loud)[0] == 'drop more'


def test_who_is_stopped_by_hand_is_not_waited_for(played: Played) -> None:
    played.save('talk.py')
    played.watching.handle(events.Requested(TALK, 'stop'))
    assert played.lines() == [
        'talk.py changed: nothing that runs differs (0.00 s)'
    ]


def test_a_worker_that_is_killed_takes_its_job_along(
    played: Played, monkeypatch: pytest.MonkeyPatch
) -> None:
    killed: list[tuple[int, int]] = []
    monkeypatch.setattr('os.killpg', lambda *args: killed.append(args))
    played.save('loop.c')
    played.watches.handlers[5](0)
    assert played.guarded == {WORKER, JOB}
    played.watching.ended(WORKER, Outcome(signal=signal.SIGKILL))
    assert killed == [(JOB, signal.SIGINT)]
    assert not played.guarded
    is_gone = 'loop.c changed: what builds for --watch is gone (0.00 s)'
    warning, line = played.lines()
    assert warning.startswith('warning: what builds for --watch died by SIG')
    assert line == is_gone
    # what needs it fails, what does not is done
    assert played.save('loop.c') == []
    assert played.lines() == [is_gone]
    assert played.save('talk.py') == ['restart talk']
    assert played.lines(TALK) == ['talk.py changed: restarted talk (0.00 s)']
    assert played.save('talk.py', 'loop.c') == ['restart talk']
    assert played.lines(TALK) == [
        'talk.py, loop.c changed: restarted talk, '
        'what builds for --watch is gone (0.00 s)'
    ]


def test_the_end_of_what_watches_is_passed_on(played: Played) -> None:
    assert set(played.watching.pids) == {WORKER, WATCHER}
    played.watching.ended(WATCHER, Outcome(code=1))
    assert played.watcher.seen == ['exited with code 1']


def test_nothing_follows_while_the_launch_is_stopped(played: Played) -> None:
    played.save('loop.c')
    played.watching.hang_up()
    assert not played.worker.is_busy
    assert played.watcher.seen == ['hung up']
    assert played.prepared() == []
    assert played.lines() == []


def test_with_event_handlers_a_launch_begins_anew_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(watching, 'WatcherLink', PlayedWatcher)
    played = Played(grown_from={'demo.launch.py': 'one'})
    played.save('demo.yaml')
    played.prepared(grown_from={'demo.launch.py': 'one'})
    assert not played.watching.begins_anew
    played.save('demo.yaml')
    assert played.prepared(grown_from={'demo.launch.py': 'two'}) == [
        'stop: it begins anew'
    ]
    assert played.watching.begins_anew
    # somebody wants it to end meanwhile
    played.is_ended_by_others = True
    assert not played.watching.begins_anew
