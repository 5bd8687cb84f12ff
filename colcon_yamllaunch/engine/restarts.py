# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Decides when processes that ended start again, and starts them.

Launch files request that by `respawn`, and deployment files by `restart`. Only
a launch in which such a process ends imports this.
"""

from collections.abc import Mapping
from contextlib import suppress
import math
import os
import shlex
import signal
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.frozen import mutable
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.process_stop import ProcessStop, ProcessTask
from colcon_yamllaunch.engine.spawn import StartError
from colcon_yamllaunch.plan.member_settings import Restart
from colcon_yamllaunch.plan.plan import Process

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.engine import Engine
    from colcon_yamllaunch.engine.supervisor import Supervisor


@mutable
class Respawn:
    """
    A process that waits for its next start.

    :param due: When it may start, by the clock of the loop
    :param is_clean: Whether it is known to have left nothing running that
      `cleanup` does not end
    :param cleanup: The end of what it left running, if it did
    :param command: The command that its settings run before, if still to do
    :param command_group: The process group of that, while it runs
    """

    task: ProcessTask
    due: float
    is_clean: bool
    cleanup: ProcessStop | None = None
    command: tuple[str, ...] = ()
    command_group: int | None = None

    def is_due(self, now: float) -> bool:
        """Return whether its time has come and its last run has ended."""
        if now < self.due or not self.is_clean or self.command_group:
            return False
        return self.cleanup is None or self.cleanup.escalation.is_over

    def cancel(self) -> None:
        """End the command, and let run what the process left running."""
        if self.cleanup is not None:
            self.cleanup.cancel()
        if self.command_group is not None:
            with suppress(ProcessLookupError):
                os.killpg(self.command_group, signal.SIGKILL)


class Restarts:
    """
    The processes of a launch that wait for their next start.

    :param supervisor: Starts processes and ends the launch
    :param engine: Finds processes, runs commands and emits events
    :param groups: The process groups of the launch, with their numbers
    :param waiting: Receives the processes that wait, by their numbers
    """

    def __init__(
        self,
        supervisor: 'Supervisor',
        engine: 'Engine',
        loop: Loop,
        groups: Mapping[int, int],
        waiting: dict[int, Respawn],
    ) -> None:
        self._supervisor = supervisor
        self._engine = engine
        self._loop = loop
        self._groups = groups
        self._waiting = waiting
        # when to search again for what processes left running
        self._next_search = -math.inf

    def end_turn(self) -> None:
        """Start the processes whose next start is due."""
        self._clean_up()
        self._start_due()

    def cancel(self, task: ProcessTask) -> None:
        """Cancel the next start of a process, if it waits for one."""
        respawn = self._waiting.pop(task.number, None)
        if respawn is not None:
            respawn.cancel()

    def cancel_all(self) -> None:
        """Cancel the next starts of all processes."""
        for respawn in self._waiting.values():
            respawn.cancel()
        self._waiting.clear()

    def delay(
        self, task: ProcessTask, seconds: float, failed: bool
    ) -> float | None:
        """
        Return after how many seconds a process that ended starts again.

        :param seconds: For how long it ran
        :returns: None if it does not start again
        """
        if self._supervisor.is_required(task, failed):
            return None
        policy = _policy_of(task)
        if policy is None:
            return self._respawn_delay(task, seconds)
        return self._restart_delay(task, policy, seconds, failed)

    def _respawn_delay(
        self, task: ProcessTask, seconds: float
    ) -> float | None:
        """
        Return after how many seconds its launch file starts a process again.

        :param seconds: For how long it ran
        :returns: None if it does not start again
        """
        process = task.process
        retries = process.respawn_max_retries
        may_retry = retries < 0 or task.respawns < retries
        if not (process.respawn and may_retry):
            return None
        is_quick = seconds < limits.QUICK_END_SECONDS
        task.quick_ends = task.quick_ends + 1 if is_quick else 0
        return _delay_of_respawn(process, task.quick_ends)

    def _restart_delay(
        self, task: ProcessTask, policy: Restart, seconds: float, failed: bool
    ) -> float | None:
        """
        Return after how many seconds its settings start a process again.

        The delay is doubled each time, and begins anew once the process has
        run for longer than the longest delay.

        :param seconds: For how long it ran
        :returns: None if it does not start again
        """
        if not _restarts_after(policy, failed):
            return None
        now = self._loop.time()
        if policy.window is not None:
            since = now - policy.window
            task.restarts = [t for t in task.restarts if t > since]
        if 0 <= policy.limit <= len(task.restarts):
            return None
        if seconds > policy.longest_delay:
            task.doublings = 0
        # no more powers than any delay needs
        factor = 2.0 ** min(task.doublings, 30)
        task.doublings += 1
        task.restarts.append(now)
        return min(policy.first_delay * factor, policy.longest_delay)

    def restart_later(
        self, task: ProcessTask, delay: float, *, is_clean: bool
    ) -> None:
        """
        Start a process again.

        :param is_clean: Whether it cannot have left anything running, which
          would have to end before
        """
        due = self._loop.time() + delay
        self._loop.wake_at(due)
        respawn = Respawn(task, due, is_clean)
        self._waiting[task.number] = respawn
        policy = _policy_of(task)
        if policy is not None:
            respawn.command = policy.command
            return
        is_paused = delay > task.process.respawn_delay
        if is_paused and not task.is_pause_reported:
            task.is_pause_reported = True
            self._engine.emit(
                events.Warned(
                    f'{task.process.label} ended within '
                    f'{limits.QUICK_END_SECONDS:g} s of its start '
                    f'more than {limits.QUICK_ENDS_WITHOUT_PAUSE} times in a '
                    'row; it is started again after a pause now, which grows '
                    f'to {limits.LONGEST_RESTART_PAUSE:g} s; set '
                    'respawn_delay for a fixed pause'
                )
            )

    def check_limit(self, task: ProcessTask, failed: bool) -> None:
        """Report that the settings of a process allow no further restart."""
        policy = _policy_of(task)
        if policy is None or not _restarts_after(policy, failed):
            return
        if self._supervisor.is_required(task, failed):
            # it ends the launch instead
            return
        self._engine.emit(
            events.RestartLimit(
                task.process, policy.limit, policy.window, policy.beyond
            )
        )
        if policy.beyond == 'fail' and not self._supervisor.outlasts_failures:
            self._supervisor.stop(f'{task.process.label} keeps ending')

    def _clean_up(self) -> None:
        """Begin to end what the last runs of processes left running."""
        begin = self._loop.time()
        unclean = [r for r in self._waiting.values() if not r.is_clean]
        if not unclean or begin < self._next_search:
            return
        found = self._engine.orphans(self._groups, self._supervisor.groups)
        numbers = {orphan.number for orphan in found}
        for respawn in unclean:
            respawn.is_clean = True
            if respawn.task.number in numbers:
                respawn.cleanup = ProcessStop(
                    self._engine, self._loop, self._groups, [respawn.task]
                )
        end = self._loop.time()
        self._next_search = end + limits.SEARCH_PAUSE_FACTOR * (end - begin)
        self._loop.wake_at(self._next_search)

    def _start_due(self) -> None:
        now = self._loop.time()
        for number, respawn in tuple(self._waiting.items()):
            if self._waiting.get(number) is not respawn:
                # one before it has ended the launch
                continue
            if respawn.is_due(now) and respawn.command:
                self._run_command(respawn)
            elif respawn.is_due(now):
                del self._waiting[number]
                respawn.cancel()
                if respawn.cleanup is not None:
                    respawn.cleanup.abandon()
                task = respawn.task
                task.respawns += 1
                self._engine.emit(
                    events.Respawned(task.process, task.respawns)
                )
                policy = _policy_of(task)
                for label in () if policy is None else policy.together:
                    self._supervisor.restart_running(label)
                self._supervisor.start_again(task)

    def _run_command(self, respawn: Respawn) -> None:
        """Run the command that must succeed before a process starts again."""
        task, command = respawn.task, respawn.command

        def ended(code: int) -> None:
            respawn.command_group = None
            if self._waiting.get(task.number) is not respawn:
                return
            if code == 0:
                respawn.command = ()
                self._loop.wake()
                return
            fail(f'exited with code {code}')

        def fail(how: str) -> None:
            process = task.process
            text = f"the command '{shlex.join(command)}' before its restart"
            self._engine.emit(events.Warned(f'{process.label}: {text} {how}'))
            del self._waiting[task.number]
            delay = self.delay(task, 0.0, True)
            if delay is None:
                self.check_limit(task, True)
            else:
                self.restart_later(task, delay, is_clean=True)

        try:
            respawn.command_group = self._engine.run_command(
                command, task.process, ended
            )
        except StartError as error:
            fail(f'could not be started: {error}')


def _policy_of(task: ProcessTask) -> Restart | None:
    """Return the `restart` of the settings of a process, if they have one."""
    settings = task.process.settings
    return None if settings is None else settings.restart


def _restarts_after(policy: Restart, failed: bool) -> bool:
    """Return whether a process is started again after an end."""
    return policy.when == 'always' or (policy.when == 'failure' and failed)


def _delay_of_respawn(process: Process, quick_ends: int) -> float:
    """
    Return after how many seconds a process is started again.

    That is what the launch file says. Where it says nothing, or 0, a process
    that ends at once time after time has to wait longer and longer, so that
    it does not keep the machine busy.

    :param quick_ends: How often in a row it ended at once
    """
    excess = quick_ends - limits.QUICK_ENDS_WITHOUT_PAUSE
    if process.respawn_delay > 0 or excess <= 0:
        return process.respawn_delay
    # no more powers than the longest pause needs
    pause = limits.SHORTEST_RESTART_PAUSE * 2.0 ** min(excess - 1, 10)
    return min(pause, limits.LONGEST_RESTART_PAUSE)
