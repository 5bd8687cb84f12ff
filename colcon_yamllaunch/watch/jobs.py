# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the worker is asked for, and what it answers, as plain data."""

from collections.abc import Mapping
from dataclasses import field
from typing import Any
from typing import Literal

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.watch.knowledge import Knowledge


@dataclass(frozen=True, slots=True)
class Job:
    """
    The launch is to be prepared again, as one that begins now would be.

    :param built: What the builds were that the running processes have, see
      `build_effects`
    :param libraries: What is mapped into each process, by its label
    :param suspects: Python files that may not compile
    """

    built: Mapping[str, Any]
    libraries: Mapping[str, frozenset[str] | None]
    suspects: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Announced:
    """A line that the user should see while a job is done."""

    text: str


@dataclass(frozen=True, slots=True)
class Prepared:
    """
    A launch as it would begin now.

    :param environment: That of its processes
    :param knowledge: What it uses
    :param built: What its builds are
    :param changed: What differs in the install space from what the running
      processes were started with
    :param packages: The packages that the job has built
    :param since_ns: When it began, by the clock of the files
    :param grown_from: The files that it was made from, with their contents,
      if it grows while it runs
    :param deployment: What says which machines there are, and what is on
      them; empty if all is here
    :param machines: Those that parts of it run on
    :param broken: The errors of Python files that do not compile, by path
    """

    plan: Plan
    environment: Mapping[str, str]
    knowledge: Knowledge
    built: Mapping[str, Any]
    changed: Mapping[str, str]
    packages: tuple[str, ...]
    since_ns: int
    grown_from: Mapping[str, str] | None = None
    deployment: str = ''
    machines: frozenset[str] = frozenset()
    broken: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Failed:
    """
    A launch would not begin now; the output of the job tells why.

    :param what: What failed: the build, or else what the launch file says, or
      the job itself, as it was killed
    :param packages: The packages that were built all the same
    """

    what: Literal['build', 'plan', 'job']
    packages: tuple[str, ...] = ()
