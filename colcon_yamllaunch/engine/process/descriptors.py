# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The file descriptors of the launcher, and how many it may have."""

from contextlib import suppress
import os
from pathlib import Path
import resource
from typing import Any

from colcon_yamllaunch.engine.process.spawn import Spawn

# two pipes or terminals with both ends while starting, a terminal to type at,
# three log files
_PER_PROCESS = 6
_BESIDES = 128


def keep_to_ourselves() -> None:
    """
    Mark all descriptors but the first three as close-on-exec.

    Whoever started the launcher may have left some open for it; no process of
    the launch inherits them. The first three are opened if they are closed,
    so that nothing else gets their numbers.
    """
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(descriptor, True)
    os.close(descriptor)
    with os.scandir('/proc/self/fd') as entries:
        descriptors = [int(e.name) for e in entries]
    for descriptor in descriptors:
        if descriptor > 2:
            # one of them listed the folder, and is closed now
            with suppress(OSError):
                os.set_inheritable(descriptor, False)


def open_log(path: Path | None) -> int:
    """
    Return a descriptor for what a helper of the launch writes.

    :param path: The file; where there is none, or it cannot be written, that
      goes nowhere
    """
    if path is not None:
        with suppress(OSError):
            # it may be the first one who writes there
            path.parent.mkdir(parents=True, exist_ok=True)
            flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC
            return os.open(path, flags, 0o666)
    return os.open(os.devnull, os.O_WRONLY | os.O_CLOEXEC)


class DescriptorLimit:
    """
    The soft limit of open files, raised as far as a launch needs.

    :param processes: How many processes the plan has
    """

    def __init__(self, processes: int) -> None:
        self._before = resource.getrlimit(resource.RLIMIT_NOFILE)
        self._processes = 0
        self.expect(processes)

    def expect(self, processes: int) -> None:
        """Raise it for more processes."""
        self._processes += processes
        soft, hard = self._before
        wanted = _BESIDES + _PER_PROCESS * self._processes
        if hard != resource.RLIM_INFINITY:
            wanted = min(wanted, hard)
        self._raised = soft != resource.RLIM_INFINITY and wanted > soft
        self._during = (wanted, hard)
        if self._raised:
            resource.setrlimit(resource.RLIMIT_NOFILE, self._during)

    def wrapped(self, spawn: Spawn) -> Spawn:
        """Return a spawn whose processes have the limit as it was."""
        if not self._raised:
            return spawn

        def spawn_with_original_limit(*args: Any, **options: Any) -> int:
            # lowering our own limit meanwhile would make glibc reject the
            # descriptors above it
            pid = spawn(*args, **options)
            with suppress(OSError):
                resource.prlimit(pid, resource.RLIMIT_NOFILE, self._before)
            return pid

        return spawn_with_original_limit

    def restore(self) -> None:
        """Restore the limit."""
        if self._raised:
            resource.setrlimit(resource.RLIMIT_NOFILE, self._before)
