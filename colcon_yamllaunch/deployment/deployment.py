# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A deployment: the machines of a launch, and rules for its processes."""

from collections.abc import Mapping, Sequence
from dataclasses import field
from fnmatch import fnmatchcase
import os.path
from typing import Any, Literal

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.control.process_names import meant_by, ProcessNames
from colcon_yamllaunch.plan.plan import Member, Process
from colcon_yamllaunch.plan.position import Position

#: How a machine is reached.
Kind = Literal['ssh', 'slurm', 'connect']
#: How the code gets to a machine.
Sync = Literal['build', 'install', 'none']
#: What happens to a machine's part when the link to it is lost.
OnLost = Literal['stop', 'restart', 'keep']
#: The computer that the launch is started on, in rules.
HERE = 'here'


@dataclass(frozen=True, slots=True)
class Machine:
    """
    A machine that parts of a launch run on, as the user describes it.

    :param name: Its name in labels and messages; unique
    :param kind: How it is reached: through `ssh`, through Slurm, or through
      any other command that runs one with its stdin and stdout
    :param words: Of `ssh` the destination, one word; of `slurm` the options
      of an allocation; of `connect` the command, split into words
    :param workspace: The folder of the workspace there, absolute or
      beginning with `~/`; None for the same path as here if that exists
      there, or else the folder of that name in the home folder there
    :param sync: How the code gets there: its sources, which are built there;
      the installed files; or not at all
    :param on_lost: What happens to its part when the link is lost: it is
      stopped; it is stopped, and started again once the machine is back; or
      it runs on until the link is back
    :param lost_after: After how many seconds of silence the link is lost;
      None for the default
    :param env: Names of variables to send, besides those that always are
    :param values: Variables that are set there
    :param setup: A file there that is sourced first, or None
    :param python: The Python there, None to search for one
    :param position: Where the deployment file describes it, None for the
      command line
    """

    name: str
    kind: Kind
    words: tuple[str, ...]
    workspace: str | None = None
    sync: Sync = 'build'
    on_lost: OnLost = 'stop'
    lost_after: float | None = None
    env: tuple[str, ...] = ()
    values: tuple[tuple[str, str], ...] = ()
    setup: str | None = None
    python: str | None = None
    position: Position | None = None


@dataclass(frozen=True, slots=True)
class Setting:
    """
    A value that a rule sets, and the position of its key.

    :param value: See `process_settings.SETTINGS`
    :param length: How many characters the key has
    """

    value: Any
    position: Position
    length: int


@dataclass(frozen=True, slots=True)
class ProcessRule:
    """
    A rule: which machine runs processes, and their settings.

    It matches a process if all its conditions do.

    :param position: Where it is in the deployment file
    :param machine: The name of the machine, :data:`HERE`, or None if it says
      nothing about that
    :param settings: What it sets, by key
    :param name: The process, by a name or glob as `--stop` takes them, or
      None
    :param package: The package of its program, by a name or glob, or None
    :param executable: Its program, by a name or glob, or None
    :param length: How many characters the condition has in the file
    """

    position: Position
    machine: str | None = None
    settings: Mapping[str, Setting] = field(default_factory=dict)
    name: str | None = None
    package: str | None = None
    executable: str | None = None
    length: int = 1

    def selected(self, members: Sequence[Member]) -> set[int]:
        """Return the indices of what this rule selects."""
        known = [ProcessNames.of_plan(member) for member in members]
        meant = set(range(len(members)))
        if self.name is not None:
            meant = set(meant_by(self.name, known))
        return {i for i in meant if self._fits(members[i], known[i])}

    def _fits(self, member: Member, names: ProcessNames) -> bool:
        package, executable = self.package, self.executable
        if package is not None and not fnmatchcase(
            member.package or '', package
        ):
            return False
        # with a prefix such as gdb, only its ROS name has the program
        stem, _ = os.path.splitext(names.program)
        programs = {names.executable, names.program, stem}
        return executable is None or any(
            fnmatchcase(program, executable) for program in programs
        )

    def __str__(self) -> str:
        said = {
            'name': self.name,
            'package': self.package,
            'executable': self.executable,
        }
        given = {key: text for key, text in said.items() if text is not None}
        if list(given) == ['name']:
            return given['name']
        return ', '.join(f'{key}: {text}' for key, text in given.items())


@dataclass(frozen=True, slots=True)
class Deployment:
    """
    The machines of a launch, and the rules for its processes.

    :param machines: The machines by their names
    :param rules: For each setting, and for the machine, the first one that
      matches a process and says it decides; a process without a machine runs
      on this computer
    :param everything_on: The name of the machine that everything runs on, as
      if the launch had been started there; then no rule says where
    :param arguments: Launch arguments, which the command line overrides
    :param profiles: The names of its profiles
    :param files: The paths of the file and of those that it includes
    """

    machines: Mapping[str, Machine]
    rules: tuple[ProcessRule, ...] = ()
    everything_on: str | None = None
    arguments: Mapping[str, str] = field(default_factory=dict)
    profiles: tuple[str, ...] = ()
    files: tuple[str, ...] = ()

    @property
    def has_settings(self) -> bool:
        """Whether a rule sets something besides the machine."""
        return any(rule.settings for rule in self.rules)

    def machines_of(self, processes: Sequence[Process]) -> list[str | None]:
        """Return the names of the machines of processes, None for here."""
        machines = [self.everything_on] * len(processes)
        # the first rule decides
        placing = [rule for rule in self.rules if rule.machine is not None]
        for rule in reversed(placing):
            name = None if rule.machine == HERE else rule.machine
            for index in rule.selected(processes):
                machines[index] = name
        return machines
