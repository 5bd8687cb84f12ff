# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The table of what does each action.

Actions that run processes or load components have modules of their own; the
others are here: they change the scope, have actions inside or print a line.
"""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
import os
from typing import TypeVar

from colcon_yamllaunch.language.actions.node_names import inner_namespace
from colcon_yamllaunch.language.actions.parameters import parameter_value
from colcon_yamllaunch.language.actions.process_actions import (
    PROCESS_HANDLERS,
    set_variable,
)
from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.budget import MAXIMUM_ACTIONS
from colcon_yamllaunch.language.evaluation.scope import (
    AlreadyReportedError,
    ANY_NAME,
    Guard,
    known,
    unknown,
    UNSET,
    Value,
)
from colcon_yamllaunch.language.evaluation.walk import Handler, Walk
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.yaml_reader import (
    load_yaml,
    UnusableYamlError,
)
from colcon_yamllaunch.language.vocabulary.parameter import Parameter
from colcon_yamllaunch.plan.plan import Message, Shutdown, Timer

_T = TypeVar('_T')

_MANY_ROUNDS = (
    f'a loop has no more rounds than a launch has actions: {MAXIMUM_ACTIONS}'
)
_LEVELS = {
    'DEBUG': 'DEBUG',
    'INFO': 'INFO',
    'WARN': 'WARNING',
    'WARNING': 'WARNING',
    'ERROR': 'ERROR',
    'FATAL': 'CRITICAL',
    'CRITICAL': 'CRITICAL',
    'NOTSET': 'DEBUG',
}
#: The values of a `bool_arg`, as ROS 2 lists them.
BOOLEAN_CHOICES: tuple[str, ...] = (
    'true',
    'false',
    'True',
    'False',
    'TRUE',
    'FALSE',
)


def _arg(walk: Walk, attributes: Attributes) -> None:
    name, choices = attributes.plain('name'), BOOLEAN_CHOICES
    if attributes.name == 'arg':
        items = attributes.items('choice')
        choices = tuple(choice.plain('value') for choice in items)
    walk.declare(attributes, name, choices)
    value = walk.scope.configurations.get(name)
    if value is None:
        value = _default(walk, attributes, name)
    is_wrong = value.text is not None and value.text not in choices
    if choices and is_wrong and not walk.is_left_open(value):
        walk.fail_choice(name, value, choices, attributes)


def _default(walk: Walk, attributes: Attributes, name: str) -> Value:
    source = f'$(var {name})'
    with _setting(walk, name):
        default = attributes.value('default')
        if default is None:
            walk.missing_argument(attributes, name)
            value = unknown(source)
        else:
            # the user may give another value, even to an included launch file
            value = walk.configuration(
                walk.default(default, source),
                attributes.position,
                attributes.item.texts['default'],
            )
    walk.scope.configurations.set(name, value)
    return value


@contextmanager
def _setting(walk: Walk, name: str | None) -> Iterator[None]:
    """Make a name unknown if its value cannot be evaluated."""
    try:
        yield
    except (LaunchError, AlreadyReportedError):
        walk.scope.configurations.set(name, unknown(f'$(var {name})'))
        raise


def set_configuration(walk: Walk, pair: Attributes) -> None:
    """Set a launch configuration, as a `let` and items of lists do."""
    name = pair.text('name')
    with _setting(walk, name):
        value = evaluated(walk, pair)
    if name in walk.given:
        walk.overwrite(name, pair.item.texts['name'])
    walk.scope.configurations.set(name, value)


def evaluated(walk: Walk, pair: Attributes) -> Value:
    """Return the value that a `let` or an item of a list gives a name."""
    value = pair.required('value')
    return walk.configuration(value, pair.position, pair.item.texts['value'])


def kept(
    walk: Walk, attributes: Attributes
) -> Iterable[tuple[str | None, Value]]:
    """Return the names and values that an action keeps, evaluated now."""
    return [
        (pair.text('name'), evaluated(walk, pair))
        for pair in attributes.items('keep')
    ]


def _reset(walk: Walk, attributes: Attributes) -> None:
    keep = kept(walk, attributes)
    walk.scope.reset()
    for name, value in keep:
        walk.scope.configurations.set(name, value)


def _set_env(walk: Walk, attributes: Attributes) -> None:
    name, value = attributes.text('name'), attributes.required('value')
    set_variable(walk.scope.environment, attributes, name, value)


def _unset_env(walk: Walk, attributes: Attributes) -> None:
    walk.scope.environment.set(attributes.text('name'), UNSET)


def _append_env(walk: Walk, attributes: Attributes) -> None:
    name, value = attributes.text('name'), attributes.required('value')
    separator = attributes.text('separator')
    is_prepended = attributes.boolean('prepend')
    if name is None:
        walk.scope.environment.is_open = True
        return
    before = walk.variable(name)
    if not walk.has_environment or separator is None or is_prepended is None:
        value = unknown(f'$(env {name})')
    elif before is not None:
        values = [before, known(separator), value]
        value = walk.budget.join(
            values[::-1] if is_prepended else values,
            lambda: attributes.position,
        )
    set_variable(walk.scope.environment, attributes, name, value)


def _reset_env(walk: Walk, _attributes: Attributes) -> None:
    walk.scope.environment.clear()


def _push_ros_namespace(walk: Walk, attributes: Attributes) -> None:
    pushed = attributes.required('namespace')
    walk.scope.namespace = inner_namespace(walk, attributes, pushed)


def _set_parameter(walk: Walk, attributes: Attributes) -> None:
    name = attributes.text('name')
    written = attributes.item.values['value']
    value, origins = parameter_value(walk, written, None, infer_text=True)
    parameter = Parameter(name or ANY_NAME, value, written.position, origins)
    walk.scope.parameters += (parameter,)


def _set_parameters_from_file(walk: Walk, attributes: Attributes) -> None:
    written = attributes.text('filename')
    if written is None:
        return
    path = os.path.join(walk.cwd, written)
    if walk.parameter_file(path) is None:
        from colcon_yamllaunch.language.actions.parameter_files import (
            missing_file,
        )

        missing_file(walk, attributes, 'filename', path)
    place = walk.place_of(attributes.item.texts['filename'])
    walk.file_places.setdefault(path, place)
    walk.scope.parameters += (path,)


def _set_remap(walk: Walk, attributes: Attributes) -> None:
    old, new = attributes.text('from'), attributes.text('to')
    if old is not None:
        walk.scope.remaps += ((old, new or ''),)


def _set_use_sim_time(walk: Walk, attributes: Attributes) -> None:
    value = attributes.boolean('value')
    at, origins = attributes.position, attributes.required('value').origins
    walk.scope.parameters += (Parameter('use_sim_time', value, at, origins),)
    walk.scope.uses_sim_time = value is True


def _set_ros_log_dir(walk: Walk, attributes: Attributes) -> None:
    folder = attributes.text('new_log_dir')
    current = walk.variable('ROS_LOG_DIR')
    base = walk.log_folder if current is None else current.text
    if folder is None or (base is None and not os.path.isabs(folder)):
        walk.scope.environment.set('ROS_LOG_DIR', unknown('$(log_dir)'))
        return
    path = os.path.join(base or '', folder)
    if not os.path.isabs(path):
        attributes.fail(
            'new_log_dir', f"the log folder '{path}' is not an absolute path"
        )
    variables = walk.scope.environment
    set_variable(variables, attributes, 'ROS_LOG_DIR', known(path))


def _group(walk: Walk, attributes: Attributes) -> None:
    with walk.draft.within_block('group', '', attributes.position):
        keep = kept(walk, attributes)
        is_scoped = attributes.boolean('scoped')
        outer = walk.scope
        inner = outer if is_scoped is False else outer.inner()
        if is_scoped and attributes.boolean('forwarding') is False:
            inner = outer.without_outer()
        with walk.within_scope(inner):
            for name, value in keep:
                inner.configurations.set(name, value)
            walk.visit_all(attributes.children)
        if is_scoped is None:
            value = attributes.required('scoped')
            outer.merge(inner, Guard(value.key, False, value.sources, None))
        namespace = inner.namespace
        if namespace != outer.namespace and namespace is not None:
            walk.draft.name_block(f'namespace {namespace.text}')


def _timer(walk: Walk, attributes: Attributes) -> None:
    period = attributes.seconds('period')
    is_cancelled = attributes.boolean('cancel_on_shutdown')
    title = f'{period or 0:g} s'
    with (
        walk.draft.collect() as entries,
        walk.draft.within_block('timer', title, attributes.position),
    ):
        walk.visit_later(attributes.children)
    timer = Timer(
        period or 0.0,
        tuple(entries),
        is_cancelled is not False,
        # without simulated time, that of ROS is the system's
        attributes.name == 'ros_timer' and walk.scope.uses_sim_time,
    )
    walk.draft.entries.append(timer)


def _for(walk: Walk, attributes: Attributes) -> None:
    name = attributes.plain('name')
    count, length = attributes.whole('len'), attributes.required('len')
    if count is not None and count > MAXIMUM_ACTIONS:
        attributes.fail('len', _MANY_ROUNDS)
        count = 0
    rounds = (
        {name: Value(str(index), str(index), length.sources)}
        for index in _counted(walk, attributes, range(count or 0))
    )
    otherwise = {name: unknown(f'$(index {name})', (name,))}
    walk.visit_rounds(attributes.children, rounds, otherwise)


def _for_each(walk: Walk, attributes: Attributes) -> None:
    text = attributes.item.texts['values']
    value = attributes.required('values')
    values = value.text or ''
    if values.count(';') > MAXIMUM_ACTIONS:
        attributes.fail('values', _MANY_ROUNDS)
        values = ''
    pieces = values.split(';') if values.strip() else []
    if value.is_sure and not pieces:
        walk.warn("'for_each' has no values", text)
    rounds = (
        {
            name: Value(word, word, value.sources)
            for name, word in variables.items()
        }
        for piece in _counted(walk, attributes, pieces)
        if (variables := _loop_variables(attributes, piece)) is not None
    )
    otherwise = {ANY_NAME: unknown(value.key, value.sources)}
    walk.visit_rounds(attributes.children, rounds, otherwise)


def _counted(
    walk: Walk, attributes: Attributes, rounds: Iterable[_T]
) -> Iterator[_T]:
    """Go through the rounds of a loop, which may have no actions."""
    for one in rounds:
        walk.budget.count_action(attributes.position)
        yield one


def _loop_variables(
    attributes: Attributes, piece: str
) -> dict[str, str] | None:
    try:
        loaded = load_yaml(piece)
    except UnusableYamlError:
        loaded = None
    if not isinstance(loaded, dict):
        attributes.fail(
            'values',
            f"'{piece.strip()}' is no YAML mapping of names to values",
            "write '{name: value}' for each, with ';' between",
        )
        return None
    return {str(name): str(value) for name, value in loaded.items()}


def _include(walk: Walk, attributes: Attributes) -> None:
    located = walk.locate(attributes)
    for argument in ('arg', 'let'):
        for pair in attributes.items(argument):
            set_configuration(walk, pair)
    walk.follow(attributes, located)


def _log(walk: Walk, attributes: Attributes) -> None:
    # the others have their level in their name
    level = attributes.name.removeprefix('log_')
    if level == 'log':
        level = attributes.text('level') or ''
    message = attributes.text('message') or ''
    walk.draft.entries.append(Message(_LEVELS.get(level.upper(), ''), message))


def _shutdown(walk: Walk, attributes: Attributes) -> None:
    walk.draft.entries.append(Shutdown(attributes.text('reason') or ''))


def _do_component_action(walk: Walk, attributes: Attributes) -> None:
    # a launch without components does not import what loads them
    from colcon_yamllaunch.language.actions.component_actions import (
        COMPONENT_HANDLERS,
    )

    COMPONENT_HANDLERS[attributes.name](walk, attributes)


# what does each action that no other depends on
_PASSIVE_HANDLERS: Mapping[str, Handler] = {
    **PROCESS_HANDLERS,
    'log': _log,
    'log_info': _log,
    'log_warning': _log,
    'log_error': _log,
    'log_debug': _log,
    'shutdown': _shutdown,
    'node_container': _do_component_action,
    'load_composable_node': _do_component_action,
    'composable_node': _do_component_action,
    'composable_lifecycle_node': _do_component_action,
}
#: What does each action, whatever the policy of the walk.
HANDLERS: Mapping[str, Handler] = {
    **_PASSIVE_HANDLERS,
    'arg': _arg,
    'bool_arg': _arg,
    'let': set_configuration,
    'reset': _reset,
    'set_env': _set_env,
    'unset_env': _unset_env,
    'append_env': _append_env,
    'reset_env': _reset_env,
    'push_ros_namespace': _push_ros_namespace,
    'set_parameter': _set_parameter,
    'set_parameters_from_file': _set_parameters_from_file,
    'set_remap': _set_remap,
    'set_use_sim_time': _set_use_sim_time,
    'set_ros_log_dir': _set_ros_log_dir,
    'group': _group,
    'timer': _timer,
    'ros_timer': _timer,
    'for': _for,
    'for_each': _for_each,
    'include': _include,
}
#: The actions that no other depends on.
PASSIVE = frozenset(_PASSIVE_HANDLERS)
