# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
From a launch file and its arguments to a plan.

This is the policy of a launch: all is known, an error ends its action, and an
action whose condition does not hold is passed over.
"""

from collections.abc import Mapping
from dataclasses import field
from dataclasses import replace
import importlib
import math
import os
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.actions.handlers import HANDLERS
from colcon_yamllaunch.language.actions.substitution_makers import MAKERS
from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.findings import Checked
from colcon_yamllaunch.language.evaluation.findings import ProgramUse
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.evaluation.scope import Guard
from colcon_yamllaunch.language.evaluation.values import AlreadyReportedError
from colcon_yamllaunch.language.evaluation.values import expression_error
from colcon_yamllaunch.language.evaluation.values import Value
from colcon_yamllaunch.language.evaluation.walk import EndlessError
from colcon_yamllaunch.language.evaluation.walk import MAXIMUM_INCLUDE_DEPTH
from colcon_yamllaunch.language.evaluation.walk import PYTHON_SUFFIX
from colcon_yamllaunch.language.evaluation.walk import too_deep
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.launch_tree import Entity
from colcon_yamllaunch.language.syntax.text import Text
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.plan.position import Span

if TYPE_CHECKING:
    from colcon_yamllaunch.language.evaluation.launch_worker import Growing


@dataclass(frozen=True, slots=True)
class Evaluation(Checked):
    """
    What a launch file comes to.

    :param plan: What to run; not complete when there are errors
    :param inputs: The files that were read, or looked for in vain, besides
      launch files
    :param has_run_programs: Whether programs were run, or a launch file in
      Python, which may have read others
    :param growing: What makes more of it while it runs, if anything does
    :param programs: Where launch files in YAML and XML name the programs, by
      what ROS 2 calls the processes
    """

    plan: Plan
    inputs: tuple[str, ...] = ()
    has_run_programs: bool = False
    growing: 'Growing | None' = None
    programs: Mapping[str, ProgramUse] = field(default_factory=dict)


def evaluate(request: Request, *, runs: bool = True) -> Evaluation:
    """
    Evaluate a launch file with everything that it includes.

    Nothing is started but what `$(command …)` says.

    :param request: The launch file, and what to evaluate it with
    :param runs: Whether `$(command …)` is run, and what `$(eval …)` says
      whatever it is; else the plan has what is written instead
    """
    walk = _Launch(request)
    walk.runs = runs
    walk.launch(request.name, request.path)
    if walk.dialogue is not None:
        walk.finish_worker(request)
    if request.arguments and not walk.has_opaque:
        walk.warn_of_unknown_arguments(request.arguments)
        walk.warn_of_overwritten_arguments()
    walk.warn_of_shell_variables()
    if walk.targets or walk.section_uses:
        walk.warn_of_nodes()
    plan = replace(walk.draft.plan(), left_open=tuple(walk.left_open))
    growing = None
    if walk.dialogue is not None and all(
        d.severity != 'error' for d in walk.diagnostics
    ):
        # most launch files are not in Python
        from colcon_yamllaunch.language.python_files import growing_launch

        plan, growing = growing_launch.growing_launch(walk, plan)
    return Evaluation(
        tuple(walk.diagnostics),
        tuple(walk.sources),
        walk.packages_used,
        tuple(walk.executables),
        tuple(walk.plugins),
        plan,
        tuple(walk.inputs),
        walk.has_run_programs or walk.has_python,
        growing,
        walk.programs,
    )


class _Launch(Walk):
    """Goes through what a launch does."""

    is_launch = True
    #: Whether there are launch files in Python.
    has_python = False
    #: Whether there are some of which nothing is known.
    has_opaque = False

    def __init__(self, request: Request) -> None:
        super().__init__(request, HANDLERS, MAKERS)
        self._overwritten: dict[str, LaunchError] = {}
        self._computed: dict[str, str] = {}

    def overwritten(self, name: str, by: Text) -> None:
        if name not in self._overwritten:
            given = f'{name}:={self.given[name].text}'
            self._overwritten[name] = self.located(
                error(
                    f"the launch argument '{given}' of the command line has "
                    'no effect: it is always set here',
                    by,
                ).as_warning()
            )

    def warn_of_overwritten_arguments(self) -> None:
        for name, problem in self._overwritten.items():
            if name not in self.given_read:
                # the includes around are not those that led there
                self.diagnostics.extend(problem.diagnostics)

    def visit(self, entity: Entity) -> None:
        try:
            guard = self.guard(entity)
            if guard is None or guard.taken:
                self.act(entity)
        except LaunchError as e:
            self.report(e)
        except AlreadyReportedError:
            pass

    def fail(self, problem: LaunchError, *, is_certain: bool = True) -> None:
        raise problem

    def branch(self, guard: Guard, entity: Entity) -> None:
        if guard.taken:
            self.act(entity)

    def follow(
        self, attributes: Attributes, located: tuple[str, str] | None
    ) -> None:
        file = attributes.item.texts['file']
        if self.depth >= MAXIMUM_INCLUDE_DEPTH:
            self.report(too_deep(file.position))
            raise EndlessError
        if located is None:
            return
        name, path = located
        if path.endswith(PYTHON_SUFFIX):
            self.launch_python(name, path, file)
        else:
            self.visit_file(name, path, file)

    def launch_python(self, name: str, path: str, origin: Span) -> None:
        # before the package is built, only the file in its source is there
        file = name if os.path.isfile(name) else path
        self.has_python = True
        self.inputs[file] = None
        # most launch files are not in Python
        from colcon_yamllaunch.language.python_files import python_visit

        with self.draft.within_block('file', path, origin.position):
            if not python_visit.launch_in_python(self, file, origin):
                self.has_opaque = True

    def do_exposed(self, attributes: Attributes) -> None:
        # most launch files have none
        from colcon_yamllaunch.language.python_files import exposed_actions

        exposed_actions.do(self, attributes)

    def make_exposed(
        self, name: str, texts: tuple[str, ...], at: Span
    ) -> str | None:
        from colcon_yamllaunch.language.python_files import exposed_actions

        return exposed_actions.make(self, name, texts, at)

    def finish_worker(self, request: Request) -> None:
        """Let the host do what is to be done when all is read."""
        from colcon_yamllaunch.language.python_files import python_visit

        try:
            python_visit.finish(self, request.path)
        except LaunchError as e:
            self.report(e)
        except (AlreadyReportedError, EndlessError):
            pass

    def read_failed(self, problem: LaunchError, origin: Span | None) -> None:
        raise problem

    def missing_argument(self, attributes: Attributes, name: str) -> None:
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
        return value._replace(
            origins=(position, *value.origins), place=self.place_of(text)
        )

    def compute(self, expression: str, modules: str) -> str | None:
        if not self.runs:
            return _harmless(expression, modules)
        # most launch files compute nothing
        from colcon_yamllaunch.language.policies.expression import (
            ExpressionError,
        )
        from colcon_yamllaunch.language.policies.expression import is_costly

        variables: dict[str, object] = {}
        try:
            for name in modules.split(','):
                name = name.strip()
                if not name:
                    continue
                module = importlib.import_module(name)
                if name == 'math':
                    variables.update(vars(math))
                variables[module.__name__] = module
                variables.setdefault(name.partition('.')[0], module)
            if is_costly(expression):
                return self._compute_apart(expression, variables)
            return str(eval(expression, variables))
        except ExpressionError as e:
            raise expression_error(expression, str(e)) from e
        except (Exception, SystemExit) as e:
            # the expression is the user's own program, and may raise anything
            reason = f'{type(e).__name__}: {e}'
            raise expression_error(expression, reason) from e

    def _compute_apart(
        self, expression: str, variables: Mapping[str, object]
    ) -> str:
        from colcon_yamllaunch.language.policies.expression import (
            compute_in_child,
        )

        result = self._computed.get(expression)
        if result is None:
            result = compute_in_child(expression, variables)
            self._computed[expression] = result
        return result

    def warn_of_shell_variables(self) -> None:
        """Warn of launch arguments that are written as in a shell."""
        if any('${' in source.text for source in self.sources):
            # most launch files have none
            from colcon_yamllaunch.language.policies.cross_checks import (
                shell_variables,
            )

            for problem in shell_variables(self.files.values()):
                self.report(problem)

    def warn_of_nodes(self) -> None:
        """Warn of names that no node of the launch has."""
        # only launches with components need it
        from colcon_yamllaunch.language.policies import cross_checks

        if all(d.severity != 'error' for d in self.diagnostics):
            # an action with an error is none of the launch's nodes
            cross_checks.warn_of_missing_containers(self)
        cross_checks.warn_of_useless_sections(self, in_full=False)

    def warn_of_unknown_arguments(self, given: Mapping[str, str]) -> None:
        """Warn of arguments that no launch file declares or reads."""
        # most launches are given none
        from colcon_yamllaunch.language.policies import cross_checks

        known = {*self.read, *cross_checks.PROCESS_ARGUMENTS}
        files = [file for file in self.files.values() if file is not None]
        declared = cross_checks.declared_arguments(files)
        if self.dialogue is not None:
            declared |= self.dialogue.declared.keys()
            declared |= cross_checks.written_in_python(self.python_files)
            in_python = cross_checks.in_python(self.python_files, given)
            known |= in_python
            # they may have been read before they were set
            self.given_read |= in_python
        for name in given:
            if name not in declared | known:
                hint = cross_checks.undeclared_hint(name, declared)
                self.report(cross_checks.undeclared_argument(name, hint))


def _harmless(expression: str, modules: str) -> str | None:
    """
    Compute an expression if it can do no harm.

    :raises SubstitutionError: when it fails
    """
    # a launch that runs computes all, and does without this
    from colcon_yamllaunch.language.policies.expression import compute
    from colcon_yamllaunch.language.policies.expression import ExpressionError

    if modules != 'math':
        return None
    try:
        return compute(expression)
    except ExpressionError as e:
        raise expression_error(expression, str(e)) from e
