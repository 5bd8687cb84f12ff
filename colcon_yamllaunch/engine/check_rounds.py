# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What `--until` waits for, checked after each change of a file."""

from collections.abc import Callable
from collections.abc import Iterable
import time

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.engine.output.line_pattern import LinePattern
from colcon_yamllaunch.engine.output.line_pattern import SearchTimeError
from colcon_yamllaunch.engine.output.lines import bare


class CheckRounds(ExitConditions):
    """
    Tells after each change whether all was seen, and ends no launch.

    What a process wrote counts for as long as it runs the code that wrote
    that. So after a change only what was started anew has to prove itself.

    :param until: Expressions; each must be found in a line of any process
    :param timeout: Seconds within which all must have been found; without,
      that must be so when everything has ended, or something has failed
    :param clock: Returns seconds that never go back
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
        # the process that wrote what was found, and when the round was that
        self._proofs: dict[str, tuple[str, float]] = {}
        self._begun = 0.0
        self._is_open = False
        self._failures: list[str] = []
        self._running: set[str] = set()
        self._has_run = False

    def begin(self) -> None:
        """Begin the first round."""
        self._open()

    def handle(self, event: events.Event) -> None:
        """Listen to an event."""
        match event:
            case events.Output():
                self._look(event)
            case events.Started():
                self._running.add(event.process.label)
                self._has_run = True
            case events.Exited():
                label = event.process.label
                self._running.discard(label)
                if event.failed and event.respawn_delay is None:
                    self._failures.append(f'{label} {event.outcome}')
            case events.StartFailed() | events.TransitionFailed():
                self._forget(event.process.label)
                self._failures.append(f'{event.process.label} failed')
            case events.LoadFailed():
                self._failures.append(f'{event.component.label} failed')
            case events.Restarted() | events.Dropped():
                self._forget(event.process.label)
            case events.Changed():
                # nothing is judged half way
                self._is_open = False
            case events.Watched(is_final=True, failed=False):
                self._open()
            case _:
                return

    def due(self) -> float | None:
        """Return when to ask for a reason to stop, on the clock, or None."""
        if not (self._is_open and self._until):
            return None
        if self._is_decided:
            return self._begun
        return None if self._limit is None else self._begun + self._limit

    def waited_for(self) -> tuple[str, ...]:
        """Return what has not been seen in this round, if one is open."""
        return tuple(self._missing) if self._is_open else ()

    def reason_to_stop(self) -> None:
        """Tell what came of the round when that is clear; stop nothing."""
        due = self.due()
        if due is None or self._now() < due:
            return
        self._is_open = False
        self.tell(
            events.Checked(
                not (self._missing or self._failures),
                tuple(self._missing),
                tuple(self._failures),
                self._now() - self._begun,
            )
        )

    def verdicts(self) -> tuple[events.Verdict, ...]:
        """Return what came of everything at last, in the order given."""
        return tuple(
            events.Verdict(
                f'--until {text}',
                self._proofs[text][1]
                if text in self._proofs
                else self._now() - self._begun,
                None
                if text in self._proofs
                else f"'{text}' was not seen after the last change (--until)",
            )
            for text in self._until
        )

    @property
    def _missing(self) -> list[str]:
        return [text for text in self._until if text not in self._proofs]

    @property
    def _is_decided(self) -> bool:
        has_ended = self._has_run and not self._running
        return not self._missing or bool(self._failures) or has_ended

    def _open(self) -> None:
        """Begin a round."""
        self._begun = self._now()
        self._is_open = True
        self._failures.clear()

    def _forget(self, label: str) -> None:
        """Forget what was found in the output of a process."""
        for text, (writer, _) in list(self._proofs.items()):
            if writer == label:
                del self._proofs[text]

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
                self._proofs[text] = event.process.label, seconds
