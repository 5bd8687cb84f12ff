# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a check knows while it goes through the launch files."""

from collections.abc import Iterator
from collections.abc import Mapping
from contextlib import contextmanager
import os

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.checking.argument_use import FileUse
from colcon_yamllaunch.language.checking.possible_scope import Guard
from colcon_yamllaunch.language.checking.possible_scope import Scope
from colcon_yamllaunch.language.evaluation.evaluation_state import State
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.position import Position
from colcon_yamllaunch.language.tree.text import Text
from colcon_yamllaunch.language.vocabulary.package_lookup import Packages


@dataclass(frozen=True, slots=True)
class OpenFile:
    """
    A launch file that is being looked at.

    :param path: The file
    :param origin: Where it is included, None for the outermost
    :param conditions: How many conditions there are around it
    """

    path: str
    origin: Text | None
    conditions: int


class Checking:
    """
    The state of a check.

    :param state: The state of an evaluation, for all that is known: it has the
      packages and the launch files that are open, and collects the problems
    :param portable: Whether to report what ROS 2 does not accept
    """

    def __init__(self, state: State, *, portable: bool) -> None:
        self.state = state
        self.portable = portable
        self.scope = Scope()
        #: The launch files that are open inside of one another.
        self.open: list[OpenFile] = []
        #: What the launch file that is open does with launch arguments.
        self.use = FileUse()
        #: The conditions around that only a launch decides.
        self.guards: list[Guard] = []
        #: How many of the conditions around hold in no launch.
        self.never = 0
        #: How many conditions there are around, of any kind.
        self.conditions = 0
        #: The launch file that was included last in the one that is open.
        self.included: str | None = None

    @property
    def packages(self) -> Packages:
        """The packages that there are."""
        return self.state.packages

    @property
    def environment(self) -> Mapping[str, str]:
        """The environment that the launch runs in."""
        return self.state.environment

    def includes(self) -> tuple[Position, ...]:
        """Return the includes that led to the open file, innermost first."""
        origins = (file.origin for file in reversed(self.open))
        return tuple(text.position for text in origins if text is not None)

    @contextmanager
    def within_scope(self, scope: Scope) -> Iterator[None]:
        """Check within another scope for the time of the context."""
        outer, self.scope = self.scope, scope
        try:
            yield
        finally:
            self.scope = outer

    def report(self, problem: LaunchError) -> None:
        """Note a problem, unless it is known."""
        self.state.report(problem)

    def error(
        self,
        message: str,
        position: Position | None,
        *,
        hint: str | None = None,
        length: int = 1,
    ) -> None:
        """Note an error; see :class:`Diagnostic`."""
        self.report(error(message, position, hint=hint, length=length))

    def warn(
        self,
        message: str,
        position: Position | None,
        *,
        hint: str | None = None,
        length: int = 1,
    ) -> None:
        """Note a warning; see :class:`Diagnostic`."""
        self.state.warn(message, position, hint=hint, length=length)

    def absolute(self, path: str) -> str:
        """Return the path that a relative one means."""
        return os.path.normpath(os.path.join(self.state.cwd, path))
