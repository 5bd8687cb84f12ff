# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What a launch leaves to be known by in case that its launcher is killed.

It stands beside the socket, with the same process id, and goes with that.
"""

from collections.abc import Iterable
from collections.abc import Mapping
from contextlib import suppress
import json
import os
from typing import Any

from colcon_yamllaunch.control.socket_folder import FolderError
from colcon_yamllaunch.control.socket_folder import folders
from colcon_yamllaunch.control.socket_folder import open_folder
from colcon_yamllaunch.engine.own_files import Place
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.engine.tasks import Task
from colcon_yamllaunch.plan.plan import DEFAULT_SIGKILL_TIMEOUT
from colcon_yamllaunch.plan.plan import DEFAULT_SIGTERM_TIMEOUT

#: The ending of a record's name.
SUFFIX = '.json'

_FLAGS = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC
_LAUNCH = ('title', 'package', 'file', 'folder', 'log_folder')
_PROCESS = ('label', 'name', 'executable', 'node', 'package')
_TIMEOUTS = DEFAULT_SIGTERM_TIMEOUT, DEFAULT_SIGKILL_TIMEOUT


class LaunchRecord:
    """
    The record of a launch; where it cannot be written there is none.

    :param identity: The identity of the launch
    """

    def __init__(self, identity: str) -> None:
        self._content: dict[str, Any] = {'identity': identity}
        # as JSON by their number; there may be thousands, one after another
        self._processes: list[str] = []
        self._timeouts: list[str] = []
        self._descriptor = -1
        self._folder = -1
        self._name = f'{os.getpid()}{SUFFIX}'

    def begin(
        self,
        environment: Mapping[str, str],
        launch: LaunchState,
        tasks: Iterable[Task],
    ) -> Place | None:
        """
        Write the record, and return where it is.

        :param environment: The variables that say where it may be
        :param tasks: The processes of the launch, in the order of its states
        """
        self._content |= {n: getattr(launch, n) for n in _LAUNCH}
        for task in tasks:
            self._note(launch, task)
        for folder in folders(environment):
            # why there is no socket there is said with that
            with suppress(OSError, FolderError):
                self._folder = open_folder(folder, make=True)
                return self._make(os.path.abspath(folder / self._name))
        return None

    def note(self, launch: LaunchState, tasks: Iterable[Task]) -> None:
        """Write processes that are new in the launch, or changed."""
        for task in tasks:
            self._note(launch, task)
        # the launch goes on without it
        with suppress(OSError):
            self._write()

    def note_parameters(self, place: Place) -> None:
        """Add where the parameter files are."""
        self._content['parameters'] = [place.path, place.device, place.inode]
        # the launch goes on without it
        with suppress(OSError):
            self._write()

    def end(self) -> None:
        """Remove the record."""
        if self._folder != -1:
            with suppress(OSError):
                os.unlink(self._name, dir_fd=self._folder)
            os.close(self._folder)
            self._folder = -1
        if self._descriptor != -1:
            os.close(self._descriptor)
            self._descriptor = -1

    def _note(self, launch: LaunchState, task: Task) -> None:
        missing = task.number + 1 - len(self._processes)
        self._processes += ['{}'] * missing
        self._timeouts += [json.dumps(_TIMEOUTS)] * missing
        process = task.process
        timeouts = process.sigterm_timeout, process.sigkill_timeout
        state = launch.process(process.label)
        assert state is not None
        known = {n: getattr(state, n) for n in _PROCESS}
        known['log'] = launch.log_of(state)
        self._processes[task.number] = json.dumps(known)
        self._timeouts[task.number] = json.dumps(timeouts)

    def _make(self, path: str) -> Place:
        try:
            # whoever had our process id before is gone
            with suppress(FileNotFoundError):
                os.unlink(self._name, dir_fd=self._folder)
            self._descriptor = os.open(
                self._name, _FLAGS, 0o600, dir_fd=self._folder
            )
            self._write()
            status = os.fstat(self._descriptor)
        except OSError:
            self.end()
            raise
        return Place(path, status.st_dev, status.st_ino)

    def _write(self) -> None:
        if self._descriptor != -1:
            text = (
                f'{json.dumps(self._content)[:-1]}, '
                f'"processes": [{", ".join(self._processes)}], '
                f'"timeouts": [{", ".join(self._timeouts)}]}}'
            )
            data = text.encode()
            os.pwrite(self._descriptor, data, 0)
            os.ftruncate(self._descriptor, len(data))
