# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Limits of time, for tests that tell a quick cause from a slow one.

Where nothing has to be told apart, a test waits with a `DEADLINE` instead.
"""

from collections.abc import Iterator
import contextlib
import subprocess
import sys
import time

#: The reference step: a Python that imports what most of ours do.
_STEP = [sys.executable, '-I', '-c', 'import asyncio, json, subprocess']
#: Seconds that it takes on an idle machine of the developers.
_USUAL = 0.08
_STEPS = 5


def _slowness() -> float:
    """Return how many times as long as usual the reference step takes now."""
    begin = time.monotonic()
    for _ in range(_STEPS):
        subprocess.run(_STEP, check=True)
    return (time.monotonic() - begin) / _STEPS / _USUAL


@contextlib.contextmanager
def within(seconds: float) -> Iterator[None]:
    """
    Fail unless the block ends in some seconds, or more on a slow machine.

    :param seconds: The limit on an idle machine of the developers
    """
    begin = time.monotonic()
    yield
    took = time.monotonic() - begin
    # who keeps to it needs no measurement
    if took >= seconds:
        limit = seconds * max(1.0, _slowness())
        assert took < limit, f'{took:.1f} s, and {limit:.1f} s are allowed'
