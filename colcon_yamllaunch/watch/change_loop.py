# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The change loop of `--watch`: from changed files to what restarts.

`consequences` decides what follows from a change. The preparer does
what needs more than a restart, while all processes go on running.
`pending_changes` has the changes that are being handled. What a failed job
has left undone follows the next successful one.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
import os
from pathlib import Path
import signal

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.engine import commands, events
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.participants import Participant, Reply
from colcon_yamllaunch.plan.plan import Member, Plan, Process
from colcon_yamllaunch.plan.plan_difference import plan_difference
from colcon_yamllaunch.watch.consequences import (
    affected_by_build,
    after_rewrite,
    changed_products,
    Consequence,
    consequences,
    Steps,
    steps,
    why_lines,
)
from colcon_yamllaunch.watch.dependencies import mapped_files
from colcon_yamllaunch.watch.pending_changes import (
    PendingChange,
    PendingChanges,
    without,
)
from colcon_yamllaunch.watch.preparer import (
    Announced,
    Begun,
    Failed,
    Prepared,
    Preparer,
)
from colcon_yamllaunch.watch.python_syntax import compiles
from colcon_yamllaunch.watch.watched_files import Batch, Change
from colcon_yamllaunch.watch.watcher import WatcherClient

#: Actions that may restart a process with a changed Python file.
_RESTARTS = ('restart', 'restart after build', 'build')
#: The most Python files that are compiled before a restart; a checkout may
#: change thousands.
_MOST_COMPILED = 50
#: Seconds after a file was different for a moment, or before that was noticed,
#: within which a process may fail because of it.
READ_WINDOW = 3.0
_FAILURES = {
    'build': 'the build failed',
    'plan': 'it cannot be launched so',
    'job': 'what prepares it was killed',
}


class ChangeLoop(Participant):
    """
    Keeps a running launch as its files say.

    :param current: What runs, as the preparation of a job would return it
    :param log: The file for the standard error of the watcher, or None
    :param clock: The monotonic clock
    :param why: Whether to explain what follows from each change
    :param cwd: The folder that paths are shown from
    """

    def __init__(
        self,
        current: Prepared,
        preparer: Preparer,
        log: Path | None,
        *,
        clock: Callable[[], float],
        why: bool,
        cwd: str,
    ) -> None:
        self._current = current
        self._dependencies = current.dependencies
        self._preparer = preparer
        self._log = log
        self._clock = clock
        self._why = why
        self._cwd = cwd
        self._watcher: WatcherClient | None = None
        self._launch: Engine | None = None
        self._restarts_launch = False
        self._changes = PendingChanges()
        # the changes since the user paused watching; None if it goes on
        self._paused: list[Batch] | None = None
        # all labels that were in use
        self._labels: set[str] = set()
        # files that were different for a moment, with when that was noticed
        self._rewritten: list[tuple[float, Change]] = []
        # those of them to check when no job runs, likewise
        self._unchecked: list[tuple[float, Change]] = []
        # the process group of the job, if one runs
        self._group = 0
        # what the last failed job left undone, if the last job failed
        self._has_failed_job = False
        self._late: set[str] = set()
        # when the first build began after the last successful one
        self._building_since: float | None = None
        # when the launch was last prepared
        self._prepared_at = clock()
        # the files that are mapped into processes, by label
        self._libraries: dict[str, frozenset[str]] = {}
        # the labels that are not restarted, by file that does not compile
        self._broken: dict[str, set[str]] = {}

    @property
    def restarts_launch(self) -> bool:
        """Whether the launch has ended only to begin again."""
        return self._restarts_launch and not self.launch.is_ended_by_others

    def children(self) -> Collection[int]:
        """Return the preparer, which was forked before the launch."""
        return {self._preparer.pid} - {0}

    @property
    def launch(self) -> Engine:
        """The launch that changes."""
        assert self._launch is not None
        return self._launch

    def join(self, engine: Engine) -> None:
        """Use a launch, which goes on after failures and without processes."""
        self._launch = engine
        engine.state.watch = ''
        engine.supervisor.outlasts_failures = True
        engine.dispatcher.add(commands.Watch, self._switch)
        if self._preparer.pid:
            engine.add_helper(self._preparer.pid, self._preparer_ended)

    def begin(self) -> None:
        """Watch the files of the launch from now on."""
        launch = self.launch
        self._watcher = WatcherClient(
            launch.loop,
            self._receive,
            lambda text: launch.emit(events.Warned(text)),
            self._log,
        )
        self._watcher.start()
        self._watch()
        self._preparer.begin(launch.loop, self._handle_job)

    def handle(self, event: events.Event) -> None:
        """Note an event of the launch."""
        match event:
            case events.Started() | events.StartFailed():
                failed = isinstance(event, events.StartFailed)
                self._started(event.process, failed=failed)
            case events.Loaded() | events.LoadFailed():
                failed = isinstance(event, events.LoadFailed)
                self._started(event.component, failed=failed)
            case events.Exited(asked=False, failed=True):
                self._crashed(event)
            case events.Dropped():
                self._changes.dropped(event.member.label)
            case events.Requested(action='stop' | 'kill'):
                self._changes.stopped(event.member.label)
            case _:
                return
        if self._is_due:
            self.launch.loop.wake()

    def prepare_end(self) -> bool:
        """Return whether to wait for a change, though no process runs."""
        return not self.launch.is_stopping

    def _switch(self, command: commands.Watch, _: Reply) -> commands.Done:
        """Collect changes from now on, or handle the collected ones."""
        pauses = command.action == 'pause'
        if pauses and self._paused is None:
            self._paused = []
            text = 'off: what is saved now has to wait'
            self.launch.emit(events.ChangeReported(text, is_paused=True))
        elif not pauses and self._paused is not None:
            batches, self._paused = self._paused, None
            self.launch.emit(
                events.ChangeReported('on again', is_paused=False)
            )
            if batches:
                changes = tuple(c for batch in batches for c in batch.changes)
                # a process that started since may have read the old files
                self._follow(Batch(changes, batches[0].seen_ns), self._clock())
        return commands.DONE

    def end_turn(self) -> None:
        """Do what is due; nothing more while the launch is being stopped."""
        if self.launch.is_stopping:
            self._changes.clear()
            self._unchecked.clear()
            self._preparer.cancel()
            if self._watcher is not None:
                self._watcher.hang_up()
            return
        if self._can_check:
            since = self._unchecked[0][0]
            files = tuple(file for _, file in self._unchecked)
            self._unchecked = []
            self._receive(Batch(files, round(since * 1e9)))
        for change in self._changes.pop_done(self._clock()):
            self._report(change)
        if self._is_due:
            self.launch.loop.wake()

    @property
    def _is_due(self) -> bool:
        return self._can_check or self._changes.has_done

    def close(self) -> None:
        """End the helper processes, and wait for that."""
        pid = self._preparer.pid
        if self._watcher is not None:
            self._watcher.close()
        self._preparer.close()
        if self._launch is not None and pid:
            self._launch.remove_helper(pid)
            self._release_job()

    # from the change to the steps

    def _receive(self, batch: Batch) -> None:
        if self._paused is None:
            self._follow(batch, batch.seen_ns / 1e9)
        else:
            self._paused.append(batch)

    def _follow(self, batch: Batch, since: float) -> None:
        """
        Handle changes.

        :param since: When they began, by the monotonic clock
        """
        rewritten = [c for c in batch.changes if c.kind == 'again']
        changes = [c for c in batch.changes if c.kind != 'again']
        found = (
            *consequences(changes, self._dependencies),
            *self._after_rewrite(rewritten, batch.seen_ns / 1e9),
        )
        wanted = steps(found, self._dependencies)
        if self._why:
            for line in why_lines(found, self._cwd):
                self._explain(line)
        if wanted == Steps():
            return
        relevant = [one.change for one in found if one.action != 'ignore']
        files = {os.path.basename(c.path): c.kind for c in relevant}
        current = PendingChange(since, files, kept=wanted.kept)
        current.suspects = self._suspects(found)
        if changes or wanted.restart or wanted.after_build:
            paths = tuple(dict.fromkeys(c.path for c in relevant))
            self.launch.emit(events.FilesChanged(paths))
        # a build may have failed because a file was missing
        may_help = (self._has_failed_job or self._has_job) and any(
            c.kind != 'changed' for c in relevant
        )
        self._changes.add(current)
        self._do(wanted, current, may_help=may_help)

    def _suspects(self, found: Iterable[Consequence]) -> tuple[str, ...]:
        """Return the changed Python files that may not compile."""
        saved = [
            one.change.real
            for action in _RESTARTS
            for one in found
            if one.action == action and one.change.kind != 'deleted'
        ]
        paths = [*dict.fromkeys((*self._broken, *saved))][:_MOST_COMPILED]
        suspects = tuple(path for path in paths if not compiles(path))
        if not suspects:
            self._broken.clear()
        return suspects

    def _explain(self, text: str) -> None:
        self.launch.emit(events.ChangeReported(text, is_final=False))

    def _after_rewrite(
        self, files: Collection[Change], seen: float
    ) -> tuple[Consequence, ...]:
        """Return what follows from files that were different for a moment."""
        recent = [r for r in self._rewritten if r[0] >= seen - READ_WINDOW]
        now = [(seen, file) for file in files]
        self._rewritten = recent + now
        if files and self._has_job:
            # the job has probably read the right content, so it goes on
            self._unchecked += now
            return ()
        since = seen - READ_WINDOW
        needed = since if self._has_failed_job else seen
        return after_rewrite(
            files,
            self._dependencies,
            failed=self._crashed_since(since) | self._unstarted,
            has_prepared=self._prepared_at >= needed,
        )

    @property
    def _can_check(self) -> bool:
        return bool(self._unchecked) and not self._has_job

    @property
    def _has_job(self) -> bool:
        return self._changes.with_job is not None

    def _do(
        self, wanted: Steps, current: PendingChange, *, may_help: bool
    ) -> None:
        missing = self._missing(wanted.restart)
        needs_job = bool(
            wanted.build
            or wanted.replan
            or wanted.after_build
            or current.suspects
            # a launch that begins now would build it
            or (missing and not self._has_job)
        )
        if self._preparer.pid and (needs_job or may_help):
            # a restart may need what the job builds
            current.late |= {*wanted.after_build, *wanted.restart, *self._late}
            self._late = set()
            self._ask(current)
            return
        held = wanted.restart if current.suspects else missing
        current.is_lost = needs_job
        job = self._changes.with_job
        if job is not None and missing:
            # its build may just have removed the program for a moment
            job.late |= missing
            job.files = {**job.files, **current.files}
            if missing.issuperset(wanted.restart):
                self._changes.remove(current)
        self._restart(without(wanted.restart, held), current)

    def _missing(self, labels: Collection[str]) -> set[str]:
        """Return the labels whose program or package is not installed."""
        missing = {
            package.name
            for package in self._dependencies.packages
            if package.share and not os.path.exists(package.share)
        }
        found = {
            process.label
            for process in self._dependencies.processes
            if process.packages & missing
        }
        for process in self._current.plan.processes():
            program = process.argv[0] if process.argv else ''
            if (
                isinstance(program, str)
                and os.path.isabs(program)
                and not os.path.exists(program)
            ):
                found.add(process.label)
        return found.intersection(labels)

    def _ask(self, current: PendingChange) -> None:
        """Prepare the launch again; a running job is cancelled."""
        other = self._changes.with_job
        if other is not None:
            current.take_over(other)
            self._changes.remove(other)
        self._release_job()
        if self._building_since is None:
            self._building_since = self._clock()
        products = [p + os.sep for p in self._dependencies.products]
        for label, pid in self.launch.groups().items():
            mapped = mapped_files(pid, tuple(products))
            if mapped is not None:
                self._libraries[label] = mapped
        try:
            self._preparer.ask(current.suspects)
        except OSError:
            # the loop reports the end of the preparer soon
            current.is_lost = True
            return
        current.has_job = True

    def _restart(self, labels: Iterable[str], current: PendingChange) -> None:
        command = commands.RestartChanged(tuple(labels))
        current.add_restarted(self.launch.dispatcher.do(command).labels)

    # from the answer of the preparer to what runs

    def _handle_job(self, message: object) -> None:
        current = self._changes.with_job
        if current is None:
            return
        match message:
            case Begun():
                self._group = message.pid
                self.launch.guard_group(self._group)
            case Announced():
                self._explain(f'{current.title}: {message.text}')
            case Prepared():
                # for example, warnings of a compiler
                current.details = self._end_job(current)
                with suppress(RefusedError):
                    self._apply(message, current)
            case Failed():
                self._fail(message, current)

    def _end_job(self, current: PendingChange) -> str:
        """Return the output of a job that has answered."""
        output = self._preparer.written.decode(errors='replace').rstrip()
        current.has_job = False
        self._prepared_at = self._clock()
        self._preparer.forget()
        self._release_job()
        return output

    def _release_job(self) -> None:
        if self._group and self._launch is not None:
            self._launch.release_group(self._group)
        self._group = 0

    def _preparer_ended(self, status: int) -> None:
        if self._group:
            with suppress(OSError):
                # only the preparer would have ended its job
                os.killpg(self._group, signal.SIGINT)
        self._preparer.ended()
        self._release_job()
        self._changes.lose_preparer()
        outcome = Outcome.from_status(status)
        self.launch.emit(
            events.Warned(
                f'what builds for --watch {outcome}: from now on only what '
                'needs no build and no new plan is restarted'
            )
        )

    def _fail(self, failure: Failed, current: PendingChange) -> None:
        output = self._end_job(current)
        self._has_failed_job = True
        self._late |= current.late
        for path in current.suspects:
            self._broken.setdefault(path, set())
        is_build = failure.what == 'build'
        self._dependencies = replace(
            self._dependencies, is_plan_broken=not is_build
        )
        now = self._clock()
        if is_build:
            seconds = now - current.since
            built = events.Built(failure.packages, seconds, failed=True)
            self.launch.emit(built)
        self._changes.remove(current)
        what = f'{_FAILURES[failure.what]}, everything runs on as before'
        text = current.line(what, now)
        self.launch.emit(
            events.ChangeReported(text, failed=True, details=output)
        )

    def _apply(self, prepared: Prepared, current: PendingChange) -> None:
        """
        Change the launch to what a launch that begins now would run.

        :raises RefusedError: when the launch is being stopped
        """
        launch, before = self.launch, self._current
        self._has_failed_job = False
        new = plan_difference(before.plan, prepared.plan, self._labels)
        why = ''
        is_other = prepared.grown_from != before.grown_from
        if is_other or (prepared.grown_from and not new.is_empty):
            # handlers may have extended the plan, and have a state that a new
            # plan cannot restore
            why = 'there are event handlers in Python'
        elif (
            prepared.deployment != before.deployment
            or not prepared.machines <= before.machines
        ):
            why = 'it runs on other machines now'
        elif not launch.state.has_readiness and _needs_readiness(new.plan):
            why = 'processes wait for others now'
        if why:
            self._changes.remove(current)
            self._restarts_launch = True
            text = f'the launch begins anew, as {why}'
            launch.emit(
                events.ChangeReported(current.line(text, self._clock()))
            )
            launch.dispatcher.do(commands.Shutdown('it begins anew'))
            return
        if prepared.packages:
            seconds = self._clock() - current.since
            launch.emit(events.Built(prepared.packages, seconds))
            current.built = prepared.packages
        launch.renew_environment(prepared.environment)
        if not before.grown_from or len(new.plan.blocks) >= len(launch.blocks):
            # otherwise the running plan is longer than the new one
            launch.blocks = new.plan.blocks
        changed = changed_products(before.built, prepared.built)
        affected = affected_by_build(
            changed, self._dependencies, self._libraries
        )
        if self._why:
            for label, reason in affected.items():
                self._explain(f'restart {label}, as {reason}')
        wanted = {*affected, *current.late, *self._unstarted, *new.differs}
        wanted |= self._worth_retrying(prepared)
        if not new.is_empty:
            started = tuple(member.label for member in Plan(new.new).members())
            if started or new.gone or new.differs:
                launch.emit(events.Replanned(started, new.gone, new.differs))
            current.started = started
            current.stopped = new.gone
            current.revised = new.revised
        current.pending.update(new.gone)
        for label in new.gone:
            launch.dispatcher.do(commands.Drop(label))
            self._libraries.pop(label, None)
        launch.dispatcher.do(commands.Forget(new.dropped))
        kept = {*new.same, *new.differs}
        members = [p for p in new.plan.members() if p.label in kept]
        for member in members:
            at_once = member.label not in new.differs
            launch.dispatcher.do(commands.Revise(member, at_once))
        labels = [p.label for p in members if p.label in wanted]
        self._restart(
            self._compiled(labels, changed, prepared.broken, current), current
        )
        launch.dispatcher.do(commands.Extend(new.new))
        # timers start all others
        current.pending |= {e.label for e in new.new if isinstance(e, Process)}
        self._current = replace(
            prepared, plan=new.plan, machines=before.machines
        )
        self._dependencies = prepared.dependencies
        self._watch()

    def _compiled(
        self,
        labels: Collection[str],
        changed: Mapping[str, str],
        errors: Mapping[str, str],
        current: PendingChange,
    ) -> tuple[str, ...]:
        """
        Return the labels whose Python files compile.

        :param changed: The changed products
        :param errors: The errors of files that do not compile, by path
        """
        broken: dict[str, set[str]] = {}
        for path, error in errors.items():
            change = Change('changed', path, path)
            found = steps(
                consequences([change], self._dependencies), self._dependencies
            )
            # installed files, here or elsewhere, may be copies
            name = os.path.basename(path)
            copies = {
                copy: package
                for copy, package in changed.items()
                if os.path.basename(copy) == name
            }
            broken[path] = {
                *self._broken.get(path, ()),
                *found.restart,
                *affected_by_build(
                    copies, self._dependencies, self._libraries
                ),
            }
            if not broken[path].isdisjoint(labels):
                current.details = f'{current.details}\n{error}'.lstrip()
        self._broken = broken
        held = set[str]().union(*broken.values())
        current.broken = tuple(label for label in labels if label in held)
        return without(labels, held)

    def _worth_retrying(self, prepared: Prepared) -> set[str]:
        """
        Return what has failed, and may succeed after a build.

        A process may have failed because its files were missing during a
        build, even if they are the same again now.
        """
        since, self._building_since = self._building_since, None
        during = set() if since is None else self._crashed_since(since)
        crashed = self._crashed_since(0.0)
        built = set(prepared.packages)
        return {
            process.label
            for process in prepared.dependencies.processes
            if process.packages
            and process.label
            in (crashed if built & process.packages else during)
        }

    # what starts and fails

    def _started(self, member: Member, *, failed: bool) -> None:
        self._labels.add(member.label)
        for change in self._changes.started(member.label, failed=failed):
            seconds = self._clock() - change.since
            self.launch.emit(events.Restarted(member, seconds))

    def _crashed(self, event: events.Exited) -> None:
        now = self._clock()
        # it may have read a file that was different at that moment
        since = now - min(event.seconds, READ_WINDOW)
        self._unchecked += [
            (now, file) for seen, file in self._rewritten if seen >= since
        ]
        reported = self._changes.crashed(event.process.label, now)
        if reported is not None:
            self._report(reported)

    def _crashed_since(self, time: float) -> set[str]:
        """Return what has failed by itself, and was not started since."""
        state = self.launch.state
        return {
            label
            for label, failure in state.failures.items()
            if isinstance(failure, events.Exited)
            and not failure.asked
            and label in state.by_label
            and state.by_label[label].since >= time
        }

    @property
    def _unstarted(self) -> set[str]:
        """What could not be started or loaded."""
        return {
            label
            for label, failure in self.launch.state.failures.items()
            if isinstance(failure, events.StartFailed | events.LoadFailed)
        }

    def _report(self, change: PendingChange) -> None:
        event = change.result(self._clock())
        if event is not None:
            self.launch.emit(event)

    def _watch(self) -> None:
        known = self._dependencies
        assert self._watcher is not None
        since = self._current.since_ns
        self._watcher.watch(known.folders(), known.files(), since)


def _needs_readiness(plan: Plan) -> bool:
    """Return whether it matters for a plan which members are ready."""
    if all(member.settings is None for member in plan.members()):
        return False
    # only launches with a deployment need it
    from colcon_yamllaunch.engine.readiness import needs_readiness

    return needs_readiness(plan)
