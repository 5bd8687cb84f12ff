# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What an evaluation knows while it goes through the launch files."""

from collections.abc import Callable
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
import math
from typing import TypeVar

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.plan.plan import Block
from colcon_yamllaunch.language.plan.plan import Condition
from colcon_yamllaunch.language.plan.plan import Entry
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.position import Position
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.language.tree.launch_tree import Item
from colcon_yamllaunch.language.tree.text import Text
from colcon_yamllaunch.language.vocabulary.scope import Scope
from colcon_yamllaunch.language.vocabulary.substitutions import parse_boolean

_Number = TypeVar('_Number', int, float)


@dataclass(frozen=True, slots=True)
class ExecutableUse:
    """
    A program of a package that the launch runs or names.

    :param package: The package
    :param name: The program
    :param path: Where it is, or will be once the package is built
    :param position: Where the launch file says so
    """

    package: str
    name: str
    path: str
    position: Position


class State:
    """
    The state of an evaluation; also what substitutions look at.

    :param request: What is to be evaluated
    """

    def __init__(self, request: Request) -> None:
        environment = dict(request.environment)
        self.packages = request.packages
        self.environment = environment
        self.cwd = request.cwd
        self.log_folder = request.log_folder
        self.scope = Scope(dict(request.arguments), dict(environment))
        self.entries: list[Entry] = []
        self.diagnostics: list[Diagnostic] = []
        self.packages_used: dict[str, Position] = {}
        self.executables: list[ExecutableUse] = []
        self.declared: set[str] = set()
        self.read: set[str] = set()
        self.node_names: set[str] = set()
        self.origins: tuple[Position, ...] = ()
        self.blocks: list[Block] = []
        self.conditions: list[Condition] = []
        self._sources: list[Source] = []
        self._includes: list[Position] = []
        self._open_blocks: list[int] = []
        self._reported: set[tuple[str, Position | None]] = set()
        self._count = 0

    @property
    def source(self) -> Source:
        """The launch file that is being evaluated."""
        return self._sources[-1]

    @property
    def depth(self) -> int:
        """How many launch files are open inside of one another."""
        return len(self._sources)

    @contextmanager
    def within(
        self, source: Source, included_from: Position | None
    ) -> Iterator[None]:
        """Evaluate another launch file for the time of the context."""
        self._sources.append(source)
        if included_from is not None:
            self._includes.append(included_from)
        try:
            yield
        finally:
            self._sources.pop()
            if included_from is not None:
                self._includes.pop()

    @property
    def block(self) -> int | None:
        """The index of the block that is being evaluated."""
        return self._open_blocks[-1] if self._open_blocks else None

    @contextmanager
    def within_block(
        self, kind: str, title: str, position: Position
    ) -> Iterator[None]:
        """Note a block for the time of the context."""
        self.blocks.append(Block(kind, title, position, self.block))
        self._open_blocks.append(len(self.blocks) - 1)
        try:
            yield
        finally:
            self._open_blocks.pop()

    def name_block(self, title: str) -> None:
        """Give the block that is being evaluated another title."""
        index = self._open_blocks[-1]
        self.blocks[index] = replace(self.blocks[index], title=title)

    def label(self, name: str) -> str:
        """
        Return the label of the next process.

        The number counts all processes of the launch, as in ROS 2.
        """
        self._count += 1
        return f'{name}-{self._count}'

    def use_package(self, name: str, position: Position) -> None:
        """Note that the launch needs a package."""
        self.packages_used.setdefault(name, position)

    def use_configuration(self, name: str) -> None:
        """Note that a launch configuration is read."""
        self.read.add(name)
        if not self.origins:
            self.origins = self.scope.origins.get(name, ())

    def warn(
        self,
        message: str,
        position: Position | None,
        *,
        hint: str | None = None,
        length: int = 1,
    ) -> None:
        """Note a warning; see :class:`Diagnostic`."""
        self.report(
            LaunchError(Diagnostic('warning', message, position, hint, length))
        )

    def report(self, problem: LaunchError) -> None:
        """Note a problem, unless it is known."""
        for position in reversed(self._includes):
            problem = problem.included_from(position)
        for diagnostic in problem.diagnostics:
            # a file that is included twice has its mistakes but once
            where = (diagnostic.message, diagnostic.position)
            if where not in self._reported:
                self._reported.add(where)
                self.diagnostics.append(diagnostic)

    def text(self, item: Item, name: str, default: str = '') -> str:
        """Return an attribute's text, or the default when it has none."""
        text = item.texts.get(name)
        return default if text is None else text.evaluate(self)

    def optional_text(self, item: Item, name: str) -> str | None:
        """Return an attribute's text, or None when it has none."""
        text = item.texts.get(name)
        return None if text is None else text.evaluate(self)

    def pairs(self, item: Item, name: str) -> dict[str, str]:
        """Return the names and values of a list, in order."""
        return {
            self.text(pair, 'name'): self.text(pair, 'value')
            for pair in item.items.get(name, ())
        }

    def boolean(self, item: Item, name: str, default: bool) -> bool:
        """
        Return an attribute's boolean.

        :raises LaunchError: if it is none
        """
        text = item.texts.get(name)
        if text is None:
            return default
        value = parse_boolean(text.evaluate(self))
        if value is None:
            raise self.wrong(text, name, 'a boolean', 'write true or false')
        return value

    def integer(self, item: Item, name: str, default: int) -> int:
        """
        Return an attribute's whole number.

        :raises LaunchError: if it is none
        """
        text = item.texts.get(name)
        if text is None:
            return default
        return self._number(text, name, 'a whole number', int)

    def seconds(self, item: Item, name: str) -> float | None:
        """
        Return an attribute's time in seconds, None when it has none.

        :raises LaunchError: if it is no number >= 0
        """
        text = item.texts.get(name)
        if text is None:
            return None
        value = self._number(text, name, 'a number of seconds', float)
        if not math.isfinite(value) or value < 0:
            raise self.wrong(
                text, name, 'a number of seconds', 'write a number >= 0'
            )
        return value

    def wrong(
        self, text: Text, name: str, wanted: str, hint: str | None = None
    ) -> LaunchError:
        """Return the error for an attribute with a wrong value."""
        return error(
            f"'{name}' wants {wanted}, not '{text.evaluate(self)}'",
            text.position,
            hint=hint,
            length=text.length,
            origins=self.origins,
        )

    def _number(
        self,
        text: Text,
        name: str,
        wanted: str,
        convert: Callable[[str], _Number],
    ) -> _Number:
        value = text.evaluate(self)
        try:
            return convert(value)
        except ValueError:
            raise self.wrong(text, name, wanted) from None
