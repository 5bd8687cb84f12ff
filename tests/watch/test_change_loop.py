# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""From a change to what is asked of the launch, without a process."""

from collections.abc import Callable
from dataclasses import replace
import signal
from types import SimpleNamespace
from typing import Any
from unittest.mock import Mock

from colcon_yamllaunch.engine import commands, events
from colcon_yamllaunch.engine.commands import Watch
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.state import About, LaunchState
from colcon_yamllaunch.plan.member_settings import MemberSettings
from colcon_yamllaunch.plan.plan import Plan, Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.watch import change_loop, preparer
from colcon_yamllaunch.watch.change_loop import ChangeLoop
from colcon_yamllaunch.watch.dependencies import (
    Dependencies,
    PackageDependencies,
    ProcessDependencies,
)
from colcon_yamllaunch.watch.watched_files import Batch, Change
import pytest

ARM = '/ws/src/arm'
SHARE = '/ws/install/arm/share/arm'
PREPARER, JOB = 71, 73
#: What a build of the program makes, and the package that it is of.
BUILT = {'/ws/install/arm/lib/arm/loop': 'arm'}


def process(name: str, program: str, **more: Any) -> Process:
    here = Position('demo.yaml', 1, 1)
    return Process(name, (program,), '/ws', here, name, package='arm', **more)


TALK = process('talk', f'{ARM}/talk.py')
LOOP = process('loop', '/ws/install/arm/lib/arm/loop')
KNOWN = Dependencies(
    (
        ProcessDependencies('talk', f'{ARM}/talk.py', frozenset(('arm',))),
        ProcessDependencies('loop', LOOP.argv[0], frozenset(('arm',))),
    ),
    (PackageDependencies('arm', ARM, frozenset(('talk.py',)), share=SHARE),),
    frozenset((f'{ARM}/demo.yaml',)),
)


class Played:
    """A launch of two processes, and what is asked of it."""

    def __init__(self, grown_from: Any = None, why: bool = False) -> None:
        self.now = 10.0
        self.preparer = Mock(spec=preparer.Preparer, pid=PREPARER, written=b'')
        self.preparer.ended.side_effect = lambda: setattr(
            self.preparer, 'pid', 0
        )
        self.loop = SimpleNamespace(wake=self.wake)
        self.turns = 0
        self.built: dict[str, dict[str, str]] = {}
        self.told: list[events.Event] = []
        self.asked: list[Any] = []
        self.guarded: set[int] = set()
        self.helpers: dict[int, Callable[[int], object]] = {}
        self.handlers: dict[Any, Any] = {}
        self.is_stopping = False
        self.supervisor = SimpleNamespace(outlasts_failures=False)
        self.is_ended_by_others = False
        self.plan = Plan((TALK, LOOP))
        self.blocks = self.plan.blocks
        self.state = LaunchState(
            About('', None, '', ''), clock=lambda: self.now
        )
        self.state.expect(self.plan.entries)
        self.watching = ChangeLoop(
            preparer.Prepared(self.plan, {}, KNOWN, {}, (), 0, grown_from),
            self.preparer,
            None,
            clock=lambda: self.now,
            why=why,
            cwd='/ws',
        )
        self.watching.join(self)  # type: ignore[arg-type]
        self.watching.begin()
        self.watcher: Any = self.watching._watcher
        for member in (TALK, LOOP):
            self.happens(events.Started(member, 1))

    # what it asks of the launch

    def emit(self, event: events.Event) -> None:
        self.told.append(event)

    @property
    def dispatcher(self) -> Any:
        return SimpleNamespace(do=self.do, add=self.handlers.__setitem__)

    def wake(self) -> None:
        self.turns += 1

    def do(self, command: commands.Command[Any]) -> Any:
        match command:
            case commands.RestartChanged(labels):
                self.asked += [f'restart {label}' for label in labels]
                return commands.Restarted(labels)
            case commands.Revise(member, at_once) if member not in (
                TALK,
                LOOP,
            ):
                when = 'at once' if at_once else 'when it starts'
                self.asked.append(f'another {member.label} {when}')
            case commands.Drop(label):
                self.asked.append(f'drop {label}')
            case commands.Extend(entries):
                members = Plan(entries).processes()
                self.asked += [f'start {member.label}' for member in members]
            case commands.Shutdown(reason):
                self.asked.append(f'stop: {reason}')
        return commands.DONE

    def renew_environment(self, variables: object) -> None:
        pass

    def groups(self) -> dict[str, int]:
        return {}

    def add_helper(self, pid: int, ended: Callable[[int], object]) -> None:
        self.guarded.add(pid)
        self.helpers[pid] = ended

    def remove_helper(self, pid: int) -> None:
        self.guarded.discard(pid)
        del self.helpers[pid]

    def guard_group(self, group: int) -> None:
        self.guarded.add(group)

    def release_group(self, group: int) -> None:
        self.guarded.discard(group)

    # what happens

    def happens(self, event: events.Event) -> None:
        self.state.apply(event)
        self.watching.handle(event)

    def save(self, *names: str, kind: Any = 'changed') -> list[Any]:
        """Save files of the package; return what is asked at once."""
        paths = [f'{ARM}/{name}' for name in names]
        changes = tuple(Change(kind, path, path) for path in paths)
        receive = change_loop.WatcherClient.call_args.args[1]
        receive(Batch(changes, int(self.now * 1e9)))
        return self.was_asked()

    def answer(self, *answers: object) -> list[Any]:
        """Have the preparer answer; return what is asked at once."""
        for answer in answers:
            self.preparer.begin.call_args.args[1](answer)
        return self.was_asked()

    def prepared(
        self, *members: Process, changed: Any = None, **more: Any
    ) -> list[Any]:
        """Have the preparer prepare a launch; return what is asked at once."""
        plan = Plan(members) if members else self.plan
        for path, package in (changed or {}).items():
            before = self.built.get(package, {})
            digest = before.get(path, '') + '+'
            self.built[package] = {**before, path: digest}
        answer = preparer.Prepared(plan, {}, KNOWN, dict(self.built), (), 0)
        return self.answer(replace(answer, **more))

    def was_asked(self) -> list[Any]:
        asked, self.asked = self.asked, []
        return asked

    def watched(self) -> list[events.ChangeReported]:
        return [e for e in self.told if isinstance(e, events.ChangeReported)]

    def lines(self, *started: Process) -> list[str]:
        """Return what was said since, once some have started anew."""
        for member in started:
            self.happens(events.Started(member, 1))
        self.watching.end_turn()
        told, self.told = self.told, []
        return [line for event in told for line in event.lines()]


def paths_without(gone: str) -> Callable[[str], bool]:
    return lambda path: path != gone


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch) -> Played:
    monkeypatch.setattr(change_loop, 'WatcherClient', Mock())
    # there is no workspace
    monkeypatch.setattr('os.path.exists', paths_without(''))
    return Played()


def test_program_is_restarted_after_its_build(played: Played) -> None:
    assert played.save('loop.c') == []
    assert played.answer(preparer.Announced('building 1 package')) == []
    assert played.lines() == ['loop.c changed: building 1 package']
    played.preparer.written = b'loop.c:1: warning: unused\n'
    asked = played.prepared(changed=BUILT, packages=('arm',))
    assert asked == ['restart loop']
    played.happens(events.Started(LOOP, 1))
    played.watching.end_turn()
    assert played.watched()[-1].details == 'loop.c:1: warning: unused'
    line = 'loop.c changed: built arm, restarted loop (0.00 s)'
    assert played.lines()[-1] == line


@pytest.mark.usefixtures('played')
def test_why_explains_changes_and_restarts() -> None:
    played = Played(why=True)
    played.save('loop.c')
    played.prepared(changed=BUILT)
    assert played.lines() == [
        'src/arm/loop.c changed: build arm, as arm is built from it',
        'restart loop, as its program was built',
    ]


def test_change_during_a_build_cancels_it(played: Played) -> None:
    played.save('loop.c')
    # what needs no build does not wait for it
    assert played.save('talk.py') == ['restart talk']
    assert played.preparer.ask.call_count == 1
    played.save('loop.h')
    assert played.preparer.ask.call_count == 2
    assert played.lines(TALK) == ['talk.py changed: restarted talk (0.00 s)']
    played.prepared()
    assert played.lines() == [
        'loop.c, loop.h changed: nothing that runs differs (0.00 s)'
    ]


def test_program_missing_during_a_build_is_restarted_after_it(
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
def test_uninstalled_program_is_built_before_its_restart(
    played: Played, monkeypatch: pytest.MonkeyPatch, gone: str
) -> None:
    # as by `rm -rf install`
    monkeypatch.setattr('os.path.exists', paths_without(gone))
    assert played.save('talk.py') == []
    assert played.preparer.ask.call_count == 1
    assert played.prepared(packages=('arm',)) == ['restart talk']
    # without a preparer all runs on
    played.helpers[PREPARER](1 << 8)
    assert played.save('talk.py') == []


def broken(monkeypatch: pytest.MonkeyPatch, *paths: str) -> None:
    """Have some files be such that do not compile."""
    monkeypatch.setattr(
        change_loop, 'compiles', lambda path: path not in paths
    )


def test_file_that_does_not_compile_restarts_nothing(
    played: Played, monkeypatch: pytest.MonkeyPatch
) -> None:
    talk, error = f'{ARM}/talk.py', 'talk.py:1:7: error: invalid syntax'
    broken(monkeypatch, talk)
    assert played.save('talk.py') == []
    assert played.prepared(broken={talk: error}) == []
    left = 'not restarted, as Python code does not compile: talk (0.00 s)'
    played.watching.end_turn()
    (event,) = played.watched()
    assert (event.failed, event.details) == (True, error)
    assert played.lines() == [f'talk.py changed: {left}']
    # nor does another change of what it uses
    played.save('loop.c', 'talk.yaml')
    asked = played.prepared(broken={talk: error}, changed=BUILT)
    assert asked == ['restart loop']
    played.lines(LOOP)
    # a build that fails forgets nothing
    played.save('loop.c', 'talk.py')
    played.answer(preparer.Failed('build'))
    played.lines()
    played.save('loop.c')
    assert played.prepared(broken={talk: error}) == []
    assert played.lines() == [f'loop.c changed: {left}']
    broken(monkeypatch)
    assert played.save('talk.py') == ['restart talk']


def test_python_of_the_process_decides_what_compiles(
    played: Played, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken(monkeypatch, f'{ARM}/talk.py')
    assert played.save('talk.py') == []
    assert played.prepared() == ['restart talk']


def test_copy_of_a_file_that_does_not_compile_restarts_nothing(
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


def failed(member: Process, seconds: float = 0.4) -> events.Exited:
    return events.Exited(
        member, 1, Outcome(1), seconds, asked=False, failed=True
    )


def test_failure_after_a_restart_is_reported_once(played: Played) -> None:
    played.save('talk.py')
    assert played.lines(TALK) == ['talk.py changed: restarted talk (0.00 s)']
    played.now += 0.5
    played.happens(failed(TALK))
    (event,) = played.watched()
    assert event.failed
    line = 'talk.py changed: failed once started: talk (0.50 s)'
    assert played.lines() == [line]
    # once only, and not of what was not restarted
    for member in (TALK, LOOP):
        played.happens(failed(member))
    # nor long after the restart
    played.save('talk.py')
    played.lines(TALK)
    played.now += 60
    played.happens(failed(TALK))
    assert played.lines() == []


def test_failure_before_the_report_is_in_it(played: Played) -> None:
    played.save('talk.py', 'loop.c')
    played.prepared(changed=BUILT)
    assert played.lines(TALK) == []
    played.happens(failed(TALK))
    assert played.lines(LOOP) == [
        'talk.py, loop.c changed: restarted loop, '
        'failed once started: talk (0.00 s)'
    ]


def test_restart_waits_for_a_build_that_succeeds(played: Played) -> None:
    played.save('loop.c', 'talk.py')
    played.preparer.written = b'loop.c:1: error'
    assert played.answer(preparer.Failed('build')) == []
    played.preparer.written = b''
    (event,) = played.watched()
    assert (event.failed, event.details) == (True, 'loop.c:1: error')
    assert 'everything runs on as before' in event.text
    played.told.clear()
    played.save('loop.c')
    assert played.prepared() == ['restart talk']


def test_failed_process_is_restarted_by_a_build(played: Played) -> None:
    played.happens(failed(TALK))
    played.now += 60
    played.save('loop.c')
    # another package brings nothing that it has
    assert played.prepared(packages=('leg',)) == []
    played.save('loop.c')
    assert played.prepared(packages=('arm',)) == ['restart talk']
    played.lines(TALK)
    played.save('loop.c')
    assert played.prepared(packages=('arm',)) == []


def test_new_plan_revises_restarts_and_starts_in_order(played: Played) -> None:
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


def test_process_stopped_by_the_user_is_not_waited_for(played: Played) -> None:
    played.save('talk.py')
    played.happens(events.Requested(TALK, 'stop'))
    assert played.lines() == [
        'talk.py changed: nothing that runs differs (0.00 s)'
    ]


def test_job_of_a_killed_preparer_is_interrupted(
    played: Played, monkeypatch: pytest.MonkeyPatch
) -> None:
    killed: list[tuple[int, int]] = []
    monkeypatch.setattr('os.killpg', lambda *args: killed.append(args))
    played.save('loop.c')
    played.answer(preparer.Begun(JOB))
    assert played.guarded == {PREPARER, JOB}
    played.helpers[PREPARER](signal.SIGKILL)
    assert killed == [(JOB, signal.SIGINT)]
    assert JOB not in played.guarded
    is_gone = 'loop.c changed: what builds for --watch is gone (0.00 s)'
    warning, line = played.lines()
    assert warning.startswith('warning: what builds for --watch died by SIG')
    assert line == is_gone
    # what needs the preparer fails, and the rest is done
    assert played.save('loop.c') == []
    assert played.lines() == [is_gone]
    assert played.save('talk.py') == ['restart talk']
    assert played.lines(TALK) == ['talk.py changed: restarted talk (0.00 s)']
    assert played.save('talk.py', 'loop.c') == ['restart talk']
    assert played.lines(TALK) == [
        'talk.py, loop.c changed: restarted talk, '
        'what builds for --watch is gone (0.00 s)'
    ]


def test_changes_have_no_effect_while_the_launch_stops(played: Played) -> None:
    played.save('loop.c')
    played.is_stopping = True
    played.watching.end_turn()
    played.preparer.cancel.assert_called_once()
    played.watcher.hang_up.assert_called_once()
    assert played.prepared() == []
    assert played.lines() == []


def test_other_settings_apply_without_a_restart(played: Played) -> None:
    at = Position('robot.yaml', 3, 5)
    critical = replace(TALK, settings=MemberSettings(at, critical=True))
    played.save('demo.yaml')
    assert played.prepared(critical, LOOP) == ['another talk at once']
    assert played.lines() == [
        'demo.yaml changed: other settings for talk (0.00 s)'
    ]
    limited = replace(LOOP, settings=MemberSettings(at, user='robot'))
    played.save('demo.yaml')
    asked = played.prepared(critical, limited)
    assert 'restart loop' in asked
    assert 'restart talk' not in asked


def test_first_readiness_conditions_restart_the_launch(played: Played) -> None:
    settings = MemberSettings(Position('robot.yaml', 3, 5), after=('talk',))
    waiting = replace(LOOP, settings=settings)
    played.save('demo.yaml')
    asked = played.prepared(TALK, waiting)
    assert asked == ['stop: it begins anew']


@pytest.mark.usefixtures('played')
def test_launch_with_event_handlers_restarts_once() -> None:
    played = Played(grown_from={'demo.launch.py': 'one'})
    played.save('demo.yaml')
    played.prepared(grown_from={'demo.launch.py': 'one'})
    assert not played.watching.restarts_launch
    played.save('demo.yaml')
    assert played.prepared(grown_from={'demo.launch.py': 'two'}) == [
        'stop: it begins anew'
    ]
    assert played.watching.restarts_launch
    # somebody wants it to end meanwhile
    played.is_ended_by_others = True
    assert not played.watching.restarts_launch


def test_killed_job_is_repeated_at_a_change(played: Played) -> None:
    played.save('loop.c')
    played.answer(preparer.Failed('job'))
    assert played.lines() == [
        'loop.c changed: what prepares it was killed, '
        'everything runs on as before (0.00 s)'
    ]
    played.save('README.md')
    assert played.preparer.ask.call_count == 2


def test_pause_collects_changes_until_it_ends(played: Played) -> None:
    # as keys and clients pause it
    switch = played.handlers[Watch]
    for action in ('resume', 'pause', 'pause'):
        assert switch(Watch(action), bool) == commands.DONE
    assert played.save('talk.py') == played.save('talk.py', 'other.py') == []
    switch(Watch('resume'), bool)
    assert played.was_asked() == []
    assert played.preparer.ask.call_count == 1
    assert played.lines() == [
        'off: what is saved now has to wait',
        'on again',
    ]
    played.prepared()
    assert played.lines(TALK) == [
        'talk.py, other.py changed: restarted talk (0.00 s)'
    ]


def test_failure_soon_after_a_rewrite_restarts(played: Played) -> None:
    played.now += change_loop.READ_WINDOW
    assert played.save('talk.py', kind='again') == []
    played.now += 0.5
    played.happens(failed(TALK, 3.5))
    assert played.turns
    played.watching.end_turn()
    assert played.was_asked() == ['restart talk']
    # a process that was started since has read the right file
    played.now += 0.1
    played.lines(TALK)
    played.now += 0.5
    played.happens(failed(TALK, 0.5))
    played.watching.end_turn()
    assert played.was_asked() == []
    # and a later failure has another reason
    played.save('talk.py', kind='again')
    played.now += change_loop.READ_WINDOW + 0.1
    played.happens(failed(TALK, 3.6))
    played.watching.end_turn()
    assert played.was_asked() == []
