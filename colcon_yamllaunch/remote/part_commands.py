# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Commands that only the launcher sends, to its part on a machine."""

from collections.abc import Mapping
from typing import ClassVar

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine.commands import Command
from colcon_yamllaunch.engine.commands import Done
from colcon_yamllaunch.engine.commands import PartCommand


@dataclass(frozen=True, slots=True)
class Usage:
    """
    The response to `Measure`.

    :param usage: By label the share of a processor, and bytes of memory
    """

    usage: Mapping[str, tuple[float, int]]


@dataclass(frozen=True, slots=True)
class Measure(Command[Usage]):
    """Measure what the processes use."""

    name: ClassVar[str] = 'measure'
    is_public: ClassVar[bool] = False


@dataclass(frozen=True, slots=True)
class Finish(Command[Done]):
    """End the part once nothing of it runs."""

    name: ClassVar[str] = 'finish'
    is_public: ClassVar[bool] = False


@dataclass(frozen=True, slots=True)
class Show(PartCommand[Done]):
    """Send what a process writes at once, and how its terminal reads keys."""

    name: ClassVar[str] = 'show'
    is_public: ClassVar[bool] = False


@dataclass(frozen=True, slots=True)
class Hide(PartCommand[Done]):
    """Send that no more."""

    name: ClassVar[str] = 'hide'
    is_public: ClassVar[bool] = False
