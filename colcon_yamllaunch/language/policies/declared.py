# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The launch arguments that a launch file and its includes declare.

They are found without running anything: no `$(command …)` and no `$(eval …)`,
and not by what a condition comes to, since another argument may change that.
"""

from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
from dataclasses import replace
import os

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.actions.handlers import HANDLERS
from colcon_yamllaunch.language.actions.handlers import PASSIVE
from colcon_yamllaunch.language.actions.substitution_makers import MAKERS
from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.declared_argument import (
    DeclaredArgument,
)
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.evaluation.scope import Guard
from colcon_yamllaunch.language.evaluation.values import AlreadyReportedError
from colcon_yamllaunch.language.evaluation.values import unknown
from colcon_yamllaunch.language.evaluation.values import Value
from colcon_yamllaunch.language.evaluation.walk import DEPTH_PROBLEM
from colcon_yamllaunch.language.evaluation.walk import MAXIMUM_INCLUDE_DEPTH
from colcon_yamllaunch.language.evaluation.walk import PYTHON_SUFFIX
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.tree.launch_tree import Entity
from colcon_yamllaunch.language.tree.text import Text
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.plan.position import Span

# the substitutions that only a launch can make: those that run something, and
# those whose value is not followed here
_ONLY_LAUNCHED = frozenset(
    ('command', 'eval', 'anon', 'param', 'for-var', 'index')
)
# stands for any condition: another argument may change what it comes to
_MAYBE = Guard('condition', True, frozenset(('condition',)), None)


@dataclass(frozen=True, slots=True)
class Declarations:
    """
    What is known of the launch arguments without launching.

    :param arguments: The launch arguments, in the order of the files
    :param not_followed: Where includes are that may declare more of them, and
      why these could not be followed
    :param mistakes: What is wrong with single entries of the files that are
      used in any case; they may declare more of them, too
    """

    arguments: tuple[DeclaredArgument, ...]
    not_followed: Mapping[Position, str]
    mistakes: tuple[Diagnostic, ...] = ()


def find_declarations(request: Request) -> Declarations:
    """
    Find the launch arguments of a launch file with everything it includes.

    As in ROS 2 (`LaunchDescription.get_launch_arguments`), the first
    declaration of a name counts, and what stands behind a `reset` does not,
    since the command line does not reach there.

    :param request: The launch file; the launch arguments matter only for the
      paths of includes
    :raises LaunchError: when a launch file that is used in any case cannot be
      read
    """
    walk = _Listing(request)
    walk.launch(request.name, request.path)
    errors = [d for d in walk.diagnostics if d.severity == 'error']
    if errors:
        raise LaunchError(*errors)
    return Declarations(
        tuple(walk.arguments.values()),
        walk.not_followed,
        tuple(walk.mistakes.values()),
    )


class _Listing(Walk):
    """Goes through all that may declare an argument."""

    def __init__(self, request: Request) -> None:
        super().__init__(request, HANDLERS, MAKERS)
        self._conditions = 0
        # why something cannot be told
        self._problem: LaunchError | None = None
        self.arguments: dict[str, DeclaredArgument] = {}
        self.not_followed: dict[Position, str] = {}
        # what is wrong where, as a file may be included twice
        self.mistakes: dict[tuple[str, Position | None], Diagnostic] = {}

    @property
    def _is_conditional(self) -> bool:
        # behind a conditional reset all depends on its condition
        is_given = self.scope.configurations.is_given
        return self._conditions > 0 or is_given is None

    def fail(self, problem: LaunchError, *, is_certain: bool = True) -> None:
        # the launch will say so
        self._problem = self._problem or problem

    def warn(
        self, message: str, at: Span | None, hint: str | None = None
    ) -> None:
        pass

    def visit(self, entity: Entity) -> None:
        # behind a reset the command line does not count
        if self.scope.configurations.is_given is not False:
            super().visit(entity)

    def act(self, entity: Entity) -> None:
        if entity.action.name not in PASSIVE:
            super().act(entity)

    def guard(self, entity: Entity) -> Guard | None:
        texts = entity.item.texts
        return _MAYBE if 'if' in texts or 'unless' in texts else None

    def branch(self, guard: Guard, entity: Entity) -> None:
        outer = self.scope
        self._conditions += 1
        with self.within_scope(outer.inner()):
            self.act(entity)
            outer.merge(self.scope, guard)
        self._conditions -= 1

    def visit_later(self, children: tuple[Entity, ...]) -> None:
        self._conditions += 1
        super().visit_later(children)
        self._conditions -= 1

    def visit_rounds(
        self,
        children: tuple[Entity, ...],
        rounds: Iterable[dict[str, Value]],
        otherwise: dict[str, Value],
    ) -> None:
        # it may be gone through not even once
        outer = self.scope
        self._conditions += 1
        with self.within_scope(outer.inner()):
            self.visit_all(children)
            outer.merge(self.scope, _MAYBE)
        self._conditions -= 1

    def value(self, text: Text) -> Value:
        if any(
            s.name in _ONLY_LAUNCHED for s in text.template.substitutions()
        ):
            return unknown('only launched')
        return super().value(text)

    def declare(
        self, attributes: Attributes, name: str, choices: tuple[str, ...]
    ) -> None:
        if name in self.arguments:
            return
        texts = attributes.item.texts
        self.arguments[name] = DeclaredArgument(
            name,
            attributes.position,
            texts['description'].plain if 'description' in texts else None,
            texts['default'].plain if 'default' in texts else None,
            choices,
            self._is_conditional,
            self._set_at(name),
        )

    def missing_argument(self, attributes: Attributes, name: str) -> None:
        pass

    def configuration(
        self, value: Value, position: Position, text: Text
    ) -> Value:
        return value._replace(origins=(position,))

    def compute(self, expression: str, modules: str) -> str | None:
        return None

    def launch_python(self, name: str, path: str, origin: Span) -> None:
        if not self._note_python(name, path, origin):
            raise error(
                'the launch arguments of a launch file in Python show only '
                'when it runs',
                hint='source a ROS 2 that has launch_ros; where it is, '
                f"'ros2 launch -s {path}' shows them too",
            )

    def _note_python(self, name: str, path: str, origin: Span) -> bool:
        """
        Note what a launch file in Python declares, and return whether it is.

        :raises LaunchError: when the file has mistakes
        """
        # most launch files are not in Python
        from colcon_yamllaunch.language.python_files import python_declarations

        # before the package is built, only the file in its source is there
        file = name if os.path.isfile(name) else path
        said = python_declarations.declared_arguments(self, file, origin)
        for argument in said or ():
            self.arguments.setdefault(
                argument.name,
                replace(
                    argument,
                    is_conditional=self._is_conditional
                    or argument.is_conditional,
                    set_at=self._set_at(argument.name),
                ),
            )
        return said is not None

    def _set_at(self, name: str) -> Position | None:
        """Return where the launch files set an argument themselves."""
        value = self.scope.configurations.get(name)
        if value is None or value.text is None:
            return None
        return next(iter(value.origins), None)

    def do_exposed(self, attributes: Attributes) -> None:
        # it is not run only to see what it may declare
        self.scope.configurations.is_open = True

    def make_exposed(
        self, name: str, texts: Sequence[str], at: Span
    ) -> str | None:
        return None

    def read_in_part(self, problem: LaunchError, origin: Span | None) -> None:
        if origin is not None and self._is_conditional:
            self.read_failed(problem, origin)
            return
        for mistake in self.located(problem).diagnostics:
            if mistake.severity == 'error':
                where = (mistake.message, mistake.position)
                self.mistakes.setdefault(where, mistake)

    def read_failed(self, problem: LaunchError, origin: Span | None) -> None:
        if origin is None or not self._is_conditional:
            self.report(problem)
            return
        first = problem.diagnostics[0]
        place = '' if first.position is None else f'{first.position}: '
        self._note(f'{place}{first.message}', origin.position)

    def locate(self, attributes: Attributes) -> tuple[str, str] | None:
        self._problem = None
        located = super().locate(attributes)
        if located is None:
            reason = self._problem or 'its path shows only when it is launched'
            self._note(str(reason), attributes.item.texts['file'].position)
        return located

    def follow(
        self, attributes: Attributes, located: tuple[str, str] | None
    ) -> None:
        file = attributes.item.texts['file']
        if located is None or self.is_open(located[1]):
            # of a file that includes itself, all arguments are known already
            return
        if located[1].endswith(PYTHON_SUFFIX):
            self._follow_python(*located, file)
        elif self.depth >= MAXIMUM_INCLUDE_DEPTH:
            self._note(DEPTH_PROBLEM, file.position)
        else:
            self.visit_file(*located, file)

    def _follow_python(self, name: str, path: str, origin: Span) -> None:
        is_known = False
        try:
            is_known = self._note_python(name, path, origin)
        except LaunchError as e:
            self.read_failed(e, origin)
        except AlreadyReportedError:
            pass
        if not is_known:
            self._note('it is written in Python', origin.position)

    def _note(self, message: str, position: Position) -> None:
        self.not_followed.setdefault(position, message)
