# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The process that reads launch files in Python, for as long as it is used."""

from collections.abc import Mapping
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.participants import Participant
    from colcon_yamllaunch.language.evaluation.launch_worker import Growing
    from colcon_yamllaunch.python_launch.worker_process import WorkerProcess


class HostKeeper:
    """
    The process that reads launch files in Python, if there is one.

    :param environment: The user's environment
    :param log_folder: Where it keeps a log, or None to keep none
    """

    def __init__(
        self,
        cwd: Path,
        environment: Mapping[str, str],
        log_folder: Path | None,
    ) -> None:
        self._cwd = cwd
        self._environment = environment
        self._log_folder = log_folder
        self._host: WorkerProcess | None = None
        # what it runs in
        self._variables: Mapping[str, str] = {}

    @property
    def identity(self) -> str:
        """The identity that the launch has by it, or an empty text."""
        return '' if self._host is None else self._host.identity

    def open(self, variables: Mapping[str, str]) -> 'WorkerProcess':
        """
        Return the process that reads launch files in Python.

        It is the one that there is, unless it is in another environment.

        :param variables: What it is to run in
        :raises UserError: when the user's time limit is no number
        """
        # most launch files are not in Python
        from colcon_yamllaunch.engine.stopping.launch_scan import new_identity
        from colcon_yamllaunch.python_launch import worker_process

        if self._host is not None and (
            self._host.is_spent or self._variables != variables
        ):
            self.close()
        if self._host is None:
            log = None
            if self._log_folder is not None:
                log = self._log_folder / worker_process.LOG_NAME
            self._host = worker_process.WorkerProcess(
                variables,
                str(self._cwd),
                log,
                new_identity(),
                worker_process.timeout_of(self._environment),
            )
            self._variables = variables
        return self._host

    def feeds(self, growing: 'Growing | None') -> 'Sequence[Participant]':
        """
        Return what extends the plan while it runs, if there is anything.

        :param growing: What turns its answers into plan, if it is asked more
        """
        if self._host is None:
            return ()
        if growing is None:
            self._host.release()
            return ()
        from colcon_yamllaunch.python_launch.plan_feed import PlanFeed

        self._host.entrust()
        return (PlanFeed(self._host, growing),)

    def release(self) -> None:
        """End it in order, as nothing more is asked of it."""
        if self._host is not None:
            self._host.release()

    def close(self) -> None:
        """End it if it runs."""
        if self._host is not None:
            self._host.close()
            self._host = None

    def disown(self) -> None:
        """Have nothing to do with it, in a fork of this process."""
        if self._host is not None:
            self._host.disown()
            self._host = None
