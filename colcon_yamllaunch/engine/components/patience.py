# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""When to say that something has been waited for."""

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.loop import TimerHandle


class Patience:
    """
    Says of each thing after a while that it is waited for, then seldom.

    The loop has a turn when it is time to ask, if :meth:`is_over` was asked
    before.
    """

    def __init__(self, loop: Loop) -> None:
        self._loop = loop
        self._alarms: dict[str, TimerHandle] = {}
        # since when, the seconds after which to say it next
        self._next: dict[str, tuple[float, float]] = {}

    def is_over(self, key: str, since: float) -> bool:
        """
        Tell whether to say now that something has been waited for.

        :param since: Since when; a new time begins anew
        """
        seconds = self._after(key, since)
        now = self._loop.time()
        if now < since + seconds:
            self._wake_at(key, since + seconds)
            return False
        pause = min(2 * seconds, limits.LONGEST_SILENCE)
        after = max(seconds, now - since) + pause
        self._next[key] = since, after
        self._wake_at(key, since + after)
        return True

    def forget(self, key: str) -> None:
        """Take into account that something is not waited for any more."""
        self._next.pop(key, None)
        alarm = self._alarms.pop(key, None)
        if alarm is not None:
            alarm.cancel()

    def _wake_at(self, key: str, due: float) -> None:
        alarm = self._alarms.get(key)
        if alarm is None or alarm.when() != due:
            if alarm is not None:
                alarm.cancel()
            self._alarms[key] = self._loop.call_at(due, self._loop.wake)

    def _after(self, key: str, since: float) -> float:
        begun, seconds = self._next.get(key, (since, limits.PATIENCE))
        return seconds if begun == since else limits.PATIENCE
