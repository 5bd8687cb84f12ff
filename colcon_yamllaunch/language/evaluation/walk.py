# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The walk through the actions of launch files, in order.

Running a launch file and checking it are its two policies: :class:`Walk` does
what a launch does, and its subclass in `policies/check.py` what a check does.
Values are known or not, see
:mod:`colcon_yamllaunch.language.evaluation.scope`.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
import os
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.suggestions import (
    did_you_mean,
    no_package,
    one_of,
)
from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.budget import (
    Budget,
    EndlessError,
    MAXIMUM_INCLUDE_DEPTH,
    too_deep,
)
from colcon_yamllaunch.language.evaluation.call import Call
from colcon_yamllaunch.language.evaluation.findings import Findings
from colcon_yamllaunch.language.evaluation.launch_files import LaunchFiles
from colcon_yamllaunch.language.evaluation.plan_draft import PlanDraft
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.evaluation.scope import (
    AlreadyReportedError,
    Guard,
    known,
    LeftOpen,
    Scope,
    unknown,
    UNSET,
    Value,
    ValuePlace,
)
from colcon_yamllaunch.language.syntax.diagnostics import error, LaunchError
from colcon_yamllaunch.language.syntax.launch_tree import (
    Entity,
    LaunchFile,
    UNREADABLE,
)
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.language.syntax.text import Template, Text
from colcon_yamllaunch.plan.plan import EvaluatedCondition
from colcon_yamllaunch.plan.position import Position, Span

if TYPE_CHECKING:
    from colcon_yamllaunch.language.actions.parameter_files import (
        ParameterSections,
    )
    from colcon_yamllaunch.language.python_files.worker_dialogue import (
        WorkerDialogue,
    )

#: How to know what a plan leaves open.
RUN_COMMANDS = 'if you trust the launch file, add --run-commands'
#: The suffix of launch files in Python.
PYTHON_SUFFIX = '.py'

#: What does an action.
Handler = Callable[['Walk', Attributes], object]


class Walk(Findings):
    """
    Goes through the actions in order, and keeps what is known on the way.

    :param request: What is to be launched
    """

    #: Whether everything is known, as in a launch: then an error ends its
    #: action, and a value that is not known is one that was reported.
    is_launch = True
    #: Whether the environment is that of the launch.
    has_environment = True
    #: Whether `$(command …)` and `$(eval …)` are executed. If not, a launch
    #: leaves open those that could do harm.
    runs = False
    #: Whether a program that this machine lacks is an error.
    checks_programs = False

    def __init__(self, request: Request) -> None:
        # they import this module
        from colcon_yamllaunch.language.actions.handlers import HANDLERS
        from colcon_yamllaunch.language.actions.substitution_makers import (
            MAKERS,
        )

        super().__init__()
        self._handlers = HANDLERS
        self._makers = MAKERS
        self.files = LaunchFiles(request)
        self.budget = Budget(self.report, adds_up=self.is_launch)
        self.packages = request.packages
        self.exposed = request.exposed
        self.environment = dict(request.environment)
        self.cwd = request.cwd
        self.log_folder: str | None = request.log_folder
        self.scope = Scope()
        #: The launch arguments that were given.
        self.given = {n: known(v) for n, v in request.arguments.items()}
        for name, value in self.given.items():
            self.scope.configurations.set(name, value)
        #: Those of them that were read.
        self.given_read: set[str] = set()
        #: The first error for each of them that a launch file sets anew.
        self.overwritten: dict[str, LaunchError] = {}
        self.draft = PlanDraft()
        #: The launch configurations that are read.
        self.read: set[str] = set()
        #: Where the files with parameters of scopes are named.
        self.file_places: dict[str, ValuePlace] = {}
        #: The files with parameters that were read, by their paths.
        self.parameter_sections: dict[str, ParameterSections] = {}
        #: The substitutions that were left open, as they are written.
        self.left_open: list[str] = []
        #: The results of expressions that took a process of their own.
        self.computed: dict[str, str] = {}
        #: What was asked of the worker of launch files in Python, if anything.
        self.dialogue: WorkerDialogue | None = None
        #: Returns the worker; None where there is none.
        self.open_worker = request.open_worker
        #: Whether the worker has ended too early.
        self.has_lost_worker = False
        #: Whether `ros2 launch` runs one of them, so that its arguments are
        #: not known.
        self.has_opaque = False
        self._open: list[Source] = []

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
        """Return the message and the hint for a package that is missing."""
        return no_package(name, self.packages.names(), self.environment)

    def no_launch_file(
        self, written: str, path: str
    ) -> tuple[str, str | None]:
        """
        Return the message and the hint for a launch file that is missing.

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
        """Return the message for a program that is missing."""
        where = '' if '/' in name else ' on the PATH'
        return f"there is no executable '{name}'{where}"

    def fail(self, problem: LaunchError, *, is_certain: bool = True) -> None:
        """
        Record an error.

        :param is_certain: Whether it is one, as far as it can be told before
          the launch
        :raises LaunchError: when the launch cannot go on with it
        """
        del is_certain  # a launch knows all
        raise problem

    def branch(self, guard: Guard, entity: Entity) -> None:
        """Do an action that has a condition, or not."""
        if guard.taken:
            self.act(entity)

    def follow(
        self, attributes: Attributes, located: tuple[str, str] | None
    ) -> None:
        """
        Go through an included launch file.

        :param attributes: Those of the include
        :param located: The path that the file goes by and the one to read,
          None when there is none or it is not known
        """
        if located is not None:
            self.visit_included(*located, attributes.item.texts['file'])

    def read_failed(self, problem: LaunchError, _origin: Span | None) -> None:
        """
        Record a launch file that cannot be read.

        :param _origin: Where it is included, None for the outermost
        """
        raise problem

    def read_in_part(self, problem: LaunchError, origin: Span | None) -> None:
        """
        Record a launch file with entries that cannot be read.

        :param origin: Where it is included, None for the outermost
        """
        self.read_failed(problem, origin)

    def launch_python(self, name: str, path: str, origin: Span) -> None:
        """
        Launch a file in Python.

        :param name: The path that it goes by
        :param path: The file to read
        :param origin: Where it is included, else its start
        """
        # most launch files are not in Python
        from colcon_yamllaunch.language.python_files import python_visit

        # before the package is built, only the file in its source is there
        file = name if os.path.isfile(name) else path
        self.inputs[file] = None
        # it may read others
        self.has_run_programs = True
        with self.draft.within_block('file', path, origin.position):
            if not python_visit.launch_in_python(self, file, origin):
                self.has_opaque = True

    def do_exposed(self, attributes: Attributes) -> None:
        """Do an action of another package, which only that can do."""
        # most launch files have none
        from colcon_yamllaunch.language.python_files import exposed_actions

        exposed_actions.do(self, attributes)

    def make_exposed(
        self, name: str, texts: tuple[str, ...], at: Span
    ) -> str | None:
        """
        Make a substitution of another package, None when it is not known.

        :param texts: Its arguments
        :param at: Where it is written
        :raises LaunchError: when the launch cannot go on without it
        """
        from colcon_yamllaunch.language.python_files import exposed_actions

        return exposed_actions.make(self, name, texts, at)

    def declare(
        self, attributes: Attributes, name: str, choices: tuple[str, ...]
    ) -> None:
        """Record a launch argument that is declared."""

    def overwrite(self, name: str, by: Text) -> None:
        """Record a given launch argument that the file sets itself."""
        if name not in self.overwritten:
            given = f'{name}:={self.given[name].text}'
            self.overwritten[name] = self.located(
                error(
                    f"the launch argument '{given}' of the command line has "
                    'no effect: it is always set here',
                    by,
                ).as_warning()
            )

    def missing_argument(self, attributes: Attributes, name: str) -> None:
        """Record a launch argument that was not given."""
        given = f'{name}:=…'
        if self.depth > 1:
            given = f"arg: [{{name: {name}, value: …}}] in the 'include'"
        attributes.fail_as_whole(
            f"launch argument '{name}' is required, and was not given",
            f'give it: {given}',
        )

    def configuration(
        self, value: Value, position: Position, text: Text
    ) -> Value:
        """
        Return a value as that of a launch configuration.

        :param position: Where it is set
        :param text: What it is made of
        """
        return value._replace(
            origins=(position, *value.origins), place=self.place_of(text)
        )

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
        """Return whether an unknown launch configuration may exist."""
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
        """Return whether the plan contains a value as written."""
        return self.is_launch and bool(value.sources)

    def enter(self, path: str, file: LaunchFile) -> None:
        """Record a launch file that is evaluated."""

    def found_beside(self, file: Text, written: str) -> None:
        """Record an include that ROS 2 would not find."""

    def note_text(self, template: Template | None) -> None:
        """
        Record a text that does not come from the launch file.

        :param template: The text, or None when it is not known
        """

    def is_program(self, path: str) -> bool:
        """Return whether the program exists or a build may install it."""
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

    def name_place(self, call: Call, path: str) -> None:
        """Record a path that a launch file takes for its own."""

    def visit_later(self, children: tuple[Entity, ...]) -> None:
        """Do actions that are done some time afterwards."""
        with self.within_scope(self.scope.inner()):
            self.visit_all(children)

    def visit_rounds(
        self,
        children: tuple[Entity, ...],
        rounds: Iterable[dict[str, Value]],
        _otherwise: dict[str, Value],
    ) -> None:
        """
        Do actions once for each of some variables of a loop.

        :param rounds: The variables of each round, as far as they are known
        :param _otherwise: The variables of any round
        """
        scope = self.scope
        outer = scope.variables
        try:
            for variables in rounds:
                scope.variables = {**outer, **variables}
                self.visit_all(children)
        finally:
            scope.variables = outer

    def launch(self, name: str, path: str) -> None:
        """
        Go through a launch file with everything that it includes.

        :param name: The path that it goes by
        :param path: The file to read
        """
        try:
            if path.endswith(PYTHON_SUFFIX):
                self.launch_python(name, path, Position(path, 1, 1))
            else:
                self.visit_file(name, path, None)
        except LaunchError as e:
            self.report(e)
        except (AlreadyReportedError, EndlessError):
            pass
        except RecursionError:
            self.report(error('the launch file is nested too deep'))

    @property
    def source(self) -> Source:
        """The launch file that is gone through."""
        return self._open[-1]

    @property
    def depth(self) -> int:
        """How many launch files are open inside of one another."""
        return len(self._open)

    def is_open(self, path: str) -> bool:
        """Return whether a launch file is being evaluated."""
        return any(source.path == path for source in self._open)

    @contextmanager
    def within(self, source: Source, origin: Span | None) -> Iterator[None]:
        """Go through another file for the time of the context."""
        self._open.append(source)
        if origin is not None:
            self._includes.append(origin.position)
        try:
            yield
        finally:
            self._open.pop()
            if origin is not None:
                self._includes.pop()

    @contextmanager
    def within_text(self, origin: Text) -> Iterator[None]:
        """Read a file that a text names for the time of the context."""
        self._includes.append(origin.position)
        problem = None
        try:
            yield
        except LaunchError as e:
            problem = e.included_from(origin.position)
        finally:
            self._includes.pop()
        if problem is not None:
            self.fail(problem)

    def visit_file(self, name: str, path: str, origin: Span | None) -> bool:
        """
        Do the actions of a launch file; return whether it could be read.

        :param origin: Where it is included, None for the outermost
        """
        file = self.read_file(name, path, origin)
        if file is None:
            return False
        start = file.source.position(0, 0)
        position = start if origin is None else origin.position
        with (
            self.within(file.source, origin),
            self.draft.within_block('file', path, position),
        ):
            self.enter(path, file)
            if file.deprecated is not None:
                self.warn(
                    f'this launch file is deprecated: {file.deprecated}', start
                )
            if file.problems and not file.has_mistakes:
                self.report(LaunchError(*file.problems))
            self.visit_all(file.entities)
        return True

    def visit_included(self, name: str, path: str, origin: Span) -> None:
        """
        Go through a launch file that another one includes.

        :param name: The path that it goes by
        :param path: The file to read
        :raises EndlessError: when they include one another without end
        """
        if self.depth >= MAXIMUM_INCLUDE_DEPTH:
            self.report(too_deep(origin.position))
            raise EndlessError
        if path.endswith(PYTHON_SUFFIX):
            self.launch_python(name, path, origin)
        else:
            self.visit_file(name, path, origin)

    def read_file(
        self, name: str, path: str, origin: Span | None
    ) -> LaunchFile | None:
        """
        Read a launch file, and report its mistakes.

        Return None when nothing in it can be read.
        """
        file = self.files.read(name, path)
        problem = self.files.problems.get(path)
        if problem is not None:
            if origin is not None:
                problem = problem.included_from(origin.position)
            if file is None:
                self.read_failed(problem, origin)
            else:
                self.read_in_part(problem, origin)
        return file

    def visit_all(self, entities: tuple[Entity, ...]) -> None:
        """Do some actions in order."""
        for entity in entities:
            self.budget.count_action(entity.item.position)
            if entity.action is UNREADABLE:
                # it may set anything
                self.scope.configurations.is_open = True
                self.visit_all(entity.children)
            else:
                self.visit(entity)

    def visit(self, entity: Entity) -> None:
        """Do an action if its condition holds."""
        try:
            guard = self.guard(entity)
            if guard is None:
                self.act(entity)
            else:
                self.branch(guard, entity)
        except LaunchError as e:
            self.report(e)
        except AlreadyReportedError:
            pass

    def act(self, entity: Entity) -> None:
        """Do an action whatever its condition is."""
        self.do(Attributes.of_action(self, entity))

    def do(self, attributes: Attributes) -> None:
        """Do what an action says."""
        if attributes.item.raw is None:
            self._handlers[attributes.name](self, attributes)
        else:
            self.do_exposed(attributes)

    def guard(self, entity: Entity) -> Guard | None:
        """Evaluate the condition of an action, None when it has none."""
        texts = entity.item.texts
        name = 'if' if 'if' in texts else 'unless'
        text = texts.get(name)
        if text is None:
            return None
        value, wanted = self.value(text), name == 'if'
        word = (value.text or '').strip().lower()
        if text.literal is not None and text.kind == 'bool':
            word = str(text.value).lower()
        if word in ('true', '1', 'false', '0'):
            is_taken = (word in ('true', '1')) is wanted
            self.draft.conditions.append(
                EvaluatedCondition(
                    f'{name}: {text.plain}', is_taken, text.position
                )
            )
            return Guard(value.key, wanted, value.sources, is_taken)
        if self.is_left_open(value):
            self.fail(
                error(
                    f"what the condition '{name}' comes to is left open in "
                    'this plan',
                    text,
                    hint=RUN_COMMANDS,
                )
            )
        elif value.text is not None:
            self.fail(
                error(
                    f"the condition '{name}' is '{value.text.strip()}'",
                    text,
                    hint='it must be true, 1, false or 0',
                    origins=value.origins,
                )
            )
        sources = value.sources or frozenset((value.key,))
        return Guard(value.key, wanted, sources, None)

    def locate(self, attributes: Attributes) -> tuple[str, str] | None:
        """Return the path that an include goes by and the one to read."""
        file, packages = attributes.item.texts['file'], self.packages
        written = attributes.text('file')
        if written is None:
            return None
        candidate = self.absolute(written)
        located = packages.locate(candidate)
        if located is None and not os.path.isabs(written):
            folder = os.path.dirname(self.source.name)
            candidate = os.path.normpath(os.path.join(folder, written))
            located = packages.locate(candidate)
            if located is not None:
                self.found_beside(file, written)
        if located is None:
            self.inputs[candidate] = None
            attributes.fail('file', *self.no_launch_file(written, candidate))
        return located

    def value(self, text: Text) -> Value:
        """
        Put the substitutions into a text, as far as they are known.

        :raises LaunchError: when the launch cannot go on without one
        """
        literal = text.literal
        if literal is not None:
            return Value(literal, literal)
        return self.template(text.template, text.position_at)

    def template(
        self, template: Template, position_at: Callable[[int], Position]
    ) -> Value:
        """Put the substitutions into a template."""
        makers, parts = self._makers, template.parts
        if len(parts) == 1:
            part = parts[0]
            if isinstance(part, str):
                return Value(part, part)
            return makers[part.name](Call(self, part, position_at))
        pieces = [
            part
            if isinstance(part, str)
            else makers[part.name](Call(self, part, position_at))
            for part in parts
        ]
        return self.budget.join(pieces, lambda: position_at(0))
