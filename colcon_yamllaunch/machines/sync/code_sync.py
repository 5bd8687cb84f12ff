# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The code of a launch brought to one machine, by that machine's `sync:`."""

from collections.abc import Callable
from collections.abc import Mapping
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from typing import Protocol

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.packages.package import Package

#: What is said while it goes on, a line a call; the caller puts `arm│` before.
Say = Callable[[str], None]


class ProgramThere(Protocol):
    """A program that runs there; what `connection.stream` returns."""

    @property
    def stdin(self) -> int:
        """A descriptor here: what is written to it the program reads."""

    @property
    def stdout(self) -> int:
        """A descriptor here that gives what the program writes."""

    def wait(self) -> int:
        """Wait for its end, and return its exit code (128 + a signal)."""

    def close(self) -> None:
        """Close the descriptors, and end it if it runs."""


class Connection(Protocol):
    """What is used of a `MachineConnection`, before its launch starts."""

    def ask(
        self,
        request: str,
        arguments: Mapping[str, Any],
        on_line: Say | None = None,
    ) -> dict[str, Any]:
        """
        Have a function called there, and return what it returns.

        :param request: Its module and name, as `sources_there.compare`: a
          function of a `*_there.py` module, which takes the arguments and
          what a line is said with
        :param on_line: Is called with each line that it says meanwhile
        :raises UserError: what it raises there, or as the connection is lost
        """

    def stream(
        self,
        argv: Sequence[str],
        cwd: str | None = None,
        env: Mapping[str, str] | None = None,
    ) -> ProgramThere:
        """Start a program there."""


@dataclass(frozen=True, slots=True)
class Code:
    """
    The workspace here, as far as a machine needs it.

    :param root: The root of the workspace
    :param packages: All packages of the workspace
    :param needed: The names of the packages that the parts there use; those
      that these need come along, those of underlays are only looked for
    :param build_base: Where packages are built
    :param install_base: Where they are installed
    :param merge_install: Whether all packages are installed into one prefix
    :param build_arguments: Further arguments for `colcon build`
    :param settings: The arguments that packages are built with, as
      `BuildArguments.settings` has them
    """

    root: Path
    packages: Sequence[Package]
    needed: frozenset[str]
    build_base: Path
    install_base: Path
    merge_install: bool
    build_arguments: Sequence[str]
    settings: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Synced:
    """
    What came of it.

    :param transferred: How many files were brought or deleted
    :param built: The packages that were built there
    """

    transferred: int = 0
    built: frozenset[str] = frozenset()


def sync_code(
    mode: str,
    machine: str,
    workspace_there: str,
    connection: Connection,
    code: Code | None,
    say: Say,
) -> Synced:
    """
    Bring the code to one machine; in a thread for each machine.

    To interrupt it the connection is closed in another thread: what runs
    here and there is ended then, and it raises.

    :param mode: `build`, `install` or `none`
    :param machine: The name of the machine, for errors
    :param workspace_there: The root of the workspace there, absolute or
      with a leading `~/`
    :param code: The workspace here, or None: then there is nothing to do
    :param say: Is called with a line that the user should see at once
    :raises UserError: when the parts there cannot run with it; it names the
      machine and the way out
    """
    raise NotImplementedError
