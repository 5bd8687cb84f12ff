# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The policy of a check, which runs nothing.

Values may be unknown. Every action is visited, whatever its condition comes
to, and every launch file that is included. Listing launch arguments is a use
of it.
"""

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import islice
import os
import re

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.actions.handlers import PASSIVE
from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.budget import (
    MAXIMUM_INCLUDE_DEPTH,
    too_deep,
)
from colcon_yamllaunch.language.evaluation.call import Call
from colcon_yamllaunch.language.evaluation.findings import (
    CheckResult,
    DeclaredArgument,
)
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.evaluation.scope import (
    AlreadyReportedError,
    Guard,
    Value,
    ValuePlace,
)
from colcon_yamllaunch.language.evaluation.walk import PYTHON_SUFFIX, Walk
from colcon_yamllaunch.language.policies.cross_checks import (
    FileUse,
    unknown_argument,
    warn_of_missing_containers,
    warn_of_shell_variables,
    warn_of_useless_arguments,
    warn_of_useless_sections,
)
from colcon_yamllaunch.language.policies.portability import not_portable
from colcon_yamllaunch.language.syntax.diagnostics import (
    Diagnostic,
    error,
    LaunchError,
)
from colcon_yamllaunch.language.syntax.launch_tree import Entity, LaunchFile
from colcon_yamllaunch.language.syntax.text import Template, Text
from colcon_yamllaunch.plan.position import Position, Span

#: How often one launch file is looked at, with other arguments each time.
MAXIMUM_VISITS = 20
#: How many rounds of a loop are looked at one by one.
MAXIMUM_ROUNDS = 50

# where a package's programs are (ament, REP 122): PREFIX/lib/PACKAGE/PROGRAM
_PROGRAM_PATH = re.compile(r'(.+)/lib/([^/]+)/([^/]+)')
# stands for any condition, which other launch arguments may change
_ANY_CONDITION = Guard('condition', True, frozenset(('condition',)), None)


@dataclass(frozen=True, slots=True)
class Declarations:
    """
    The launch arguments that launch files declare.

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


def check(
    request: Request, *, portable: bool, checks_programs: bool = True
) -> CheckResult:
    """
    Check a launch file with everything that it includes.

    Nothing is started, and nothing but harmless expressions is computed.

    :param request: The launch file; its launch arguments are sure to be given
    :param portable: Whether to report what ROS 2's launcher does not accept
    :param checks_programs: Whether all processes run on this machine, so that
      a program that it lacks is an error
    """
    walk = _Check(request, portable=portable)
    walk.checks_programs = checks_programs
    walk.launch(request.name, request.path)
    if None not in walk.files.trees.values():
        warn_of_useless_arguments(walk, walk.uses, request.path)
        warn_of_shell_variables(walk)
    warn_of_missing_containers(walk)
    warn_of_useless_sections(walk, in_full=True)
    return CheckResult(
        tuple(dict.fromkeys(walk.diagnostics)),
        tuple(walk.files.sources),
        walk.packages_used,
        tuple(dict.fromkeys(walk.executables)),
        tuple(dict.fromkeys(walk.plugins)),
    )


@dataclass(frozen=True, slots=True)
class _OpenFile:
    """
    A launch file that is being looked at.

    :param path: The file
    :param origin: Where it is included, None for the outermost
    :param conditions: How many conditions there are around it
    :param use: What it does with launch arguments
    """

    path: str
    origin: Span | None
    conditions: int
    use: FileUse


class _Check(Walk):
    """Goes through all that launches may do."""

    is_launch = False
    has_environment = False
    #: Whether the worker is asked to run actions of other packages.
    runs_exposed = True

    def __init__(self, request: Request, *, portable: bool = False) -> None:
        super().__init__(request)
        self.log_folder = None
        self._portable = portable
        #: What each launch file does with launch arguments, by its path.
        self.uses: dict[str, FileUse] = {}
        self._visits: dict[str, int] = {}
        self._files: list[_OpenFile] = []
        # how many conditions there are around, of any kind
        self._conditions = 0
        # how many timers and loops there are around
        self._timers_and_loops = 0
        # the launch file that was included last in the one that is open
        self._included: str | None = None
        # what is set only where no launch comes
        self._never_set: set[str] = set()

    def fail(self, problem: LaunchError, *, is_certain: bool = True) -> None:
        if not is_certain:
            problem = problem.as_warning()
        self.report(problem)

    def act(self, entity: Entity) -> None:
        attributes = Attributes.of_action(self, entity)
        attributes.check()
        self.do(attributes)

    def branch(self, guard: Guard, entity: Entity) -> None:
        is_sure = not guard.sources
        is_never = is_sure and not guard.taken
        masked: frozenset[str] = frozenset()
        if guard.taken is None and guard is not _ANY_CONDITION:
            # the names whose values the condition may decide on
            use = FileUse()
            for name in ('if', 'unless'):
                if name in entity.item.texts:
                    use.add_text(entity.item.texts[name].template)
            masked = frozenset(use.read)
        inner = self.scope.inner(hides=guard.taken is False, masked=masked)
        self._conditions += 1
        self.never += is_never
        outer_guards = self.guards
        if not is_sure:
            self.guards = [*outer_guards, guard]
        try:
            with self.within_scope(inner):
                self.act(entity)
        finally:
            self.guards = outer_guards
            self.never -= is_never
            self._conditions -= 1
        if is_never:
            self._never_set.update(inner.configurations.own)
        else:
            self.scope.merge(inner, None if is_sure else guard)

    def visit_file(self, name: str, path: str, origin: Span | None) -> bool:
        read = self.read_file(name, path, origin)
        if read is None:
            self.scope.configurations.is_open = True
            return False
        if path not in self.uses:
            self.uses[path] = FileUse.of(read)
        file = _OpenFile(path, origin, self._conditions, self.uses[path])
        self._files.append(file)
        included, self._included = self._included, None
        super().visit_file(name, path, origin)
        self._included = included
        self._files.pop()
        return True

    def enter(self, path: str, file: LaunchFile) -> None:
        self._visits[path] = self._visits.get(path, 0) + 1
        if self._portable and self._visits[path] == 1:
            for problem in not_portable(file):
                self.report(problem)

    def read_failed(self, problem: LaunchError, origin: Span | None) -> None:
        self.report(problem)

    def launch_python(self, name: str, path: str, origin: Span) -> None:
        # what it declares and reads is not known
        self.files.trees[path] = None
        self._visits[path] = self._visits.get(path, 0) + 1
        reason = self._visit_python(name, path, origin)
        # with other arguments it may set anything
        self.scope.configurations.is_open = True
        if reason is not None:
            hint = None if reason else 'source a ROS 2 that has launch_ros'
            self.warn(
                f'a launch file in Python cannot be checked{reason}',
                origin,
                hint,
            )
            self.may_have_others = True

    def _visit_python(self, name: str, path: str, origin: Span) -> str | None:
        """Return why a launch file in Python could not be visited, if so."""
        # most launch files are not in Python
        from colcon_yamllaunch.language.python_files import python_visit
        from colcon_yamllaunch.language.python_files.python_visit import (
            MissingArgumentError,
        )

        # before the package is built, only the file in its source is there
        file = name if os.path.isfile(name) else path
        is_certain = self.is_on_by_default
        found = self.snapshot()
        try:
            python_visit.visit_in_python(self, 'visit', file, origin)
        except python_visit.NotTakenOverError as e:
            self.restore(found)
            return '' if e.reason is None else f': {e.reason}'
        except MissingArgumentError as e:
            # the outermost file is checked only with what has a default
            self.fail(e, is_certain=is_certain and self.depth > 0)
            self.may_have_others = True
        except LaunchError as e:
            self.fail(e, is_certain=is_certain)
            self.may_have_others = True
        except AlreadyReportedError:
            self.may_have_others = True
        return None

    def do_exposed(self, attributes: Attributes) -> None:
        raw, use = attributes.item.raw, self._files[-1].use
        assert raw is not None
        self.use_package(raw.package, attributes.position)
        read = FileUse()
        for text in raw.texts:
            read.add_text(text.template)
        values = map(self.scope.configurations.get, read.read)
        # what it reads itself is not known
        use.is_open = True
        is_known = (
            self.runs_exposed
            and not self.never
            and not read.is_open
            and all(v is not None and v.text is not None for v in values)
        )
        try:
            if is_known:
                self._run_exposed(partial(super().do_exposed, attributes))
        except AlreadyReportedError:
            is_known = False
        self.may_have_others = self.may_have_others or not is_known
        # with other arguments it may set anything
        self.scope.configurations.is_open = True

    def _run_exposed(self, run: Callable[[], str | None]) -> str | None:
        """
        Return what the worker comes to, and report what goes wrong.

        :raises AlreadyReportedError: when it comes to nothing
        """
        # most launch files have none
        from colcon_yamllaunch.language.python_files import exposed_actions

        is_certain = self.is_on_by_default
        try:
            return run()
        except exposed_actions.NotAskedError as e:
            self.report(e.as_warning().of('this cannot be checked: '))
        except LaunchError as e:
            self.fail(e, is_certain=is_certain)
        raise AlreadyReportedError

    def make_exposed(
        self, name: str, texts: tuple[str, ...], at: Span
    ) -> str | None:
        if self.never or not self.runs_exposed:
            return None
        make = partial(super().make_exposed, name, texts, at)
        with suppress(AlreadyReportedError):
            return self._run_exposed(make)
        return None

    def follow(
        self, attributes: Attributes, located: tuple[str, str] | None
    ) -> None:
        use = self._files[-1].use
        file = attributes.item.texts['file']
        if located is None or not self._may_follow(located[1], file):
            # it could do anything
            use.is_open = True
            self.may_have_others = True
            self.scope.configurations.is_open = True
            return
        path = located[1]
        if path.endswith(PYTHON_SUFFIX):
            use.is_open = True
            self.launch_python(*located, file)
            return
        use.includes.add(path)
        is_read = self.visit_file(*located, file)
        if not self.never:
            self._included = located[0]
        use.is_open = use.is_open or not is_read
        # what an include sets, all behind it see: its other arguments, too
        here = use.read - use.declared.keys()
        pairs = [*attributes.items('arg'), *attributes.items('let')]
        for index, pair in enumerate(pairs):
            behind = FileUse()
            for other in pairs[index + 1 :]:
                behind.add_text(other.item.texts['value'].template)
            name = pair.text('name')
            if name is None or name in here | behind.read:
                continue
            hint = unknown_argument(self.uses, path, name)
            if hint is not None:
                self.warn(
                    f"'{os.path.basename(path)}' declares no launch argument "
                    f"'{name}'",
                    pair.item.texts['name'],
                    hint,
                )

    def _may_follow(self, path: str, file: Text) -> bool:
        if path.endswith(PYTHON_SUFFIX) and (
            self.open_worker is None or self.never
        ):
            return False
        conditions = [f.conditions for f in self._files if f.path == path]
        if conditions and conditions[0] < self._conditions:
            # whether it ends depends on what a launch decides
            return False
        if self.depth >= MAXIMUM_INCLUDE_DEPTH:
            # to look at it again would only find the same
            self._visits[path] = MAXIMUM_INCLUDE_DEPTH
            self.fail(too_deep(file.position))
            return False
        if conditions:
            return self._visits[path] < MAXIMUM_INCLUDE_DEPTH
        return self._visits.get(path, 0) < MAXIMUM_VISITS

    def missing_argument(self, attributes: Attributes, name: str) -> None:
        include = self._files[-1]
        text = include.origin
        is_open = self.scope.configurations.may_have_others()
        if text is None or is_open or self.never:
            return
        is_certain = include.conditions == self._conditions
        self.fail_at(
            ValuePlace(text.position, text.length, self.includes[1:]),
            f"'{os.path.basename(include.path)}' requires the launch argument "
            f"'{name}', which is not passed",
            f'pass it: arg: [{{name: {name}, value: …}}]',
            is_certain=is_certain,
        )

    def default(self, value: Value, source: str) -> Value:
        return Value(value.text, source, value.sources | {source})

    def may_be_set(self, name: str) -> bool:
        # both may stand under the same condition
        is_behind = self.never > 0 and name in self._never_set
        return is_behind or super().may_be_set(name)

    def visit_rounds(
        self,
        children: tuple[Entity, ...],
        rounds: Iterable[dict[str, Value]],
        otherwise: dict[str, Value],
    ) -> None:
        first = list(islice(rounds, MAXIMUM_ROUNDS))
        self._timers_and_loops += 1
        super().visit_rounds(children, first or [otherwise], otherwise)
        self._timers_and_loops -= 1

    def visit_later(self, children: tuple[Entity, ...]) -> None:
        self._timers_and_loops += 1
        super().visit_later(children)
        self._timers_and_loops -= 1

    def is_program(self, path: str) -> bool:
        packages = self.packages
        found = _PROGRAM_PATH.fullmatch(path)
        if found:
            prefix, package, name = found.groups()
            if packages.prefix(package) == prefix:
                return packages.executable(package, name) is not None
        return super().is_program(path) or packages.locate(path) is not None

    def parameter_file(self, path: str) -> str | None:
        located = self.packages.locate(path)
        return super().parameter_file(path) if located is None else located[1]

    def found_beside(self, file: Text, written: str) -> None:
        if self._portable:
            self.report(
                error(
                    'ROS 2 looks up a relative path in the working directory',
                    file,
                    hint=f'write $(dirname)/{written}',
                )
            )

    def name_place(self, call: Call, path: str) -> None:
        included = self._included
        if not self._portable or included is None:
            return
        if call.name == 'dirname':
            included = os.path.dirname(included)
        if included != path:
            self.warn(
                f"behind an 'include', ROS 2 before Lyrical takes "
                f'$({call.name}) for that of the included file',
                call,
                "set it before the 'include': let: {name: here, value: "
                f'$({call.name})}}',
            )

    def note_text(self, template: Template | None) -> None:
        use = self._files[-1].use
        if template is None:
            use.is_open = True
        else:
            use.add_text(template)


class _Listing(_Check):
    """A check that only finds launch arguments."""

    has_environment = True
    runs_exposed = False

    def __init__(self, request: Request) -> None:
        super().__init__(request)
        self.arguments: dict[str, DeclaredArgument] = {}
        self.not_followed: dict[Position, str] = {}
        # what is wrong where, as a file may be included twice
        self.mistakes: dict[tuple[str, Position | None], Diagnostic] = {}
        # why an include cannot be followed
        self._problem: LaunchError | None = None

    @property
    def _is_conditional(self) -> bool:
        # behind a conditional reset all depends on its condition
        return (
            self._conditions + self._timers_and_loops > 0
            or self.scope.configurations.is_given is None
        )

    def fail(self, problem: LaunchError, *, is_certain: bool = True) -> None:
        # the launch reports it
        self._problem = self._problem or problem

    def fail_at(self, *_arguments: object, **_options: object) -> None:
        pass

    def visit(self, entity: Entity) -> None:
        # behind a reset the command line does not count
        if self.scope.configurations.is_given is not False:
            super().visit(entity)

    def act(self, entity: Entity) -> None:
        if entity.action.name not in PASSIVE:
            self._problem = None
            super().act(entity)

    def guard(self, entity: Entity) -> Guard | None:
        texts = entity.item.texts
        return _ANY_CONDITION if 'if' in texts or 'unless' in texts else None

    def declare(
        self, attributes: Attributes, name: str, choices: tuple[str, ...]
    ) -> None:
        texts = attributes.item.texts
        description, default = (
            texts[key].plain if key in texts else None
            for key in ('description', 'default')
        )
        at = attributes.position
        self._add(DeclaredArgument(name, at, description, default, choices))

    def _add(self, argument: DeclaredArgument) -> None:
        """Add an argument, and where the launch files set it themselves."""
        value = self.scope.configurations.get(argument.name)
        is_set = value is not None and value.text is not None
        origins = value.origins if value and is_set else ()
        argument = replace(
            argument,
            is_conditional=argument.is_conditional or self._is_conditional,
            set_at=origins[0] if origins else None,
        )
        self.arguments.setdefault(argument.name, argument)

    def launch_python(self, name: str, path: str, origin: Span) -> None:
        # most launch files are not in Python
        from colcon_yamllaunch.language.python_files import python_visit

        is_first = not self.depth
        # before the package is built, only the file in its source is there
        file = name if os.path.isfile(name) else path
        found = None
        try:
            found = python_visit.declared_arguments(self, file, origin)
        except LaunchError as e:
            if is_first:
                raise
            self.read_failed(e, origin)
        except AlreadyReportedError:
            pass
        for argument in found or ():
            self._add(argument)
        if found is None and is_first:
            raise error(
                'the launch arguments of a launch file in Python show only '
                'when it runs',
                hint='source a ROS 2 that has launch_ros; where it is, '
                f"'ros2 launch -s {path}' shows them too",
            )
        if found is None:
            self._note('it is written in Python', origin.position)

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
        located = super().locate(attributes)
        if located is None:
            reason = self._problem or 'its path shows only when it is launched'
            self._note(str(reason), attributes.item.texts['file'].position)
        return located

    def _may_follow(self, path: str, file: Text) -> bool:
        if self.is_open(path):
            # all arguments of a file that includes itself are known already
            return False
        if path.endswith(PYTHON_SUFFIX):
            return True
        self._problem = None
        is_followed = super()._may_follow(path, file)
        if self._problem is not None:
            self._note(str(self._problem), file.position)
        return is_followed

    def _note(self, reason: str, position: Position) -> None:
        """Note why an include is not followed."""
        self.not_followed.setdefault(position, reason)
