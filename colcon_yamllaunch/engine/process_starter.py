# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Starting processes of a plan, with their channels, variables and marks."""

from collections.abc import Iterable, Mapping
from contextlib import suppress
import errno
import os
from typing import TYPE_CHECKING

from colcon_yamllaunch.engine.cgroup import is_wanted, LaunchCgroup
from colcon_yamllaunch.engine.channels import Channel, open_terminal
from colcon_yamllaunch.engine.guard_link import GuardLink
from colcon_yamllaunch.engine.launch_scan import LAUNCH_ID_VARIABLE
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.own_files import ParameterFiles
from colcon_yamllaunch.engine.process_stop import timeouts_of
from colcon_yamllaunch.engine.relay import Relay
from colcon_yamllaunch.engine.spawn import (
    DescriptorLimit,
    spawn_process,
    StartError,
)
from colcon_yamllaunch.engine.terminals import Terminals
from colcon_yamllaunch.plan.plan import Process

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.engine import EngineSettings
    from colcon_yamllaunch.engine.resource_limits import ProcessLimits

_STREAMS = ('stdout', 'stderr')


class ProcessStarter:
    """
    Starts the processes of a launch.

    :param guard: Receives all processes
    :param processes: How many processes the plan has
    """

    def __init__(
        self,
        settings: 'EngineSettings',
        guard: GuardLink,
        files: ParameterFiles,
        relay: Relay,
        terminals: Terminals,
        processes: int,
    ) -> None:
        self._settings = settings
        self._guard = guard
        self._files = files
        self._relay = relay
        self._terminals = terminals
        #: The control group of the launch.
        self.cgroup = LaunchCgroup(
            settings.identity,
            wanted=is_wanted(settings.environment),
        )
        #: How many files may be open.
        self.descriptors = DescriptorLimit(processes)
        #: The variables of processes that say nothing else.
        self.variables: Mapping[str, str] = settings.environment
        self._limits: ProcessLimits | None = None
        relay.closing = terminals.closing = guard.closed

    def prepare(self, processes: Iterable[tuple[int, Process]]) -> list[str]:
        """
        Prepare for processes with limits; return warnings about these.

        To be called before anything starts.

        :param processes: All of them, with their numbers in the plan
        :raises UserError: when a limit cannot be set
        """
        limited = {
            number: process
            for number, process in processes
            if _is_restricted(process)
        }
        return self.limits.prepare(limited) if limited else []

    @property
    def limits(self) -> 'ProcessLimits':
        """The limits of processes."""
        if self._limits is None:
            # few launches have any
            from colcon_yamllaunch.engine.resource_limits import ProcessLimits

            self._limits = ProcessLimits(
                self.cgroup, self._settings.environment
            )
        return self._limits

    def start(
        self, number: int, process: Process, size: os.terminal_size | None
    ) -> int:
        """
        Start a process in a group of its own, and return that.

        :param number: Its number in the plan
        :param size: Of its terminals, None for pipes
        :raises StartError: when it cannot be started
        """
        argv = self.command_line(number, process)
        channels: list[Channel] = []
        try:
            for _ in _STREAMS:
                channels.append(_open_channel(size))
            with self._terminals.stdin_of(process, size) as stdin:
                stdout, stderr = channels
                environment = self.environment_of(process)
                environment |= self._settings.buffering.variables(
                    process, argv, environment
                )
                streams = stdin, stdout.writer, stderr.writer
                group = self._start(
                    number, process, argv, environment, streams
                )
        except BaseException:
            for channel in channels:
                os.close(channel.reader)
            raise
        finally:
            for channel in channels:
                os.close(channel.writer)
        self._relay.add(group, process, stdout.reader, stderr.reader)
        self._guard.started(number, group, timeouts_of(process))
        for stream, channel in zip(_STREAMS, channels, strict=True):
            self._guard.output(number, process, stream, channel.reader)
        keyboard = self._terminals.keyboard_of(process.label)
        if keyboard is not None:
            self._guard.output(number, process, None, keyboard)
        return group

    def ended(self, group: int, status: int) -> Outcome:
        """
        Return how a process has ended.

        :param status: What :func:`os.waitpid` returned
        """
        outcome = Outcome.from_status(status)
        if self._limits is None:
            return outcome
        return self._limits.explained(group, outcome)

    def _start(
        self,
        number: int,
        process: Process,
        argv: list[str],
        environment: dict[str, str],
        streams: tuple[int, int, int],
    ) -> int:
        if not _is_restricted(process):
            return self.start_helper(
                number, argv, environment, process.cwd, streams
            )
        self._mark(number, environment)
        spawn = self.limits.spawn_of(number, process)
        spawn.complete(environment, process.environment)
        if (user := spawn.user) is not None:
            with suppress(OSError):
                self._files.give(argv, user.pw_uid)
        group = spawn_process(
            argv,
            environment,
            # `~` of a user whom only this machine knows
            os.path.expanduser(process.cwd),
            streams,
            self.descriptors.wrapped(spawn),
        )
        self.limits.started(number, group, process)
        return group

    def start_helper(
        self,
        number: int,
        argv: list[str],
        environment: dict[str, str],
        cwd: str,
        streams: tuple[int, int, int],
    ) -> int:
        """Start a program that belongs to a number of the plan."""
        self._mark(number, environment)
        with self.cgroup.entered(number):
            return spawn_process(
                argv,
                environment,
                cwd,
                streams,
                self.descriptors.wrapped(self._settings.spawn),
            )

    def _mark(self, number: int, environment: dict[str, str]) -> None:
        environment[LAUNCH_ID_VARIABLE] = f'{self._settings.identity}.{number}'

    def command_line(self, number: int, process: Process) -> list[str]:
        """
        Return the command line of a process as it is started.

        :param number: Its number in the plan
        :raises StartError: when its parameter file cannot be written
        """
        try:
            return self._files.command_line(number, process)
        except (OSError, ValueError) as error:
            raise StartError(
                f'its parameter file cannot be written: {error}'
            ) from error

    def environment_of(self, process: Process) -> dict[str, str]:
        """Return the variables of a process as the plan has them."""
        environment = dict(self.variables)
        for name, value in process.environment:
            if value is None:
                environment.pop(name, None)
            else:
                environment[name] = value
        return environment


def _is_restricted(process: Process) -> bool:
    return process.settings is not None and process.settings.is_restricted


def _open_channel(size: os.terminal_size | None) -> Channel:
    """
    Open a pipe, or a terminal of a size, for output.

    :raises StartError: when there are too many open files, for instance
    """
    try:
        return Channel(*os.pipe()) if size is None else open_terminal(size)
    except OSError as error:
        cure = ''
        if error.errno == errno.EMFILE:
            cure = '; allow more of them: ulimit -n'
        reason = f'there is no pipe for its output: {error.strerror}{cure}'
        raise StartError(reason) from error
