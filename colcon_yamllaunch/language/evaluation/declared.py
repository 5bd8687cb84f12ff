# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The launch arguments that a launch file and its includes declare.

They are found without running anything: no `$(command …)` and no `$(eval …)`,
and not by what a condition comes to, since another argument may change that.
"""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Mapping

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.evaluation import scope_actions
from colcon_yamllaunch.language.evaluation.evaluate import locate_include
from colcon_yamllaunch.language.evaluation.evaluate import MAXIMUM_ACTIONS
from colcon_yamllaunch.language.evaluation.evaluate import (
    MAXIMUM_INCLUDE_DEPTH,
)
from colcon_yamllaunch.language.evaluation.evaluate import SIMPLE
from colcon_yamllaunch.language.evaluation.evaluation_state import State
from colcon_yamllaunch.language.evaluation.python_launch import PYTHON_SUFFIX
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.position import Position
from colcon_yamllaunch.language.syntax.source_text import read_source
from colcon_yamllaunch.language.syntax.template import Substitution
from colcon_yamllaunch.language.syntax.template import Template
from colcon_yamllaunch.language.tree.launch_tree import Entity
from colcon_yamllaunch.language.tree.launch_tree import Item
from colcon_yamllaunch.language.tree.launch_tree import LaunchFile
from colcon_yamllaunch.language.tree.launch_tree import read_launch_file
from colcon_yamllaunch.language.tree.text import Text
from colcon_yamllaunch.language.vocabulary.scope import Scope
from colcon_yamllaunch.language.vocabulary.substitutions import (
    AlreadyReportedError,
)

# the substitutions that only a launch can make: those that run something, and
# those whose value is not followed here
_ONLY_LAUNCHED = frozenset(
    ('command', 'eval', 'anon', 'param', 'for-var', 'index')
)


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
class Declarations:
    """
    What is known of the launch arguments without launching.

    :param arguments: The launch arguments, in the order of the files
    :param not_followed: Where includes are that may declare more of them, and
      why these could not be followed
    """

    arguments: tuple[DeclaredArgument, ...]
    not_followed: Mapping[Position, str]


def find_declarations(request: Request) -> Declarations:
    """
    Find the launch arguments of a launch file with everything it includes.

    As in ROS 2 (`LaunchDescription.get_launch_arguments`), the first
    declaration of a name counts, and what stands behind a `reset` does not,
    since the command line does not reach there.

    :param request: The launch file; the launch arguments matter only for the
      paths of includes
    :raises LaunchError: if a launch file that is used in any case has mistakes
    """
    state = State(request)
    finder = _Finder(state)
    try:
        finder.find(request.name, request.path)
    except RecursionError:
        raise error('the launch file is nested too deep') from None
    errors = [d for d in state.diagnostics if d.severity == 'error']
    if errors:
        raise LaunchError(*errors)
    return Declarations(tuple(finder.arguments.values()), finder.not_followed)


class _Finder:
    """Goes through the actions in order, those of false conditions too."""

    def __init__(self, state: State) -> None:
        self._state = state
        self._files: dict[str, LaunchFile] = {}
        self._open: list[str] = []
        self._count = 0
        self._is_conditional = False
        self._is_over = False
        # whether a condition decides about the environment
        self._is_environment_unsure = False
        self.arguments: dict[str, DeclaredArgument] = {}
        self.not_followed: dict[Position, str] = {}

    def find(self, name: str, path: str) -> None:
        if path.endswith(PYTHON_SUFFIX):
            raise error(
                'the launch arguments of a launch file in Python show only '
                'when it runs',
                hint=f"'ros2 launch -s {path}' shows them",
            )
        self._visit_file(self._read(name, path), None)

    def _read(self, name: str, path: str) -> LaunchFile:
        if path not in self._files:
            self._files[path] = read_launch_file(read_source(path, name))
        return self._files[path]

    def _visit_file(
        self, file: LaunchFile, included_from: Position | None
    ) -> None:
        self._open.append(file.source.path)
        with self._state.within(file.source, included_from):
            self._visit_all(file.entities)
        self._open.pop()

    def _visit_all(self, entities: tuple[Entity, ...]) -> None:
        for entity in entities:
            if self._is_over:
                return
            self._count += 1
            if self._count > MAXIMUM_ACTIONS:
                raise error(
                    f'the launch has more than {MAXIMUM_ACTIONS} actions',
                    entity.item.position,
                )
            if _is_conditional(entity):
                self._visit_conditional(entity)
            else:
                self._visit(entity)

    def _visit_conditional(self, entity: Entity) -> None:
        """Visit an action, and forget what it sets: it may not come to it."""
        outer = self._state.scope
        was_environment_unsure = self._is_environment_unsure
        was_conditional, self._is_conditional = self._is_conditional, True
        self._state.scope = inner = _copy(outer)
        self._visit(entity)
        self._state.scope = outer
        self._is_environment_unsure = (
            was_environment_unsure or inner.environment != outer.environment
        )
        _forget_differences(outer, inner)
        # behind a conditional reset all else depends on its condition
        self._is_conditional = was_conditional or self._is_over
        self._is_over = False

    def _visit(self, entity: Entity) -> None:
        name = entity.action.name
        if name in ('arg', 'bool_arg'):
            self._declare(entity)
        effect = _EFFECTS.get(name)
        if effect is not None:
            self._apply(effect, entity.item)
        elif name == 'include':
            self._include(entity.item)
        elif name == 'group':
            self._group(entity)
        elif name == 'timer':
            self._timer(entity)
        else:
            self._visit_all(entity.children)
        if name == 'reset':
            self._is_over = True

    def _declare(self, entity: Entity) -> None:
        texts = entity.item.texts
        name = texts['name'].plain
        if name in self.arguments:
            return
        choices = tuple(
            choice.texts['value'].plain
            for choice in entity.item.items.get('choice', ())
        )
        if entity.action.name == 'bool_arg':
            choices = scope_actions.BOOLEAN_CHOICES
        scope = self._state.scope
        set_at = scope.origins.get(name, ())
        self.arguments[name] = DeclaredArgument(
            name,
            entity.item.position,
            texts['description'].plain if 'description' in texts else None,
            texts['default'].plain if 'default' in texts else None,
            choices,
            self._is_conditional,
            set_at[0] if set_at and name in scope.configurations else None,
        )

    def _apply(self, effect: '_Effect', item: Item) -> None:
        """Change the scope, or forget what can't be told any more."""
        scope = self._state.scope
        name = item.texts['name'].plain if 'name' in item.texts else ''
        if effect in _DECLARATIONS and name in scope.failed:
            return
        try:
            if all(map(self._can_tell, _texts(item))):
                effect(self._state, item)
                return
        except (LaunchError, AlreadyReportedError):
            # the launch will say so
            pass
        if effect in _ENVIRONMENT:
            self._is_environment_unsure = True
        else:
            scope.configurations.pop(name, None)
            scope.failed.add(name)

    def _can_tell(self, text: Text) -> bool:
        unknown = _ONLY_LAUNCHED
        if self._is_environment_unsure:
            unknown |= {'env', 'find-exec'}
        return not any(s.name in unknown for s in _walk(text.template))

    def _include(self, item: Item) -> None:
        position = item.texts['file'].position
        located = self._locate(item.texts['file'])
        if located is None or located[1] in self._open:
            # of a file that includes itself, all arguments are known already
            return
        if located[1].endswith(PYTHON_SUFFIX):
            self._note('it is written in Python', position)
            return
        if len(self._open) >= MAXIMUM_INCLUDE_DEPTH:
            self._note(
                f'more than {MAXIMUM_INCLUDE_DEPTH} launch files include one '
                'another',
                position,
            )
            return
        for argument in ('arg', 'let'):
            for pair in item.items.get(argument, ()):
                self._apply(scope_actions.visit_let, pair)
        try:
            file = self._read(*located)
        except LaunchError as e:
            self._cannot_read(e, position)
        else:
            self._visit_file(file, position)

    def _locate(self, file: Text) -> tuple[str, str] | None:
        """Find the file of an include, or note why it can't be found."""
        try:
            if self._can_tell(file):
                return locate_include(self._state, file)
        except AlreadyReportedError:
            pass
        except LaunchError as e:
            self._note(str(e), file.position)
            return None
        self._note('its path shows only when it is launched', file.position)
        return None

    def _cannot_read(self, problem: LaunchError, position: Position) -> None:
        if not self._is_conditional:
            self._state.report(problem.included_from(position))
            return
        first = problem.diagnostics[0]
        place = '' if first.position is None else f'{first.position}: '
        self._note(f'{place}{first.message}', position)

    def _note(self, message: str, position: Position) -> None:
        self.not_followed.setdefault(position, message)

    def _group(self, entity: Entity) -> None:
        state, item = self._state, entity.item
        outer, was_over = state.scope, self._is_over
        was_conditional = self._is_conditional
        is_scoped = self._flag(item, 'scoped')
        if is_scoped:
            state.scope = _copy(outer)
            if not self._flag(item, 'forwarding'):
                state.scope.reset_configurations()
                state.scope.environment = dict(state.environment)
        for pair in item.items.get('keep', ()):
            self._apply(scope_actions.visit_let, pair)
        self._visit_all(entity.children)
        if is_scoped:
            state.scope = outer
            self._is_over = was_over
            self._is_conditional = was_conditional

    def _timer(self, entity: Entity) -> None:
        outer = self._state.scope
        was_conditional, self._is_conditional = self._is_conditional, True
        self._state.scope = _copy(outer)
        self._visit_all(entity.children)
        self._state.scope = outer
        self._is_conditional = was_conditional
        self._is_over = False

    def _flag(self, item: Item, name: str) -> bool:
        """Return a flag of a group; true when it can't be told."""
        text = item.texts.get(name)
        if text is None or not self._can_tell(text):
            return True
        try:
            return self._state.boolean(item, name, True)
        except (LaunchError, AlreadyReportedError):
            return True


_Effect = Callable[[State, Item], None]
_DECLARATIONS = (scope_actions.visit_arg, scope_actions.visit_bool_arg)
_ENVIRONMENT = (
    scope_actions.visit_set_env,
    scope_actions.visit_unset_env,
    scope_actions.visit_append_env,
)
# what the path of an include may depend on
_EFFECTS: Mapping[str, _Effect] = {
    name: SIMPLE[name]
    for name in (
        *('arg', 'bool_arg', 'let', 'reset'),
        *('set_env', 'unset_env', 'append_env', 'reset_env'),
    )
}


def _is_conditional(entity: Entity) -> bool:
    # a loop may be gone through not even once
    is_loop = entity.action.name in ('for', 'for_each')
    texts = entity.item.texts
    return is_loop or 'if' in texts or 'unless' in texts


def _copy(scope: Scope) -> Scope:
    copy = scope.copy()
    # elsewhere a failed name ends the launch; here it is unknown in its scope
    copy.failed = set(scope.failed)
    return copy


def _forget_differences(scope: Scope, other: Scope) -> None:
    """Forget the launch configurations that the other scope has changed."""
    before, after = scope.configurations, other.configurations
    changed = {n for n in {*before, *after} if before.get(n) != after.get(n)}
    for name in changed | other.failed:
        before.pop(name, None)
        scope.failed.add(name)


def _texts(item: Item) -> Iterator[Text]:
    yield from item.texts.values()
    for items in item.items.values():
        for inner in items:
            yield from _texts(inner)


def _walk(template: Template) -> Iterator[Substitution]:
    for part in template.parts:
        if isinstance(part, Substitution):
            yield part
            for argument in part.arguments:
                yield from _walk(argument)
