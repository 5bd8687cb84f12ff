# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Looking a launch file over without running it.

It is evaluated with values that may be unknown. Every action is looked at,
whatever its condition comes to, and every launch file that is included.
"""

from collections.abc import Callable
from collections.abc import Mapping
from dataclasses import replace
import os

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.language.checking.argument_use import ArgumentUse
from colcon_yamllaunch.language.checking.argument_use import FileUse
from colcon_yamllaunch.language.checking.attributes import check_attributes
from colcon_yamllaunch.language.checking.attributes import check_pairs
from colcon_yamllaunch.language.checking.attributes import truth
from colcon_yamllaunch.language.checking.attributes import whole_number
from colcon_yamllaunch.language.checking.check_state import Checking
from colcon_yamllaunch.language.checking.check_state import OpenFile
from colcon_yamllaunch.language.checking.portability import (
    portability_problems,
)
from colcon_yamllaunch.language.checking.possible_scope import Binding
from colcon_yamllaunch.language.checking.possible_scope import Guard
from colcon_yamllaunch.language.checking.possible_scope import known
from colcon_yamllaunch.language.checking.possible_scope import Scope
from colcon_yamllaunch.language.checking.possible_scope import unknown
from colcon_yamllaunch.language.checking.possible_scope import Value
from colcon_yamllaunch.language.checking.possible_values import ANY_VARIABLE
from colcon_yamllaunch.language.checking.possible_values import value_of
from colcon_yamllaunch.language.checking.process_checks import ProcessChecks
from colcon_yamllaunch.language.checking.scope_checks import set_pair
from colcon_yamllaunch.language.checking.scope_checks import SETTINGS
from colcon_yamllaunch.language.evaluation.evaluate import MAXIMUM_ACTIONS
from colcon_yamllaunch.language.evaluation.evaluate import (
    MAXIMUM_INCLUDE_DEPTH,
)
from colcon_yamllaunch.language.evaluation.evaluation_state import (
    ExecutableUse,
)
from colcon_yamllaunch.language.evaluation.evaluation_state import State
from colcon_yamllaunch.language.evaluation.python_launch import PYTHON_SUFFIX
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.position import Position
from colcon_yamllaunch.language.syntax.source_text import read_source
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.language.tree.launch_tree import Entity
from colcon_yamllaunch.language.tree.launch_tree import Item
from colcon_yamllaunch.language.tree.launch_tree import LaunchFile
from colcon_yamllaunch.language.tree.launch_tree import read_launch_file
from colcon_yamllaunch.language.tree.text import Text
import yaml

#: How often one launch file is looked at, with other arguments each time.
MAXIMUM_VISITS = 20
#: How many rounds of a loop are looked at one by one.
MAXIMUM_ROUNDS = 50


@dataclass(frozen=True, slots=True)
class Checked:
    """
    What a check found.

    :param diagnostics: Errors and warnings, in the order found
    :param files: The launch files that were read, the given one first
    :param packages: The packages that they name, and where first
    :param executables: The packages' programs that they name
    """

    diagnostics: tuple[Diagnostic, ...]
    files: tuple[Source, ...]
    packages: Mapping[str, Position]
    executables: tuple[ExecutableUse, ...]

    @property
    def errors(self) -> tuple[Diagnostic, ...]:
        """The errors among the diagnostics."""
        return tuple(d for d in self.diagnostics if d.severity == 'error')


def check(request: Request, *, portable: bool) -> Checked:
    """
    Look a launch file over, with everything that it includes.

    Nothing is started, and nothing but harmless expressions is computed.

    :param request: The launch file; its launch arguments are sure to be given
    :param portable: Whether to report what ROS 2's launcher does not accept
    """
    state = State(replace(request, arguments={}))
    checker = _Checker(Checking(state, portable=portable))
    checker.run(request.name, request.path, request.arguments)
    return Checked(
        tuple(dict.fromkeys(state.diagnostics)),
        tuple(checker.sources),
        state.packages_used,
        tuple(dict.fromkeys(state.executables)),
    )


class _TooManyActionsError(Exception):
    """There is more to look at than any real launch has."""


class _Checker:
    """Goes through the actions in order."""

    def __init__(self, checking: Checking) -> None:
        self._checking = checking
        self._state = checking.state
        self._processes = ProcessChecks(checking)
        self._arguments = ArgumentUse()
        self._visits: dict[str, int] = {}
        self._actions = 0
        self.files: dict[str, LaunchFile | None] = {}
        self.sources: list[Source] = []

    def run(self, name: str, path: str, arguments: Mapping[str, str]) -> None:
        for argument, value in arguments.items():
            self._scope.configurations.own[argument] = Binding(known(value))
        if path.endswith(PYTHON_SUFFIX):
            self._checking.warn(
                'a launch file in Python cannot be checked',
                Position(path, 1, 1),
            )
            return
        try:
            self._file(name, path, None)
        except _TooManyActionsError:
            self._checking.error(
                f'there are more than {MAXIMUM_ACTIONS} actions to look at',
                None,
                hint='does a launch file include itself?',
            )
        except RecursionError:
            self._checking.error('the launch file is nested too deep', None)
        if None not in self.files.values():
            self._check_arguments(path, arguments)

    def _check_arguments(
        self, path: str, arguments: Mapping[str, str]
    ) -> None:
        for diagnostic in (
            *self._arguments.unused(),
            *self._arguments.unknown_given(path, arguments),
        ):
            self._state.report(LaunchError(diagnostic))

    @property
    def _scope(self) -> Scope:
        return self._checking.scope

    def _file(self, name: str, path: str, origin: Text | None) -> None:
        file = self._read(name, path, origin)
        if file is None:
            self._scope.configurations.is_open = True
            return
        checking = self._checking
        position = None if origin is None else origin.position
        self._checking.open.append(OpenFile(path, origin, checking.conditions))
        before = checking.included, checking.use
        checking.included, checking.use = None, self._arguments[path]
        try:
            with self._state.within(file.source, position):
                self._look_at_file(path, file)
                self._visit_all(file.entities)
        finally:
            checking.included, checking.use = before
            self._checking.open.pop()

    def _read(
        self, name: str, path: str, origin: Text | None
    ) -> LaunchFile | None:
        if path not in self.files:
            self.files[path] = None
            try:
                source = read_source(path, name)
                self.sources.append(source)
                file = read_launch_file(source)
            except LaunchError as e:
                problem = e
                if origin is not None:
                    problem = e.included_from(origin.position)
                self._checking.report(problem)
                return None
            self.files[path] = file
            self._arguments.add(path, file)
        return self.files[path]

    def _look_at_file(self, path: str, file: LaunchFile) -> None:
        """Look at what does not depend on who includes the file."""
        self._visits[path] = self._visits.get(path, 0) + 1
        if self._visits[path] > 1:
            return
        if file.deprecated is not None:
            self._checking.warn(
                f'this launch file is deprecated: {file.deprecated}',
                file.source.position(0, 0),
            )
        if self._checking.portable:
            for diagnostic in portability_problems(file):
                self._checking.report(LaunchError(diagnostic))

    def _visit_all(self, entities: tuple[Entity, ...]) -> None:
        for entity in entities:
            self._actions += 1
            if self._actions > MAXIMUM_ACTIONS:
                raise _TooManyActionsError
            self._visit(entity)

    def _visit(self, entity: Entity) -> None:
        checking = self._checking
        guard = self._guard(entity.item)
        if guard is None:
            self._act(entity)
            return
        is_sure = not guard.sources
        inner = checking.scope.inner(
            hides=guard.taken is False,
            masked=_read_by_condition(entity.item, guard),
        )
        if not is_sure:
            checking.guards.append(guard)
        elif not guard.taken:
            checking.never += 1
        checking.conditions += 1
        try:
            with checking.within_scope(inner):
                self._act(entity)
        finally:
            checking.conditions -= 1
            if not is_sure:
                checking.guards.pop()
            elif not guard.taken:
                checking.never -= 1
        if not is_sure or guard.taken:
            checking.scope.merge(inner, None if is_sure else guard)

    def _guard(self, item: Item) -> Guard | None:
        """Evaluate the condition of an action, None when it has none."""
        for name, wanted in (('if', True), ('unless', False)):
            text = item.texts.get(name)
            if text is None:
                continue
            value = value_of(self._checking, text)
            result = _truth_of_condition(text, value)
            if result is None and value.text is not None:
                self._checking.error(
                    f"the condition '{name}' is '{value.text.strip()}'",
                    text.position,
                    hint='it must be true, 1, false or 0',
                    length=text.length,
                )
            if result is None:
                sources = value.sources or frozenset((value.key,))
                return Guard(value.key, wanted, sources, None)
            return Guard(value.key, wanted, value.sources, result is wanted)
        return None

    def _act(self, entity: Entity) -> None:
        values = check_attributes(self._checking, entity.action, entity.item)
        name = entity.action.name
        if name in SETTINGS:
            SETTINGS[name](self._checking, entity, values)
        elif name in _COMPOUND:
            _COMPOUND[name](self, entity, values)
        elif name == 'executable':
            self._processes.executable(entity.item, values)
        elif name in ('node', 'node_container'):
            self._processes.node(entity.item, values)

    def group(self, entity: Entity, values: dict[str, Value]) -> None:
        keep = check_pairs(self._checking, entity.item.items.get('keep', ()))
        scoped = truth(values.get('scoped'), True)
        outer = self._scope
        inner = outer if scoped is False else outer.inner()
        if scoped and truth(values.get('forwarding'), True) is False:
            inner = Scope(variables=outer.variables)
        with self._checking.within_scope(inner):
            for pair in keep:
                set_pair(self._checking, *pair)
            self._visit_all(entity.children)
        if scoped is None:
            value = values['scoped']
            outer.merge(inner, Guard(value.key, False, value.sources, None))

    def timer(self, entity: Entity, _: dict[str, Value]) -> None:
        with self._checking.within_scope(self._scope.inner()):
            self._visit_all(entity.children)

    def repeat(self, entity: Entity, values: dict[str, Value]) -> None:
        name = entity.item.texts['name'].plain
        length = values['len']
        count = whole_number(length)
        rounds: list[dict[str, Value]] = [
            {name: Value(str(index), str(index), length.sources)}
            for index in range(min(count or 0, MAXIMUM_ROUNDS))
        ]
        self._loop(entity, rounds, {name: unknown(f'$(index {name})', {name})})

    def for_each(self, entity: Entity, values: dict[str, Value]) -> None:
        value = values['values']
        pieces = [] if value.text is None else value.text.split(';')
        rounds = []
        for piece in pieces[:MAXIMUM_ROUNDS]:
            if not piece.strip() and len(pieces) == 1:
                break
            variables = _loop_variables(piece)
            if variables is None:
                text = entity.item.texts['values']
                self._checking.error(
                    f"'{piece.strip()}' is no YAML mapping of names to values",
                    text.position,
                    hint="write '{name: value}' for each, with ';' between",
                    length=text.length,
                )
                continue
            rounds.append(
                {
                    name: Value(text, text, value.sources)
                    for name, text in variables.items()
                }
            )
        any_value = unknown(value.key, value.sources or {value.key})
        self._loop(entity, rounds, {ANY_VARIABLE: any_value})

    def _loop(
        self,
        entity: Entity,
        rounds: list[dict[str, Value]],
        otherwise: dict[str, Value],
    ) -> None:
        """Look at a loop in each round, or once when they are not known."""
        scope = self._scope
        outer = scope.variables
        try:
            for variables in rounds or [otherwise]:
                scope.variables = {**outer, **variables}
                self._visit_all(entity.children)
        finally:
            scope.variables = outer

    def include(self, entity: Entity, values: dict[str, Value]) -> None:
        checking, item = self._checking, entity.item
        file = item.texts['file']
        located = self._locate(file, values['file'])
        pairs = check_pairs(
            checking, (*item.items.get('arg', ()), *item.items.get('let', ()))
        )
        for pair in pairs:
            set_pair(checking, *pair)
        if located is None or not self._may_follow(located[1], file):
            self._skip()
            return
        path = located[1]
        checking.use.includes.add(path)
        self._file(*located, file)
        if not checking.never:
            checking.included = located[0]
        if self.files[path] is None:
            checking.use.is_open = True
        for inner, name, _ in pairs:
            self._check_passed(path, inner, name.text)

    def _skip(self) -> None:
        """Allow for all that a launch file could do that is not looked at."""
        self._checking.use.is_open = True
        self._scope.configurations.is_open = True

    def _may_follow(self, path: str, file: Text) -> bool:
        """Say whether to look at an included launch file."""
        if path.endswith(PYTHON_SUFFIX):
            return False
        files = self._checking.open
        conditions = [f.conditions for f in files if f.path == path]
        if conditions and conditions[0] < self._checking.conditions:
            # whether it ends depends on what a launch decides
            return False
        if len(files) >= MAXIMUM_INCLUDE_DEPTH:
            # to look at it again would only find the same
            self._visits[path] = MAXIMUM_VISITS
            self._checking.error(
                f'more than {MAXIMUM_INCLUDE_DEPTH} launch files include one '
                'another',
                file.position,
                hint='does a launch file include itself?',
            )
            return False
        if conditions:
            return self._visits[path] < MAXIMUM_INCLUDE_DEPTH
        return self._visits.get(path, 0) < MAXIMUM_VISITS

    def _check_passed(self, path: str, pair: Item, name: str | None) -> None:
        if name is None:
            return
        hint = self._arguments.unknown_argument(path, name)
        if hint is not None:
            text = pair.texts['name']
            self._checking.warn(
                f"'{os.path.basename(path)}' declares no launch argument "
                f"'{name}'",
                text.position,
                hint=hint,
                length=text.length,
            )

    def _locate(self, file: Text, value: Value) -> tuple[str, str] | None:
        """Find an included launch file: the path it goes by, and its path."""
        if value.text is None:
            return None
        checking, packages = self._checking, self._checking.packages
        beside = os.path.dirname(self._state.source.name)
        candidate = checking.absolute(value.text)
        located = packages.locate(candidate)
        if located is None and not os.path.isabs(value.text):
            candidate = os.path.normpath(os.path.join(beside, value.text))
            located = packages.locate(candidate)
            if located is not None and checking.portable:
                checking.error(
                    'ROS 2 looks up a relative path in the working directory',
                    file.position,
                    hint=f'write $(dirname)/{value.text}',
                    length=file.length,
                )
        if located is None:
            checking.error(
                f"the launch file '{value.text}' does not exist",
                file.position,
                hint=did_you_mean(
                    os.path.basename(value.text), packages.similar(candidate)
                ),
                length=file.length,
            )
        return located


_COMPOUND: Mapping[
    str, Callable[[_Checker, Entity, dict[str, Value]], None]
] = {
    'group': _Checker.group,
    'timer': _Checker.timer,
    'for': _Checker.repeat,
    'for_each': _Checker.for_each,
    'include': _Checker.include,
}


def _truth_of_condition(text: Text, value: Value) -> bool | None:
    if value.text is None:
        return None
    word = value.text.strip().lower()
    if text.literal is not None and text.kind == 'bool':
        word = str(text.value).lower()
    if word not in ('true', '1', 'false', '0'):
        return None
    return word in ('true', '1')


def _read_by_condition(item: Item, guard: Guard) -> frozenset[str]:
    """Return the names whose values a condition may decide on."""
    if guard.taken is not None:
        return frozenset()
    use = FileUse()
    for name in ('if', 'unless'):
        if name in item.texts:
            use.add_text(item.texts[name].template)
    return frozenset(use.read)


def _loop_variables(piece: str) -> dict[str, str] | None:
    try:
        loaded = yaml.safe_load(piece)
    except (yaml.YAMLError, ValueError, RecursionError):
        return None
    if not isinstance(loaded, dict):
        return None
    return {str(name): str(value) for name, value in loaded.items()}
