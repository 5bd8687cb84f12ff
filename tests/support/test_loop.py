# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A loop whose time passes as the test says."""

from colcon_yamllaunch.engine.loop import Loop


class TestLoop(Loop):
    """
    A loop that never waits.

    :attr:`now` is its time. Descriptors are looked at in each turn.
    """

    # no test case, whatever its name looks like
    __test__ = False

    def __init__(self, now=100.0):
        super().__init__(lambda: self.now)
        self.now = now
        #: Whether :meth:`turn` and :meth:`pass_time` do nothing any more.
        self.is_over = lambda: False
        #: Is called after all callbacks of each turn.
        self.end_turn = lambda: None

    def run_once(self, until=None):
        super().run_once(until)
        self.end_turn()

    def turn(self, turns=20):
        """Run some turns at the time that it is."""
        for _ in range(turns):
            if not self.is_over():
                self.run_once()

    def pass_time(self, seconds):
        """Let time pass, with a turn whenever something is due."""
        end = self.now + seconds
        while not self.is_over():
            wait = super()._timeout()
            if wait is None or self.now + wait > end:
                break
            self.now += wait
            self.run_once()
        self.now = end
        self.turn()

    def next_due(self):
        """Return the seconds until something is due, or None."""
        return super()._timeout()

    def _timeout(self, until=None):
        return 0.0
