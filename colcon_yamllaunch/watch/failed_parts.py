# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What has failed and was not started since, and when.

It may have failed by a file that was something else for a moment, or by a
build that was under way. So it is started anew when that is over, even if all
came out as it was before. Times are by the clock that never goes back.
"""


class FailedParts:
    """The processes and components of a launch that have failed."""

    def __init__(self) -> None:
        # when each part was started or loaded last
        self._began: dict[str, float] = {}
        # when each process failed that has not been started since
        self._crashed: dict[str, float] = {}
        #: What could not be started as things were.
        self.unstarted: set[str] = set()

    def came_up(self, label: str, now: float, *, failed: bool) -> None:
        """Take note that something was started, or could not be."""
        self._began[label] = now
        self._crashed.pop(label, None)
        self.unstarted.discard(label)
        if failed:
            self.unstarted.add(label)

    def crashed(self, label: str, now: float) -> float:
        """Take note that a process failed; return when it had begun."""
        self._crashed[label] = now
        return self._began.get(label, 0.0)

    def crashed_since(self, time: float) -> set[str]:
        """Return what has failed after it was started."""
        return {label for label, at in self._crashed.items() if at >= time}
