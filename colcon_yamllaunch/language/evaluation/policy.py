# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What differs in what is done with launch files."""

from abc import ABC
from abc import abstractmethod
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Sequence
from contextlib import contextmanager
import os
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.common.suggestions import no_package
from colcon_yamllaunch.common.suggestions import one_of
from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.findings import Findings
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.evaluation.scope import Guard
from colcon_yamllaunch.language.evaluation.scope import Scope
from colcon_yamllaunch.language.evaluation.values import AlreadyReportedError
from colcon_yamllaunch.language.evaluation.values import known
from colcon_yamllaunch.language.evaluation.values import LeftOpen
from colcon_yamllaunch.language.evaluation.values import unknown
from colcon_yamllaunch.language.evaluation.values import UNSET
from colcon_yamllaunch.language.evaluation.values import Value
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.template import Template
from colcon_yamllaunch.language.tree.launch_tree import Entity
from colcon_yamllaunch.language.tree.launch_tree import LaunchFile
from colcon_yamllaunch.language.tree.text import Text
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.plan.position import Span

if TYPE_CHECKING:
    from colcon_yamllaunch.language.evaluation.launch_worker import Dialogue

#: How to know what a plan leaves open.
RUN_COMMANDS = 'if you trust the launch file, add --run-commands'


class Surroundings:
    """
    The packages, the environment, and the scope that changes on the way.

    :param request: What is to be launched
    """

    #: Whether the environment is that of the launch.
    has_environment = True

    def __init__(self, request: Request) -> None:
        self.packages = request.packages
        self.exposed = request.exposed
        self.environment = dict(request.environment)
        self.cwd = request.cwd
        self.log_folder: str | None = request.log_folder
        self.scope = Scope()
        #: The launch arguments that were given.
        self.given = {n: known(v) for n, v in request.arguments.items()}
        #: Those of them that were read.
        self.given_read: set[str] = set()
        for name, value in self.given.items():
            self.scope.configurations.set(name, value)

    @contextmanager
    def within_scope(self, scope: Scope) -> Iterator[None]:
        """Go on in another scope for the time of the context."""
        outer, self.scope = self.scope, scope
        try:
            yield
        finally:
            self.scope = outer

    def variable(self, name: str) -> Value | None:
        """Return an environment variable, None when there is none."""
        value = self.scope.environment.get(name)
        if value is not None and value is not UNSET:
            return value
        if self.has_environment:
            if value is None and name in self.environment:
                return known(self.environment[name])
            if not self.scope.environment.may_have_others():
                return None
        elif value is None and name not in self.environment:
            return None
        source = f'$(env {name})'
        return unknown(source, (source,))

    def search_path(self) -> str | None:
        """Return where programs are looked for, None when not known."""
        if self.has_environment:
            value = self.variable('PATH')
            return os.defpath if value is None else value.text
        if self.scope.environment.get('PATH') is not None:
            return None
        return self.environment.get('PATH', os.defpath)

    def scope_environment(self) -> dict[str, str]:
        """Return the environment with all that launch files changed."""
        environment = dict(self.environment)
        for name, value in self.scope.environment.all().items():
            if value.text is None:
                environment.pop(name, None)
            else:
                environment[name] = value.text
        return environment

    def absolute(self, path: str) -> str:
        """Return the path that a relative one means."""
        return os.path.normpath(os.path.join(self.cwd, path))

    def no_package(self, name: str) -> tuple[str, str | None]:
        """Return what to say of a package that is not there: and the hint."""
        return no_package(name, self.packages.names(), self.environment)

    def no_launch_file(
        self, written: str, path: str
    ) -> tuple[str, str | None]:
        """
        Return what to say of a launch file that is not there: and the hint.

        :param written: What the launch file says
        :param path: The path that this means
        """
        return (
            f"the launch file '{written}' does not exist",
            did_you_mean(
                os.path.basename(written), self.packages.similar(path)
            ),
        )

    def no_program(self, name: str) -> str:
        """Return what to say of a program that is not there."""
        where = '' if '/' in name else ' on the PATH'
        return f"there is no executable '{name}'{where}"


class Policy(Findings, Surroundings, ABC):
    """
    What a walk does where launching, checking and listing differ.

    :param request: What is to be launched
    """

    #: Whether everything is known, as in a launch: then an error ends its
    #: action, and a value that is not known is one that was reported.
    is_launch = False
    #: Whether `$(command …)` and `$(eval …)` do what they say. Else those that
    #: could do harm are left open in a launch.
    runs = False
    #: Whether a program that this machine lacks is an error.
    checks_programs = False

    def __init__(self, request: Request) -> None:
        Findings.__init__(self)
        #: The substitutions that were left open, as they are written.
        self.left_open: list[str] = []
        #: What was asked of the host of launch files in Python, if anything.
        self.dialogue: Dialogue | None = None
        #: Returns the host; None where there is none.
        self.open_worker = request.host
        #: Whether that ended before it should.
        self.has_lost_worker = False
        #: The launch files in Python that were read, in order.
        self.python_files: dict[str, None] = {}
        self._source_paths: dict[str, str] = {}
        Surroundings.__init__(self, request)

    @abstractmethod
    def fail(self, problem: LaunchError, *, is_certain: bool = True) -> None:
        """
        Take note of an error.

        :param is_certain: Whether it is one, as far as it can be told before
          the launch
        :raises LaunchError: when the launch cannot go on with it
        """

    @abstractmethod
    def branch(self, guard: Guard, entity: Entity) -> None:
        """Do an action that has a condition, or not."""

    @abstractmethod
    def follow(
        self, attributes: Attributes, located: tuple[str, str] | None
    ) -> None:
        """
        Go through an included launch file.

        :param attributes: Those of the include
        :param located: The path that the file goes by and the one to read,
          None when there is none or it is not known
        """

    @abstractmethod
    def read_failed(self, problem: LaunchError, origin: Span | None) -> None:
        """
        Take note of a launch file that cannot be read.

        :param origin: Where it is included, None for the outermost
        """

    def read_in_part(self, problem: LaunchError, origin: Span | None) -> None:
        """
        Take note of a launch file of which some entries cannot be read.

        :param origin: Where it is included, None for the outermost
        """
        self.read_failed(problem, origin)

    @abstractmethod
    def launch_python(self, name: str, path: str, origin: Span) -> None:
        """
        Launch a file in Python.

        :param name: The path that it goes by
        :param path: The file to read
        :param origin: Where it is included, else its start
        """

    @abstractmethod
    def do_exposed(self, attributes: Attributes) -> None:
        """Do an action of another package, which only that can do."""

    @abstractmethod
    def make_exposed(
        self, name: str, texts: Sequence[str], at: Span
    ) -> str | None:
        """
        Make a substitution of another package, None when it is not known.

        :param texts: Its arguments
        :param at: Where it is written
        :raises LaunchError: when the launch cannot go on without it
        """

    def declare(
        self, attributes: Attributes, name: str, choices: tuple[str, ...]
    ) -> None:
        """Take note of a launch argument that is declared."""

    def overwritten(self, name: str, by: Text) -> None:
        """Take note of a given launch argument that is set anew."""

    @abstractmethod
    def missing_argument(self, attributes: Attributes, name: str) -> None:
        """Take note of a launch argument that was not given."""

    @abstractmethod
    def configuration(
        self, value: Value, position: Position, text: Text
    ) -> Value:
        """
        Return a value as that of a launch configuration.

        :param position: Where it is set
        :param text: What it is made of
        """

    def fail_choice(
        self, name: str, value: Value, choices: Iterable[str], at: Span
    ) -> None:
        """
        Note that a launch argument has none of its choices, where it is given.

        :param at: Where it is declared
        """
        given = value.text or ''
        message = f"launch argument '{name}' cannot be '{given}'"
        hint = one_of(given, choices)
        if value is self.given.get(name):
            line = f"as '{name}:={given}' of the command line says"
            self.fail(error(f'{message}, {line}', hint=hint))
        elif value.place is None:
            self.fail(error(message, at, hint=hint))
        else:
            self.fail_at(value.place, message, hint, value.origins[1:])

    def may_be_set(self, _name: str) -> bool:
        """Say whether a launch configuration may be there that is not seen."""
        return self.scope.configurations.may_have_others()

    def default(self, value: Value, _source: str) -> Value:
        """Return a value that stands for one that a launch may be given."""
        return value

    def settled(self, value: Value) -> Value:
        """
        Return a value that is read.

        :raises AlreadyReportedError: when a launch has to know it
        """
        if value.text is None and self.is_launch:
            raise AlreadyReportedError
        return value

    def leave_open(self, written: str, position: Position) -> LeftOpen:
        """Return what stands in a plan for a value that is not made."""
        self.warn(
            f'{written} may do anything, and is left open in this plan',
            position,
            RUN_COMMANDS,
        )
        self.left_open.append(written)
        return LeftOpen(written)

    def is_left_open(self, value: Value) -> bool:
        """Say whether a plan has a value, or a part, as it is written."""
        return self.is_launch and bool(value.sources)

    @abstractmethod
    def compute(self, expression: str, modules: str) -> str | None:
        """
        Compute an expression in Python, None when only a launch may do so.

        :raises SubstitutionError: when it fails
        """

    def enter(self, path: str, file: LaunchFile) -> None:
        """Take note of a launch file that is gone through."""

    def found_beside(self, file: Text, written: str) -> None:
        """Take note of an include that ROS 2 would not find."""

    def note_text(self, template: Template | None) -> None:
        """
        Take note of a text that is not the launch file's own.

        :param template: The text, or None when it is not known
        """

    def note_file(self, path: str, file: LaunchFile) -> None:
        """Take note of a launch file that is read for the first time."""

    def source_path(self, path: str) -> str:
        """Return the file in a source that is installed at a path, or it."""
        source = self._source_paths.get(path)
        if source is None:
            located = self.packages.locate(path)
            source = path if located is None else located[1]
            self._source_paths[path] = source
        return source

    def is_program(self, path: str) -> bool:
        """Say whether there is such a program, or a build may bring it."""
        is_file = os.path.isfile(path) and os.access(path, os.X_OK)
        return is_file or self.packages.may_appear(path)

    def parameter_file(self, path: str) -> str | None:
        """Return where to read a file with parameters, None if nowhere."""
        if os.path.isfile(path):
            return path
        # once it is there, the plan is another one
        self.inputs[path] = None
        located = self.packages.locate(path)
        if located is None or not self.packages.may_appear(path):
            return None
        return located[1]
