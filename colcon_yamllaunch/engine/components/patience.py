# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""When to say that something has been waited for."""

from collections.abc import Callable
from collections.abc import Iterable

from colcon_yamllaunch.engine import limits


class Patience:
    """Says of each thing after a while that it is waited for, then seldom."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        # since when, the seconds after which to say it next
        self._next: dict[str, tuple[float, float]] = {}

    def is_over(self, key: str, since: float) -> bool:
        """
        Tell whether to say now that something has been waited for.

        :param since: Since when; a new time begins anew
        """
        seconds = self._after(key, since)
        if self._clock() < since + seconds:
            return False
        pause = min(2 * seconds, limits.LONGEST_SILENCE)
        after = max(seconds, self._clock() - since) + pause
        self._next[key] = since, after
        return True

    def forget(self, key: str) -> None:
        """Take into account that something is not waited for any more."""
        self._next.pop(key, None)

    def seconds_to_wait(
        self, waited_for: Iterable[tuple[str, float]]
    ) -> float | None:
        """Return when to ask again; each with the time since when."""
        now = self._clock()
        return min(
            (
                max(0.0, since + self._after(key, since) - now)
                for key, since in waited_for
            ),
            default=None,
        )

    def _after(self, key: str, since: float) -> float:
        begun, seconds = self._next.get(key, (since, limits.PATIENCE))
        return seconds if begun == since else limits.PATIENCE
