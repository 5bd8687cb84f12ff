# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`--until` with `--watch`: a check after each change of a file."""

from collections.abc import Callable, Iterable
import time

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.engine.line_pattern import LinePattern, SearchTimeError
from colcon_yamllaunch.engine.lines import bare


class UntilChecks(ExitConditions):
    """
    Reports after each change whether all expressions were seen.

    A match counts until the process that wrote it restarts, so a check waits
    only for processes that a change has restarted. It never ends the launch.

    :param until: Expressions; each must be found in a line of any process
    :param timeout: Seconds within which all must be found; without it, a check
      ends when all processes have ended, or one has failed
    :param clock: The monotonic clock
    """

    def __init__(
        self,
        until: Iterable[LinePattern],
        timeout: float | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__(clock=clock)
        self._until = {pattern.text: pattern for pattern in until}
        self._limit = timeout
        self._now = clock
        # the process that wrote each match, and after how many seconds
        self._matches: dict[str, tuple[str, float]] = {}
        self._begun = 0.0
        self._is_open = False
        self._failures: list[str] = []
        self._running: set[str] = set()
        self._has_run = False

    def begin(self) -> None:
        """Begin a check."""
        self._begun = self._now()
        self._is_open = True
        self._failures.clear()

    def handle(self, event: events.Event) -> None:
        """Note an event of the launch."""
        match event:
            case events.Output():
                self._look(event)
            case events.Started():
                self._running.add(event.process.label)
                self._has_run = True
            case events.Exited():
                label = event.process.label
                self._running.discard(label)
                counts = event.failed and not events.is_optional(event)
                if counts and event.respawn_delay is None:
                    self._failures.append(f'{label} {event.outcome}')
            case (
                events.StartFailed(process=member)
                | events.TransitionFailed(member=member)
            ):
                self._forget(member.label)
                if not events.is_optional(event):
                    self._failures.append(f'{member.label} failed')
            case events.LoadFailed():
                self._failures.append(f'{event.component.label} failed')
            case events.Restarted() | events.Dropped():
                self._forget(event.member.label)
            case events.FilesChanged():
                # the next check begins once the change is handled
                self._is_open = False
            case events.ChangeReported(is_final=True, failed=False):
                self.begin()
            case _:
                return

    def due(self) -> float | None:
        """Return when the check ends, on the clock, or None."""
        if not (self._is_open and self._until):
            return None
        has_ended = self._has_run and not self._running
        if not self._missing or self._failures or has_ended:
            return self._begun
        return None if self._limit is None else self._begun + self._limit

    def waited_for(self) -> tuple[str, ...]:
        """Return the expressions that the current check waits for."""
        return tuple(self._missing) if self._is_open else ()

    def reason_to_stop(self) -> None:
        """Report the result of the check once it is known; stop nothing."""
        due = self.due()
        if due is None or self._now() < due:
            return
        self._is_open = False
        self.emit(
            events.ChangeChecked(
                not (self._missing or self._failures),
                tuple(self._missing),
                tuple(self._failures),
                self._now() - self._begun,
            )
        )

    def verdicts(self) -> tuple[events.Verdict, ...]:
        """Return the last result of each expression, in the order given."""
        verdicts = []
        for text in self._until:
            seconds, failure = self._now() - self._begun, None
            if text in self._matches:
                seconds = self._matches[text][1]
            else:
                failure = (
                    f"'{text}' was not seen after the last change (--until)"
                )
            verdicts.append(
                events.Verdict(f'--until {text}', seconds, failure)
            )
        return tuple(verdicts)

    @property
    def _missing(self) -> list[str]:
        return [text for text in self._until if text not in self._matches]

    def _forget(self, label: str) -> None:
        """Forget the matches in the output of a process."""
        for text, (writer, _) in list(self._matches.items()):
            if writer == label:
                del self._matches[text]

    def _look(self, event: events.Output) -> None:
        if not self._missing:
            return
        lines = bare(event.data)
        for text in self._missing:
            try:
                is_found = self._until[text].is_in(lines)
            except SearchTimeError:
                is_found = False
            if is_found:
                seconds = self._now() - self._begun
                self._matches[text] = event.process.label, seconds
