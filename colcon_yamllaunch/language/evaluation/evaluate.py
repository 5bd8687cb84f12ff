# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""From a launch file and its arguments to a plan."""

from collections.abc import Callable
from collections.abc import Mapping
import os
from typing import NoReturn

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.language.evaluation import process_actions
from colcon_yamllaunch.language.evaluation import scope_actions
from colcon_yamllaunch.language.evaluation.evaluation_state import (
    ExecutableUse,
)
from colcon_yamllaunch.language.evaluation.evaluation_state import State
from colcon_yamllaunch.language.evaluation.python_launch import (
    add_python_launch_file,
)
from colcon_yamllaunch.language.evaluation.python_launch import PYTHON_SUFFIX
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.plan.plan import Condition
from colcon_yamllaunch.language.plan.plan import Entry
from colcon_yamllaunch.language.plan.plan import Plan
from colcon_yamllaunch.language.plan.plan import Timer
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.position import Position
from colcon_yamllaunch.language.syntax.source_text import read_source
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.language.tree.launch_tree import Entity
from colcon_yamllaunch.language.tree.launch_tree import Item
from colcon_yamllaunch.language.tree.launch_tree import LaunchFile
from colcon_yamllaunch.language.tree.launch_tree import read_launch_file
from colcon_yamllaunch.language.tree.text import Text
from colcon_yamllaunch.language.vocabulary.substitutions import (
    AlreadyReportedError,
)
import yaml

#: How many launch files may be open inside of one another.
MAXIMUM_INCLUDE_DEPTH = 40
#: How many actions a launch may have.
MAXIMUM_ACTIONS = 200_000


@dataclass(frozen=True, slots=True)
class Evaluation:
    """
    What a launch file comes to.

    :param plan: What to run; not complete when there are errors
    :param packages: The packages that it names, and where first
    :param executables: The packages' programs that it names
    :param files: The launch files that were read, the given one first
    :param diagnostics: Errors and warnings, in the order found
    """

    plan: Plan
    packages: Mapping[str, Position]
    executables: tuple[ExecutableUse, ...]
    files: tuple[Source, ...]
    diagnostics: tuple[Diagnostic, ...]

    @property
    def errors(self) -> tuple[Diagnostic, ...]:
        """The errors among the diagnostics."""
        return tuple(d for d in self.diagnostics if d.severity == 'error')


def evaluate(request: Request) -> Evaluation:
    """
    Evaluate a launch file with everything that it includes.

    Nothing is started but what `$(command …)` says.

    :param request: The launch file, and what to evaluate it with
    """
    state = State(request)
    evaluator = _Evaluator(state)
    evaluator.run(request.name, request.path)
    if not evaluator.has_python:
        # what a launch file in Python declares is not known
        _warn_of_unknown_arguments(state, evaluator.files, request.arguments)
    return Evaluation(
        Plan(
            tuple(state.entries), tuple(state.blocks), tuple(state.conditions)
        ),
        state.packages_used,
        tuple(state.executables),
        tuple(file.source for file in evaluator.files.values()),
        tuple(state.diagnostics),
    )


class _Evaluator:
    """Goes through the actions in order."""

    def __init__(self, state: State) -> None:
        self._state = state
        self._actions = 0
        self.files: dict[str, LaunchFile] = {}
        self.has_python = False

    def run(self, name: str, path: str) -> None:
        try:
            if path.endswith(PYTHON_SUFFIX):
                self._python(name, path, Position(path, 1, 1))
            else:
                self._file(name, path, None)
        except LaunchError as e:
            self._state.report(e)
        except _EndlessError:
            pass
        except RecursionError:
            self._state.report(error('the launch file is nested too deep'))

    def _file(
        self, name: str, path: str, included_from: Position | None
    ) -> None:
        file = self._read(name, path, included_from)
        start = included_from or file.source.position(0, 0)
        with (
            self._state.within(file.source, included_from),
            self._state.within_block('file', name, start),
        ):
            if file.deprecated is not None:
                self._state.warn(
                    f'this launch file is deprecated: {file.deprecated}',
                    file.source.position(0, 0),
                )
            self._visit_all(file.entities)

    def _python(
        self, name: str, path: str, position: Position, length: int = 1
    ) -> None:
        # before the package is built, only the file in its source is there
        file = name if os.path.isfile(name) else path
        self.has_python = True
        with self._state.within_block('file', name, position):
            add_python_launch_file(self._state, file, position, length)

    def _read(
        self, name: str, path: str, included_from: Position | None
    ) -> LaunchFile:
        if path not in self.files:
            try:
                self.files[path] = read_launch_file(read_source(path, name))
            except LaunchError as e:
                if included_from is None:
                    raise
                raise e.included_from(included_from) from e
        return self.files[path]

    def _visit_all(self, entities: tuple[Entity, ...]) -> None:
        for entity in entities:
            self._actions += 1
            if self._actions > MAXIMUM_ACTIONS:
                self._give_up(
                    f'the launch has more than {MAXIMUM_ACTIONS} actions',
                    entity.item.position,
                )
            try:
                if _applies(self._state, entity.item):
                    self._visit(entity)
            except LaunchError as e:
                self._state.report(e)
            except AlreadyReportedError:
                pass

    def _give_up(self, message: str, position: Position) -> NoReturn:
        hint = 'does a launch file include itself?'
        self._state.report(error(message, position, hint=hint))
        raise _EndlessError

    def _visit(self, entity: Entity) -> None:
        simple = SIMPLE.get(entity.action.name)
        if simple is not None:
            simple(self._state, entity.item)
        else:
            _COMPOUND[entity.action.name](self, entity)

    def include(self, entity: Entity) -> None:
        state, item = self._state, entity.item
        file = item.texts['file']
        if state.depth >= MAXIMUM_INCLUDE_DEPTH:
            self._give_up(
                f'more than {MAXIMUM_INCLUDE_DEPTH} launch files include one '
                'another',
                file.position,
            )
        name, path = locate_include(state, file)
        for argument in ('arg', 'let'):
            for pair in item.items.get(argument, ()):
                scope_actions.visit_let(state, pair)
        if path.endswith(PYTHON_SUFFIX):
            self._python(name, path, file.position, file.length)
        else:
            self._file(name, path, file.position)

    def group(self, entity: Entity) -> None:
        state, item = self._state, entity.item
        with state.within_block('group', '', item.position):
            self._group(entity)

    def _group(self, entity: Entity) -> None:
        state, item = self._state, entity.item
        keep = state.pairs(item, 'keep')
        outer = state.scope
        if not state.boolean(item, 'scoped', True):
            outer.configurations.update(keep)
            self._visit_all(entity.children)
            return
        state.scope = outer.copy()
        if not state.boolean(item, 'forwarding', True):
            state.scope.reset_configurations()
            state.scope.environment = dict(state.environment)
        state.scope.configurations.update(keep)
        try:
            self._visit_all(entity.children)
            if state.scope.namespace != outer.namespace:
                state.name_block(f'namespace {state.scope.namespace}')
        finally:
            state.scope = outer

    def timer(self, entity: Entity) -> None:
        state, item = self._state, entity.item
        period = state.seconds(item, 'period')
        assert period is not None
        cancel = state.boolean(item, 'cancel_on_shutdown', True)
        outer, before = state.scope, state.entries
        entries: list[Entry] = []
        state.scope, state.entries = outer.copy(), entries
        try:
            with state.within_block('timer', f'{period:g} s', item.position):
                self._visit_all(entity.children)
        finally:
            state.scope, state.entries = outer, before
        state.entries.append(Timer(period, tuple(entries), cancel))

    def repeat(self, entity: Entity) -> None:
        item = entity.item
        count = self._state.integer(item, 'len', 0)
        name = item.texts['name'].plain
        for index in range(count):
            self._iterate(entity, {name: str(index)})

    def for_each(self, entity: Entity) -> None:
        text = entity.item.texts['values']
        values = text.evaluate(self._state)
        if not values.strip():
            self._state.warn(
                "'for_each' has no values", text.position, length=text.length
            )
            return
        for piece in values.split(';'):
            self._iterate(entity, _loop_variables(piece, text))

    def _iterate(self, entity: Entity, variables: dict[str, str]) -> None:
        outer = self._state.scope.locals
        self._state.scope.locals = {**outer, **variables}
        try:
            self._visit_all(entity.children)
        finally:
            self._state.scope.locals = outer


_COMPOUND: Mapping[str, Callable[[_Evaluator, Entity], None]] = {
    'include': _Evaluator.include,
    'group': _Evaluator.group,
    'timer': _Evaluator.timer,
    'for': _Evaluator.repeat,
    'for_each': _Evaluator.for_each,
}
#: What does an action that has no others inside.
SIMPLE: Mapping[str, Callable[[State, Item], None]] = {
    'arg': scope_actions.visit_arg,
    'bool_arg': scope_actions.visit_bool_arg,
    'let': scope_actions.visit_let,
    'reset': scope_actions.visit_reset,
    'set_env': scope_actions.visit_set_env,
    'unset_env': scope_actions.visit_unset_env,
    'append_env': scope_actions.visit_append_env,
    'reset_env': scope_actions.visit_reset_env,
    'log': scope_actions.visit_log,
    'log_info': scope_actions.visit_log_info,
    'log_warning': scope_actions.visit_log_warning,
    'log_error': scope_actions.visit_log_error,
    'log_debug': scope_actions.visit_log_debug,
    'shutdown': scope_actions.visit_shutdown,
    'push_ros_namespace': scope_actions.visit_push_ros_namespace,
    'set_parameter': scope_actions.visit_set_parameter,
    'set_parameters_from_file': scope_actions.visit_set_parameters_from_file,
    'set_remap': scope_actions.visit_set_remap,
    'set_use_sim_time': scope_actions.visit_set_use_sim_time,
    'set_ros_log_dir': scope_actions.visit_set_ros_log_dir,
    'executable': process_actions.visit_executable,
    'node': process_actions.visit_node,
    'node_container': process_actions.visit_node,
}


class _EndlessError(Exception):
    """The launch would hardly ever end; the user was told."""


def _applies(state: State, item: Item) -> bool:
    """Evaluate the condition of an action."""
    for name, wanted in (('if', True), ('unless', False)):
        text = item.texts.get(name)
        if text is None:
            continue
        value = text.evaluate(state).strip().lower()
        if text.literal is not None and text.kind == 'bool':
            value = str(text.value).lower()
        if value not in ('true', '1', 'false', '0'):
            raise error(
                f"the condition '{name}' is '{value}'",
                text.position,
                hint='it must be true, 1, false or 0',
                length=text.length,
                origins=state.origins,
            )
        taken = (value in ('true', '1')) is wanted
        shown = f'{name}: {text.plain}'
        state.conditions.append(Condition(shown, taken, text.position))
        return taken
    return True


def locate_include(state: State, file: Text) -> tuple[str, str]:
    """Find an included file: the path it goes by, and the one to read."""
    written = file.evaluate(state)
    folders = [state.cwd]
    if not os.path.isabs(written):
        folders.append(os.path.dirname(state.source.name))
    candidates = [
        os.path.normpath(os.path.join(folder, written)) for folder in folders
    ]
    for candidate in candidates:
        located = state.packages.locate(candidate)
        if located is not None:
            return located
    raise error(
        f"the launch file '{written}' does not exist",
        file.position,
        hint=did_you_mean(
            os.path.basename(written),
            state.packages.similar(candidates[-1]),
        ),
        length=file.length,
    )


def _loop_variables(piece: str, text: Text) -> dict[str, str]:
    try:
        loaded = yaml.safe_load(piece)
    except (yaml.YAMLError, ValueError, RecursionError):
        loaded = None
    if not isinstance(loaded, dict):
        raise error(
            f"'{piece.strip()}' is no YAML mapping of names to values",
            text.position,
            hint="write '{name: value}' for each, with ';' between",
            length=text.length,
        )
    return {str(name): str(value) for name, value in loaded.items()}


def _warn_of_unknown_arguments(
    state: State,
    files: Mapping[str, LaunchFile],
    arguments: Mapping[str, str],
) -> None:
    declared = set(state.declared)
    for file in files.values():
        for entity in file.walk():
            if entity.action.name in ('arg', 'bool_arg'):
                declared.add(entity.item.texts['name'].plain)
    known = declared | state.read | set(process_actions.PROCESS_ARGUMENTS)
    for name in arguments:
        if name not in known:
            state.warn(
                f"no launch file declares the launch argument '{name}'",
                None,
                hint=did_you_mean(name, declared)
                or (
                    'it declares '
                    + (', '.join(sorted(declared)) if declared else 'none')
                ),
            )
