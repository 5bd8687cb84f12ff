# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Exit conditions: what ends a launch by itself (`--until`, `--for`, …).

Times count from the moment when the launch begins to start processes, so
building is not counted.
"""

from collections.abc import Callable, Iterable
import time
from typing import TYPE_CHECKING

from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.lines import bare
from colcon_yamllaunch.engine.loop import do_nothing

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.line_pattern import LinePattern
    from colcon_yamllaunch.engine.readiness_record import ReadinessRecord


class ExitConditions:
    """
    Decides when a launch ends by itself.

    Without arguments, it never does.

    :param until: Expressions; each must be found in a line of any process.
      Then the launch is stopped
    :param timeout: Seconds within which all must have been found, or, if
      there is nothing to find, the launch must have ended
    :param duration: Seconds that the launch goes on for from when all was
      found; then it is stopped
    :param clock: Returns seconds that never go back
    :param begun: When the time for that begins, on the clock; None for when
      the launch does
    :param ready: The labels of members that must all be ready, as another
      thing to be found; None if it does not matter
    """

    def __init__(
        self,
        until: 'Iterable[LinePattern]' = (),
        timeout: float | None = None,
        duration: float | None = None,
        clock: Callable[[], float] = time.monotonic,
        begun: float | None = None,
        ready: Iterable[str] | None = None,
    ) -> None:
        self._readiness: ReadinessRecord | None = None
        self._wanted: dict[str, None] = {}
        if ready is not None:
            # few launches wait for that
            from colcon_yamllaunch.engine import readiness_record

            self._readiness = readiness_record.ReadinessRecord()
            self._wanted = dict.fromkeys(ready)
        self._ready_at: float | None = None
        self._patterns = tuple(until)
        self._unseen = list(dict.fromkeys(p.text for p in self._patterns))
        self._timeout = timeout
        self._duration = duration
        self._clock = clock
        self._start = clock()
        self._begun_at = begun
        self._seen: dict[str, float] = {}
        self._slow: dict[str, int] = {}
        self._given_up: str | None = None
        self._found_at = 0.0
        self._seconds = 0.0
        self._failed: str | None = None
        self._timed_out = False
        self._stopping = False
        #: Receives events about them while the launch runs.
        self.emit: Callable[[events.Event], object] = do_nothing

    def begin(self) -> None:
        """Count the time from now on."""
        self._start = self._clock()

    def handle(self, event: events.Event) -> None:
        """Handle an event."""
        if self._readiness is not None:
            self._note_readiness(self._readiness, event)
        match event:
            case events.Output():
                if self._unseen and not self._timed_out:
                    self._search(event)
            case _ if events.is_optional(event):
                # its failure does not count
                return
            case events.StartFailed() | events.Exited(failed=True):
                again = event.respawn_delay is not None
                self._note_failure(event.process.label, again=again)
            case events.LoadFailed():
                self._note_failure(event.component.label, again=event.again)
            case events.TransitionFailed():
                self._note_failure(event.member.label)
            case events.RosLost():
                self._note_failure('the ROS client')
            case events.WorkerLost():
                self._note_failure('the worker for Python launch files')
            case events.ShuttingDown():
                self._stopping = True
            case _:
                return

    def _note_readiness(
        self, readiness: 'ReadinessRecord', event: events.Event
    ) -> None:
        if self._stopping:
            return
        readiness.handle(event)
        match event:
            case events.Planned():
                optional = {
                    member.label
                    for member in event.members
                    if member.settings is not None and member.settings.optional
                }
                labels = (member.label for member in event.members)
                self._wanted |= dict.fromkeys(
                    label for label in labels if label not in optional
                )
            case events.Dropped():
                self._wanted.pop(event.member.label, None)
            case events.Ready() if self._wanted.keys() <= readiness.ready:
                self._found_at = self._clock() - self._start
                self._ready_at = self._found_at
            case _:
                return

    @property
    def _is_all_ready(self) -> bool:
        """Whether all members are ready that must be."""
        if self._readiness is None:
            return True
        return self._wanted.keys() <= self._readiness.ready

    @property
    def _has_goal(self) -> bool:
        """Whether there is something to find."""
        return bool(self._patterns) or self._readiness is not None

    @property
    def _is_reached(self) -> bool:
        """Whether all was found that there was to find."""
        return not self._unseen and self._is_all_ready

    def due(self) -> float | None:
        """Return when to ask for a reason to stop, on the clock, or None."""
        end = self._end()
        return None if end is None else end[0]

    def waited_for(self) -> tuple[str, ...]:
        """Return what has not been seen yet, as the user wrote it."""
        return () if self._stopping else tuple(self._unseen)

    def reason_to_stop(self) -> str | None:
        """Return once, when it is time, why the launch is to be stopped."""
        end = self._end()
        if end is None or self._clock() < end[0]:
            return None
        _, reason, self._timed_out = end
        self._stopping = True
        return reason

    def end(self) -> None:
        """Note that the launch is over."""
        self._seconds = self._clock() - self._start

    def verdicts(self) -> tuple[events.Verdict, ...]:
        """Return what came of everything, in the order given."""
        if self._timeout is not None and not self._has_goal:
            seconds = self._timeout if self._timed_out else self._seconds
            failure = None
            if self._timed_out:
                failure = (
                    f'the launch did not end in {seconds:g} s (--timeout)'
                )
            name = f'--timeout {self._timeout:g}'
            return (events.Verdict(name, seconds, failure),)
        found = tuple(
            events.Verdict(
                f'--until {text}',
                self._seen.get(text, self._seconds),
                self._not_seen(text) if text in self._unseen else None,
            )
            for text in dict.fromkeys(p.text for p in self._patterns)
        )
        if self._readiness is None:
            return found
        seconds = self._seconds if self._ready_at is None else self._ready_at
        failure = None
        if not self._is_all_ready:
            seconds = self._seconds
            failure = self._not_ready(self._readiness)
        return (*found, events.Verdict('--until-ready', seconds, failure))

    def failures(self) -> tuple[str, ...]:
        """Return what was not achieved, one a line."""
        return tuple(v.failure for v in self.verdicts() if v.failure)

    def _end(self) -> tuple[float, str, bool] | None:
        """
        Return when to stop the launch, and why; None for not yet known.

        :returns: The time on the clock, the reason, and whether it is a
          timeout
        """
        if self._stopping:
            return None
        if self._failed is not None:
            return self._start, f'{self._failed} failed', False
        if self._given_up is not None:
            reason = f"to search for '{self._given_up}' takes too long"
            return self._start, reason, False
        if self._is_reached and self._duration is not None:
            due = self._start + self._found_at + self._duration
            return due, f'it ran for {self._duration:g} s', False
        if self._has_goal and self._is_reached:
            return self._start, self._found(), False
        if self._timeout is None:
            return None
        begun = self._start if self._begun_at is None else self._begun_at
        return begun + self._timeout, f'{self._timeout:g} s are over', True

    def _search(self, event: events.Output) -> None:
        lines = bare(event.data)
        for pattern in self._patterns:
            if pattern.text in self._unseen and self._search_for(
                pattern, lines
            ):
                self._unseen.remove(pattern.text)
                self._found_at = self._clock() - self._start
                self._seen[pattern.text] = self._found_at

    def _search_for(self, pattern: 'LinePattern', lines: str) -> bool:
        """Search lines, and note a search that takes too long."""
        # few launches wait for a line
        from colcon_yamllaunch.engine.line_pattern import SearchTimeError

        try:
            return pattern.is_in(lines)
        except SearchTimeError:
            slow = self._slow.get(pattern.text, 0) + 1
            self._slow[pattern.text] = slow
            # all else waits meanwhile, Ctrl-C too
            if slow >= limits.SLOW_SEARCH_COUNT:
                self._given_up = pattern.text
            return False

    def _note_failure(self, label: str, *, again: bool = False) -> None:
        """
        Record the first failure if one failure decides the result.

        While something is waited for, a respawn may mend it.
        """
        if not self._has_goal and self._duration is None:
            return
        if self._failed is None and not (again and not self._is_reached):
            self._failed = label

    def _found(self) -> str:
        if self._readiness is not None:
            return f'all {len(self._wanted)} are ready'
        if len(self._seen) == 1:
            return f"'{next(iter(self._seen))}' was seen"
        return f'all {len(self._seen)} that --until waits for were seen'

    def _not_ready(self, readiness: 'ReadinessRecord') -> str:
        missing = [
            f'{label} ({readiness.reasons.get(label, "not started")})'
            for label in self._wanted
            if label not in readiness.ready
        ]
        seconds = f'{self._seconds:.1f} s, when the launch ended'
        if self._timed_out:
            seconds = f'{self._timeout:g} s'
        count = len(self._wanted) - len(missing)
        return (
            f'{count} of {len(self._wanted)} were ready after {seconds} '
            f'(--until-ready): {events.listed(missing)}'
        )

    def _not_seen(self, text: str) -> str:
        problem = (
            f"'{text}' was not seen before the launch ended after "
            f'{self._seconds:.1f} s (--until)'
        )
        if self._timed_out:
            problem = f"'{text}' was not seen in {self._timeout:g} s (--until)"
        if text in self._slow:
            problem += (
                ', but not all lines could be searched to the end, as that '
                'takes too long: use a simpler expression'
            )
        return problem
