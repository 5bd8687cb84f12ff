# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The machines of a launch, and the rules for its processes."""

from collections.abc import Mapping
from collections.abc import Sequence
from fnmatch import fnmatchcase
import os.path

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.control.process_names import meant_by
from colcon_yamllaunch.control.process_names import ProcessNames
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.remote.deployment.machine import Machine

#: The computer that the launch is started on, in rules.
HERE = 'here'


@dataclass(frozen=True, slots=True)
class Rule:
    """
    Which processes run on a machine.

    It matches a process if all its conditions do.

    :param machine: The name of the machine, or :data:`HERE`
    :param position: Where it is in the deployment file
    :param name: The process, by a name or glob as `--stop` takes them, or
      None
    :param package: The package of its program, by a name or glob, or None
    :param executable: Its program, by a name or glob, or None
    :param length: How many characters the condition has in the file
    """

    machine: str
    position: Position
    name: str | None = None
    package: str | None = None
    executable: str | None = None
    length: int = 1

    def meant(self, processes: Sequence[Process]) -> set[int]:
        """Return the indices of the processes that this rule selects."""
        known = [ProcessNames.of_plan(process) for process in processes]
        meant = set(range(len(processes)))
        if self.name is not None:
            meant = set(meant_by(self.name, known))
        return {i for i in meant if self._fits(processes[i], known[i])}

    def _fits(self, process: Process, names: ProcessNames) -> bool:
        package, executable = self.package, self.executable
        if package is not None and not fnmatchcase(
            process.package or '', package
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
    :param rules: The first one that matches a process decides; a process
      without one runs on this computer
    :param everything_on: The name of the machine that everything runs on, as
      if the launch had been started there; then there are no rules
    """

    machines: Mapping[str, Machine]
    rules: tuple[Rule, ...] = ()
    everything_on: str | None = None

    def machines_of(self, processes: Sequence[Process]) -> list[str | None]:
        """Return the names of the machines of processes, None for here."""
        machines = [self.everything_on] * len(processes)
        # the first rule decides
        for rule in reversed(self.rules):
            name = None if rule.machine == HERE else rule.machine
            for index in rule.meant(processes):
                machines[index] = name
        return machines
