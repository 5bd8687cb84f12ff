# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The course of watching: from the change of a file to what runs anew.

What follows from a change is decided in `consequences`. Whatever needs more
than a restart is prepared by the worker, while everything runs on. What is
under way, and what is told of it in the end, is in `rounds`. What a job that
failed has left undone is owed: it follows the next one that does not.
"""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
import math
import os
from pathlib import Path
import re
import signal
from typing import Any

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.plan_changes import RunningLaunch
from colcon_yamllaunch.engine.tasks import RefusedError
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import Entry
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.plan_difference import plan_difference
from colcon_yamllaunch.watch.build_effects import touched_by
from colcon_yamllaunch.watch.changes import Batch
from colcon_yamllaunch.watch.changes import Change
from colcon_yamllaunch.watch.changes import merged
from colcon_yamllaunch.watch.consequences import Consequence
from colcon_yamllaunch.watch.consequences import consequences
from colcon_yamllaunch.watch.consequences import missed
from colcon_yamllaunch.watch.consequences import Steps
from colcon_yamllaunch.watch.consequences import steps
from colcon_yamllaunch.watch.failed_parts import FailedParts
from colcon_yamllaunch.watch.jobs import Announced
from colcon_yamllaunch.watch.jobs import Failed
from colcon_yamllaunch.watch.jobs import Job
from colcon_yamllaunch.watch.jobs import Prepared
from colcon_yamllaunch.watch.knowledge import Knowledge
from colcon_yamllaunch.watch.mapped_files import with_libraries
from colcon_yamllaunch.watch.python_sources import compiles
from colcon_yamllaunch.watch.rounds import Round
from colcon_yamllaunch.watch.rounds import Rounds
from colcon_yamllaunch.watch.rounds import without
from colcon_yamllaunch.watch.saved_again import READING
from colcon_yamllaunch.watch.saved_again import SavedAgain
from colcon_yamllaunch.watch.watch_lines import failed_by
from colcon_yamllaunch.watch.watch_lines import happened
from colcon_yamllaunch.watch.watch_lines import why_lines
from colcon_yamllaunch.watch.watcher_link import WatcherLink
from colcon_yamllaunch.watch.worker_link import WorkerLink

#: What may restart a process with another Python file, the surest first.
_RESTARTS = ('restart', 'restart after build', 'build')
#: How many Python files are compiled before a restart at most; a checkout may
#: bring thousands.
_CHECKED = 50
_NUMBER = re.compile(r'\d+')


class Watching:
    """
    Has a launch run what its files say; see `PlanChanges`.

    :param plan: What runs
    :param knowledge: What that uses
    :param built: What its builds were, see `build_effects`
    :param log: The file for what the child that watches has to say, or None
    :param since_ns: When these files were read at the earliest, by the clock
      of the files
    :param grown_from: See :class:`.Prepared`, also for the next two
    :param clock: Returns seconds that never go back
    :param why: Whether to say of each change what follows from it, and why
    :param cwd: The folder that paths are shown from
    """

    def __init__(
        self,
        plan: Plan,
        knowledge: Knowledge,
        built: Mapping[str, Any],
        worker: WorkerLink,
        log: Path | None,
        *,
        since_ns: int,
        grown_from: Mapping[str, str] | None,
        deployment: str = '',
        machines: frozenset[str] = frozenset(),
        clock: Callable[[], float],
        why: bool,
        cwd: str,
    ) -> None:
        self._plan = plan
        self._knowledge = knowledge
        self._built = built
        self._worker = worker
        self._log = log
        self._watcher: WatcherLink | None = None
        self._since_ns = since_ns
        self._grown_from = grown_from
        self._deployment = deployment
        self._machines = machines
        self._begins_anew = False
        self._clock = clock
        self._why = why
        self._cwd = cwd
        self._launch: RunningLaunch | None = None
        self._rounds = Rounds()
        self._failed = FailedParts()
        self._again = SavedAgain()
        # what is owed from jobs that failed
        self._late: set[str] = set()
        # whether the last job failed
        self._is_owed = False
        # since when builds may have been under way that came to no good end
        self._unsure_since: float | None = None
        # what the last job that failed has written, without numbers
        self._failure = ''
        # when the launch was prepared last
        self._prepared_at = clock()
        # what was changed while nothing was to follow from that
        self._is_paused = False
        self._put_by: Batch | None = None
        self._group = 0
        self._labels: set[str] = set()
        # what is not restarted, by the files that do not compile
        self._broken: dict[str, set[str]] = {}

    @property
    def begins_anew(self) -> bool:
        """Whether the launch is to be run anew, as it has ended for that."""
        return self._begins_anew and not self._the_launch.is_ended_by_others

    @property
    def pids(self) -> Collection[int]:
        """The processes that it has started, children of ours."""
        watcher = 0 if self._watcher is None else self._watcher.pid
        return {watcher, self._worker.pid} - {0}

    def begin(self, launch: RunningLaunch) -> None:
        """Change a launch from now on."""
        self._launch = launch
        self._watcher = WatcherLink(
            launch.watches,
            self._take,
            lambda text: launch.tell(events.Warned(text)),
            self._clock,
            self._log,
        )
        self._watcher.start()
        self._watch(self._since_ns)
        launch.guard_group(self._worker.pid)
        self._worker.closing = launch.watches.remove
        launch.watches.add(self._worker.descriptor, self._take_child)

    def handle(self, event: events.Event) -> None:
        """Take note of what happened."""
        match event:
            case events.Started() | events.Loaded():
                self._came_up(event, failed=False)
            case events.StartFailed() | events.LoadFailed():
                self._came_up(event, failed=True)
            case events.Exited(asked=False, failed=True):
                self._crashed(event.process.label)
            case events.Dropped():
                self._rounds.gone(event.process.label)
            case events.Requested(action='stop' | 'kill'):
                self._rounds.stopped(event.process.label)
            case _:
                return

    @property
    def is_paused(self) -> bool:
        """Whether nothing follows from changes for the time being."""
        return self._is_paused

    def pause(self) -> None:
        """
        Have nothing follow from changes until :meth:`resume`.

        What is being done about earlier ones is done.
        """
        if not self._is_paused:
            self._is_paused = True
            text = 'off: what is saved now has to wait'
            self._the_launch.tell(events.Watched(text, is_paused=True))

    def resume(self) -> None:
        """Do what follows from the changes since :meth:`pause`."""
        if not self._is_paused:
            return
        self._is_paused = False
        batch, self._put_by = self._put_by, None
        self._the_launch.tell(events.Watched('on again', is_paused=False))
        if batch is not None:
            # whoever has started since may have read what was there then
            self._follow(batch, self._clock())

    def advance(self) -> None:
        """Do what is due."""
        if self._watcher is not None:
            self._watcher.advance()
        if self._must_look_again:
            self._take(self._again.take())
        for done in self._rounds.pop_over(self._clock()):
            self._tell_of(done)

    def seconds_to_wait(self) -> float | None:
        """Return the seconds until :meth:`advance` is to be called again."""
        if self._must_look_again or self._rounds.are_over:
            return 0.0
        if self._watcher is None:
            return None
        return self._watcher.seconds_to_wait()

    def ended(self, pid: int, outcome: Outcome) -> None:
        """Take into account that one of its processes ended."""
        if self._watcher is not None and pid == self._watcher.pid:
            self._watcher.ended(outcome)
        elif pid == self._worker.pid:
            self._worker_ended(outcome)

    def hang_up(self) -> None:
        """Do nothing more, as the launch is being stopped."""
        self._rounds.clear()
        self._again.clear()
        self._worker.cancel()
        if self._watcher is not None:
            self._watcher.hang_up()

    def close(self) -> None:
        """End all that it has started, and wait for that."""
        pid = self._worker.pid
        if self._watcher is not None:
            self._watcher.close()
        self._worker.close()
        if self._launch is not None and pid:
            self._launch.release_group(pid)
            self._job_ended()

    # from the change to the steps

    def _take(self, batch: Batch) -> None:
        if self._is_paused:
            before = self._put_by
            self._put_by = merged([before, batch]) if before else batch
            return
        self._follow(batch, batch.seen_ns / 1e9)

    def _follow(self, batch: Batch, since: float) -> None:
        """
        Do what follows from changes.

        :param since: When that began, by the clock that never goes back
        """
        launch = self._the_launch
        seen = batch.seen_ns / 1e9
        changes = [c for c in batch.changes if c.kind != 'again']
        again = [c for c in batch.changes if c.kind == 'again']
        found = (
            *consequences(changes, self._knowledge),
            *self._missed(again, seen),
        )
        wanted = steps(found, self._knowledge)
        if self._why:
            for line in why_lines(found, self._cwd):
                self._explain(line)
        if wanted.is_empty:
            return
        acted = [one.change for one in found if one.action != 'ignore']
        files = {os.path.basename(c.path): c.kind for c in acted}
        current = Round(since, files, kept=wanted.kept)
        current.suspects = self._suspects(found)
        if changes or wanted.restart or wanted.after_build:
            paths = tuple(dict.fromkeys(c.path for c in acted))
            launch.tell(events.Changed(paths))
        is_open = self._is_owed or self._has_job
        self._rounds.add(current)
        # what comes or goes may be what a build has missed
        must_ask = is_open and any(c.kind != 'changed' for c in acted)
        self._do(wanted, current, must_ask=must_ask)

    def _suspects(self, found: Iterable[Consequence]) -> tuple[str, ...]:
        """Return the Python files among what was changed that may be wrong."""
        saved = [
            one.change.real
            for action in _RESTARTS
            for one in found
            if one.action == action and one.change.kind != 'deleted'
        ]
        paths = [*dict.fromkeys((*self._broken, *saved))][:_CHECKED]
        suspects = tuple(path for path in paths if not compiles(path))
        if not suspects:
            self._broken.clear()
        return suspects

    def _explain(self, text: str) -> None:
        self._the_launch.tell(events.Watched(text, is_final=False))

    def _missed(
        self, again: Collection[Change], seen: float
    ) -> tuple[Consequence, ...]:
        """Tell what follows from files that were others for a moment."""
        self._again.add(again, seen)
        if again and self._has_job:
            # it mostly is none the worse for that, so it is not given up
            self._again.look_later(again, seen)
            return ()
        since = seen - READING
        return missed(
            again,
            self._knowledge,
            failed=self._failed.crashed_since(since) | self._failed.unstarted,
            has_looked=self._prepared_at >= (since if self._is_owed else seen),
        )

    def _crashed(self, label: str) -> None:
        now = self._clock()
        self._again.has_failed(self._failed.crashed(label, now), now)
        told = self._rounds.crashed(label, now)
        if told is not None:
            self._tell_of(told)

    def _tell_of(self, done: Round) -> None:
        outcome = done.outcome(self._clock())
        if outcome is not None:
            self._the_launch.tell(outcome)

    @property
    def _has_job(self) -> bool:
        return self._rounds.with_job is not None

    @property
    def _must_look_again(self) -> bool:
        return self._again.is_due and not self._has_job

    def _do(self, wanted: Steps, current: Round, *, must_ask: bool) -> None:
        away = self._away(wanted.restart)
        needs_job = (
            wanted.build
            or wanted.replan
            or wanted.after_build
            or current.suspects
            # a launch that begins now would build it
            or (away and not self._has_job)
        )
        if not self._worker.pid or not (needs_job or must_ask):
            self._put_off(away, wanted.restart, current)
            held = wanted.restart if current.suspects else away
            self._restart(without(wanted.restart, held), current)
            current.is_lost = bool(needs_job)
            return
        # what the job brings may be what a restart needs
        late = {*wanted.after_build, *wanted.restart, *self._late}
        current.late |= late
        self._late = set()
        self._ask(current)

    def _away(self, labels: Collection[str]) -> set[str]:
        """Return what cannot start now, as it is not installed any more."""
        packages = {
            package.name
            for package in self._knowledge.packages
            if package.share and not os.path.exists(package.share)
        }
        return {
            use.label
            for use in self._knowledge.processes
            if use.label in labels and use.packages & packages
        } | {
            process.label
            for process in self._plan.processes()
            if process.label in labels and not _is_there(process)
        }

    def _put_off(
        self, away: set[str], labels: Collection[str], current: Round
    ) -> None:
        """
        Have what is away restarted when the job that is under way is done.

        A build may take away what it installs, and all runs on meanwhile.
        """
        job = self._rounds.with_job
        if job is not None and away:
            job.late |= away
            job.files = {**job.files, **current.files}
            if away.issuperset(labels):
                # it is told of with that
                self._rounds.remove(current)

    def _ask(self, current: Round) -> None:
        """Have the launch prepared again; what is prepared now is void."""
        other = self._rounds.with_job
        if other is not None:
            current.take_over(other)
            self._rounds.remove(other)
        self._job_ended()
        if self._unsure_since is None:
            self._unsure_since = self._clock()
        self._learn_libraries()
        libraries = {p.label: p.libraries for p in self._knowledge.processes}
        try:
            self._worker.ask(Job(self._built, libraries, current.suspects))
        except OSError:
            # its end is noticed soon
            current.is_lost = True
            return
        current.has_job = True
        for descriptor in self._worker.job_descriptors:
            watches = self._the_launch.watches
            watches.add(descriptor, self._take_answers)

    def _restart(self, labels: Iterable[str], current: Round) -> None:
        current.add_restarted(self._the_launch.restart(tuple(labels)))

    # from the answer of the worker to what runs

    def _take_child(self, _: int) -> None:
        for group in self._worker.take_children():
            self._job_ended()
            # one that has answered already ends by itself
            if self._has_job:
                self._group = group
                self._the_launch.guard_group(group)

    def _take_answers(self, _: int) -> None:
        current = self._rounds.with_job
        try:
            for message in self._worker.take():
                if current is not None:
                    self._answered(message, current)
        except EOFError:
            if current is not None:
                self._fail(Failed('job'), current)

    def _answered(self, message: object, current: Round) -> None:
        match message:
            case Announced():
                text = f'{happened(current.files)}: {message.text}'
                self._the_launch.tell(events.Watched(text, is_final=False))
            case Prepared():
                # such as warnings of a compiler
                current.details = self._written()
                self._end_job(current)
                with suppress(RefusedError):
                    self._apply(message, current)
            case Failed():
                self._fail(message, current)

    def _written(self) -> str:
        return self._worker.written.decode(errors='replace').rstrip()

    def _end_job(self, current: Round) -> None:
        current.has_job = False
        self._prepared_at = self._clock()
        self._worker.forget()
        self._job_ended()

    def _worker_ended(self, outcome: Outcome) -> None:
        if self._group:
            with suppress(OSError):
                # nobody else ends its job
                os.killpg(self._group, signal.SIGINT)
        self._the_launch.release_group(self._worker.pid)
        self._worker.lost()
        self._job_ended()
        self._rounds.lose_worker()
        self._the_launch.tell(
            events.Warned(
                f'what builds for --watch {outcome}: from now on only what '
                'needs no build and no new plan is restarted'
            )
        )

    def _job_ended(self) -> None:
        if self._group and self._launch is not None:
            self._launch.release_group(self._group)
        self._group = 0

    def _fail(self, failure: Failed, current: Round) -> None:
        written = self._written()
        before, self._failure = self._failure, _NUMBER.sub('', written)
        if current.is_as_before and self._failure == before:
            # it stands on the screen already, but for how long it took
            written = ''
        self._end_job(current)
        self._is_owed = True
        self._late |= current.late
        for path in current.suspects:
            self._broken.setdefault(path, set())
        is_build = failure.what == 'build'
        self._knowledge = replace(self._knowledge, is_plan_broken=not is_build)
        seconds = self._clock() - current.since
        if is_build:
            self._the_launch.tell(
                events.Built(failure.packages, seconds, failed=True)
            )
        text = current.line(failed_by(failure.what), self._clock())
        self._rounds.remove(current)
        self._the_launch.tell(
            events.Watched(text, failed=True, details=written)
        )

    def _apply(self, prepared: Prepared, current: Round) -> None:
        """
        Have run what a launch that begins now would run.

        :raises RefusedError: when all is being stopped
        """
        launch = self._the_launch
        self._is_owed = False
        new = plan_difference(self._plan, prepared.plan, self._labels)
        is_other = prepared.grown_from != self._grown_from
        if is_other or (prepared.grown_from and not new.is_empty):
            self._begin_anew(current, 'there are event handlers in Python')
            return
        if (
            prepared.deployment != self._deployment
            or not prepared.machines <= self._machines
        ):
            self._begin_anew(current, 'it runs on other machines now')
            return
        if prepared.packages:
            seconds = self._clock() - current.since
            launch.tell(events.Built(prepared.packages, seconds))
            current.built = prepared.packages
        launch.renew_environment(prepared.environment)
        launch.blocks = new.plan.blocks
        touched = touched_by(prepared.changed, self._knowledge)
        if self._why:
            for label, reason in touched.items():
                self._explain(f'restart {label}, as {reason}')
        differs = set(new.differs)
        anew = {*touched, *current.late, *self._failed.unstarted}
        anew |= self._failed_before(prepared)
        anew -= {*differs, *new.gone}
        if not new.is_empty:
            started = _labels(new.new)
            launch.tell(events.Replanned(started, new.gone, new.differs))
            current.started = started
            current.stopped = new.gone
        current.waits.update(new.gone)
        for label in new.gone:
            launch.drop(label)
        launch.forget(new.dropped)
        kept = {*new.same, *differs}
        begun = [p for p in _parts(new.plan.entries) if p.label in kept]
        for part in begun:
            launch.revise(part, at_once=part.label not in differs)
        wanted = [p.label for p in begun if p.label in differs | anew]
        self._restart(self._compiled(wanted, prepared, current), current)
        launch.extend(new.new)
        current.waits |= _labels_at_once(new.new)
        self._plan = new.plan
        self._built = prepared.built
        self._knowledge = prepared.knowledge
        self._watch(prepared.since_ns)

    def _compiled(
        self, labels: Collection[str], prepared: Prepared, current: Round
    ) -> tuple[str, ...]:
        """Return what may be restarted, as its Python files compile."""
        broken: dict[str, set[str]] = {}
        for path in prepared.broken:
            changed = Change('changed', path, path)
            found = steps(
                consequences([changed], self._knowledge), self._knowledge
            )
            # what is installed, here or elsewhere, may be a copy
            name = os.path.basename(path)
            copies = {
                place: package
                for place, package in prepared.changed.items()
                if os.path.basename(place) == name
            }
            broken[path] = {
                *self._broken.get(path, ()),
                *found.restart,
                *touched_by(copies, self._knowledge),
            }
            if not broken[path].isdisjoint(labels):
                text = prepared.broken[path]
                current.details = f'{current.details}\n{text}'.lstrip()
        self._broken = broken
        held = set[str]().union(*broken.values())
        current.broken = tuple(one for one in labels if one in held)
        return without(labels, held)

    def _failed_before(self, prepared: Prepared) -> set[str]:
        """
        Return what has failed, and may go well by what was built.

        It may have missed what is as it was before, by a build that was under
        way, or while a package was not there.
        """
        since, self._unsure_since = self._unsure_since, None
        late = set() if since is None else self._failed.crashed_since(since)
        failed = self._failed.crashed_since(-math.inf)
        built = set(prepared.packages)
        return {
            use.label
            for use in prepared.knowledge.processes
            if use.label in (failed if built & use.packages else late)
            and use.packages
        }

    def _begin_anew(self, current: Round, why: str) -> None:
        """
        End the launch, to run it anew.

        What has grown already, and what event handlers remember, is not to
        be told from what the other handlers would have done.

        :param why: Why, as a part of a sentence
        """
        line = f'the launch begins anew, as {why}'
        text = current.line(line, self._clock())
        self._rounds.remove(current)
        self._begins_anew = True
        self._the_launch.tell(events.Watched(text))
        self._the_launch.stop('it begins anew')

    # what comes up

    def _came_up(
        self,
        event: events.Started
        | events.StartFailed
        | events.Loaded
        | events.LoadFailed,
        *,
        failed: bool,
    ) -> None:
        part = (
            event.component
            if isinstance(event, events.Loaded | events.LoadFailed)
            else event.process
        )
        label = part.label
        self._labels.add(label)
        now = self._clock()
        self._failed.came_up(label, now, failed=failed)
        for one in self._rounds.came_up(label, failed=failed):
            self._the_launch.tell(events.Restarted(part, now - one.since))

    # what is waited for

    @property
    def _the_launch(self) -> RunningLaunch:
        assert self._launch is not None
        return self._launch

    def _watch(self, since_ns: int) -> None:
        known = self._knowledge
        assert self._watcher is not None
        self._watcher.watch(known.folders(), known.files(), since_ns)

    def _learn_libraries(self) -> None:
        groups = self._the_launch.groups()
        self._knowledge = with_libraries(self._knowledge, groups)


def _is_there(process: Process) -> bool:
    """Tell whether the program of a process is where it was."""
    program = process.argv[0] if process.argv else ''
    is_path = isinstance(program, str) and os.path.isabs(program)
    return not is_path or os.path.exists(str(program))


def _parts(entries: Iterable[Entry]) -> list[Process | Component]:
    plan = Plan(tuple(entries))
    return [*plan.processes(), *plan.components()]


def _labels(entries: Iterable[Entry]) -> tuple[str, ...]:
    return tuple(part.label for part in _parts(entries))


def _labels_at_once(entries: Iterable[Entry]) -> set[str]:
    """Return the labels of what begins now, and not behind a timer."""
    return {e.label for e in entries if isinstance(e, Process)}
