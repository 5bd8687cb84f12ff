# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What was found on the way: problems, packages, programs, nodes."""

from collections.abc import Iterable, Mapping
import os
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.evaluation.scope import Guard, ValuePlace
from colcon_yamllaunch.language.syntax.diagnostics import (
    Diagnostic,
    error,
    LaunchError,
)
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.plan.position import Position, Span

if TYPE_CHECKING:
    from colcon_yamllaunch.language.actions.parameter_files import Section

#: How many nodes of one name are compared with another one.
MAXIMUM_NAMESAKES = 8


@dataclass(frozen=True, slots=True)
class DeclaredArgument:
    """
    A launch argument.

    :param name: Its name
    :param position: Where it is declared first
    :param description: What it is for, if the launch file says so
    :param default: The default as it is written, None when it is required
    :param choices: The values that it may have; empty when any
    :param is_conditional: Whether it is used only under some condition
    :param set_at: Where a launch file itself sets the value, so that one from
      the command line does not count; None when none does
    """

    name: str
    position: Position
    description: str | None = None
    default: str | None = None
    choices: tuple[str, ...] = ()
    is_conditional: bool = False
    set_at: Position | None = None


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


@dataclass(frozen=True, slots=True)
class ProgramUse:
    """
    The first word of a process's command line in a launch file.

    :param hint: The fix if there is no such program; None if it is to be
      installed
    """

    place: ValuePlace
    hint: str | None


@dataclass(frozen=True, slots=True)
class PluginUse:
    """
    A component of a package that the launch loads.

    :param package: The package
    :param plugin: The class of the component, None when it is not known
    :param position: Where the launch file names it
    :param package_position: Where the launch file names the package
    """

    package: str
    plugin: str | None
    position: Position
    package_position: Position


@dataclass(frozen=True, slots=True)
class SectionUse:
    """
    A file with parameters that a node is given.

    :param path: The file
    :param sections: Its sections
    :param node: The full name of the node, None when that is not known
    :param place: Where the launch file names the file
    :param is_own: Whether it is for this node alone, and not for all of a
      scope
    """

    path: str
    sections: 'tuple[Section, ...]'
    node: str | None
    place: ValuePlace
    is_own: bool


@dataclass(frozen=True, slots=True)
class NamedNode:
    """A node that has a name, and when there is one."""

    position: Position
    guards: tuple[Guard, ...]

    def may_meet(self, other: 'NamedNode') -> bool:
        """Return whether one launch may contain both nodes."""
        return not any(
            mine.excludes(its) for mine in self.guards for its in other.guards
        )


@dataclass(frozen=True, slots=True)
class CheckResult:
    """
    What was found in launch files, in the end.

    :param diagnostics: Errors and warnings, in the order found
    :param files: The launch files that were read, the given one first
    :param packages: The packages that they name, and where first
    :param executables: The packages' programs that they name
    :param plugins: The packages' components that they name
    """

    diagnostics: tuple[Diagnostic, ...]
    files: tuple[Source, ...]
    packages: Mapping[str, Position]
    executables: tuple[ExecutableUse, ...]
    plugins: tuple[PluginUse, ...]

    @property
    def errors(self) -> tuple[Diagnostic, ...]:
        """The errors among the diagnostics."""
        return tuple(d for d in self.diagnostics if d.severity == 'error')


def together(checks: Iterable[CheckResult]) -> CheckResult:
    """Return what was found in several launch files as one, each but once."""
    diagnostics: dict[tuple[str, Position | None], Diagnostic] = {}
    files: dict[str, Source] = {}
    packages: dict[str, Position] = {}
    executables: dict[ExecutableUse, None] = {}
    plugins: dict[PluginUse, None] = {}
    for checked in checks:
        for diagnostic in checked.diagnostics:
            where = (diagnostic.message, diagnostic.position)
            diagnostics.setdefault(where, diagnostic)
        for file in checked.files:
            files.setdefault(file.path, file)
        for name, position in checked.packages.items():
            packages.setdefault(name, position)
        executables.update(dict.fromkeys(checked.executables))
        plugins.update(dict.fromkeys(checked.plugins))
    return CheckResult(
        tuple(diagnostics.values()),
        tuple(files.values()),
        packages,
        tuple(executables),
        tuple(plugins),
    )


class Findings:
    """What was found so far, and the includes that led there."""

    def __init__(self) -> None:
        self.diagnostics: list[Diagnostic] = []
        self.packages_used: dict[str, Position] = {}
        self.executables: list[ExecutableUse] = []
        self.plugins: list[PluginUse] = []
        #: The programs of the processes of a launch, by what ROS 2 calls
        #: these.
        self.programs: dict[str, ProgramUse] = {}
        #: The containers that components are loaded into, and where a launch
        #: file names them.
        self.targets: list[tuple[str, ValuePlace]] = []
        #: Whether there may be nodes whose names are not known.
        self.may_have_others = False
        self.section_uses: list[SectionUse] = []
        #: The files that were read, or looked for in vain, besides launch
        #: files.
        self.inputs: dict[str, None] = {}
        #: Whether programs were run, which may have read others.
        self.has_run_programs = False
        #: The nodes that have a name, by that.
        self.nodes: dict[str, list[NamedNode]] = {}
        #: The conditions around that only a launch decides.
        self.guards: list[Guard] = []
        #: How many of the conditions around hold in no launch.
        self.never = 0
        self._includes: list[Position] = []
        self._reported: set[tuple[str, Position | None]] = set()

    @property
    def includes(self) -> tuple[Position, ...]:
        """The includes that led to the open file, innermost first."""
        return tuple(reversed(self._includes))

    @property
    def is_on_by_default(self) -> bool:
        """Whether all conditions hold if no launch argument is given."""
        return not self.never and all(guard.taken for guard in self.guards)

    def error_count(self) -> int:
        """Return how many errors there are so far."""
        return sum(d.severity == 'error' for d in self.diagnostics)

    def snapshot(self) -> 'Findings':
        """Return what was found so far, for :meth:`restore`."""
        copy = Findings()
        copy.restore(self)
        return copy

    def restore(self, before: 'Findings') -> None:
        """Forget what was found since a snapshot, but for the packages."""
        self.diagnostics[:] = before.diagnostics
        self._reported = set(before._reported)
        self.executables[:] = before.executables
        self.plugins[:] = before.plugins
        self.targets[:] = before.targets
        self.may_have_others = before.may_have_others
        self.section_uses[:] = before.section_uses
        self.nodes = {name: [*nodes] for name, nodes in before.nodes.items()}

    def warn(
        self, message: str, at: Span | None, hint: str | None = None
    ) -> None:
        """Note a warning; see :func:`error`."""
        self.report(error(message, at, hint=hint).as_warning())

    def fail_at(
        self,
        place: ValuePlace,
        message: str,
        hint: str,
        origins: tuple[Position, ...] = (),
        *,
        is_certain: bool = True,
    ) -> None:
        """Note an error at a place in a launch file that may be closed."""
        problem = error(message, place, hint=hint, origins=origins)
        problem = problem.included_from(*place.includes)
        if not is_certain:
            problem = problem.as_warning()
        self.diagnostics.extend(problem.diagnostics)

    def warn_at(
        self, place: ValuePlace, message: str, hint: str | None
    ) -> None:
        """Note a warning at a place in a launch file that may be closed."""
        problem = error(message, place, hint=hint).as_warning()
        self.report(problem.included_from(*place.includes))

    def place_of(self, at: Span) -> ValuePlace:
        """Return a place in the open launch file, for later."""
        return ValuePlace(at.position, at.length, self.includes)

    def report(self, problem: LaunchError) -> None:
        """Note a problem, unless it is known."""
        for diagnostic in self.located(problem).diagnostics:
            # a file that is included twice has its mistakes but once
            where = (diagnostic.message, diagnostic.position)
            if where not in self._reported:
                self._reported.add(where)
                self.diagnostics.append(diagnostic)

    def located(self, problem: LaunchError) -> LaunchError:
        """Return a problem with the includes that led to it."""
        return problem.included_from(*self.includes)

    def use_package(self, name: str, position: Position) -> None:
        """Note that the launch needs a package."""
        self.packages_used.setdefault(name, position)

    def note_node(self, full_name: str, at: Span) -> None:
        """Record a node; warn of one that has the name of another."""
        if self.never:
            return
        node = NamedNode(at.position, tuple(self.guards))
        others = self.nodes.setdefault(full_name, [])
        for other in others:
            if node.may_meet(other):
                place = f'line {other.position.line} of ' + os.path.basename(
                    other.position.path
                )
                self.warn(
                    f"another node of this launch has the name '{full_name}' "
                    'too',
                    at,
                    'this node is launched more than once'
                    if other.position == node.position
                    else f'the other one is in {place}',
                )
                break
        if len(others) < MAXIMUM_NAMESAKES:
            others.append(node)
