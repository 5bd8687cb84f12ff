# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is used of the connection to a machine, before its launch starts."""

from collections.abc import Callable
from collections.abc import Mapping
from collections.abc import Sequence
from typing import Any
from typing import Protocol

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

    @property
    def errors(self) -> str:
        """What it wrote last to standard error; after its end."""

    def end_input(self) -> None:
        """Let the program see the end of what it reads."""

    def wait(self) -> int:
        """Wait for its end, and return its exit code (128 + a signal)."""

    def close(self) -> None:
        """Close the descriptors, and end it if it runs."""


class Connection(Protocol):
    """The connection; a `MachineConnection` is one."""

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
