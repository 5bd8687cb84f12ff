# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The actions that change the scope."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
import os
import re

from colcon_yamllaunch.language.actions.node_parameters import parameter_value
from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.scope import ANY_NAME, Names
from colcon_yamllaunch.language.evaluation.values import (
    AlreadyReportedError,
    known,
    unknown,
    UNSET,
    Value,
)
from colcon_yamllaunch.language.evaluation.walk import Handler, Walk
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.vocabulary.parameter import Parameter

_NODE_NAME = re.compile(r'[A-Za-z_][A-Za-z0-9_]*')
_NAMESPACE = re.compile(r'/|(/[A-Za-z_~{}][A-Za-z0-9_~{}]*)+')


def node_name_problem(name: str) -> str | None:
    """Return why no node can have a name, or None if one can."""
    if _NODE_NAME.fullmatch(name):
        return None
    return (
        f"the node name '{name}' may only have letters, digits and "
        'underscores, and cannot be empty or start with a digit'
    )


def namespace_problem(namespace: str) -> str | None:
    """Return why a text is no absolute namespace, or None if it is one."""
    if _NAMESPACE.fullmatch(namespace):
        return None
    return (
        f"the namespace '{namespace}' may only have letters, digits, "
        'underscores and slashes, and none of its parts can be empty or start '
        'with a digit'
    )


def join_namespace(base: str | None, namespace: str) -> str:
    """
    Return the namespace that results from one within another.

    :param base: The outer namespace, absolute, if there is one
    :param namespace: The inner one; an absolute one replaces the outer one
    """
    if not namespace.startswith('/'):
        namespace = f'{(base or "").rstrip("/")}/{namespace}'
    return namespace.rstrip('/') or '/'


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


def set_variable(
    variables: Names, attributes: Attributes, name: str | None, value: Value
) -> None:
    """Set an environment variable if a process can have it (POSIX)."""
    if name is not None and (
        not name or '=' in name or '\0' in name + (value.text or '')
    ):
        attributes.fail_as_whole(
            f"there can be no environment variable '{name}' with that value"
        )
    variables.set(name, value)


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
        value = walk.join(
            values[::-1] if is_prepended else values,
            lambda: attributes.position,
        )
    set_variable(walk.scope.environment, attributes, name, value)


def _reset_env(walk: Walk, _attributes: Attributes) -> None:
    walk.scope.environment.clear()


def _push_ros_namespace(walk: Walk, attributes: Attributes) -> None:
    pushed = attributes.required('namespace')
    walk.scope.namespace = inner_namespace(walk, attributes, pushed)


def inner_namespace(
    walk: Walk, attributes: Attributes, inner: Value
) -> Value | None:
    """
    Return a namespace within that of the scope.

    :param attributes: Those with the inner one as `namespace`
    """
    outer = walk.scope.namespace
    if inner.text is None:
        return inner
    base = None if outer is None else outer.text
    namespace = join_namespace(base, inner.text)
    problem = namespace_problem(namespace)
    if problem is not None:
        attributes.fail('namespace', problem)
        return inner.forgotten()
    if outer is not None and base is None and inner.text[:1] != '/':
        return outer
    return known(namespace)


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


#: What does each action that changes the scope.
SCOPE_HANDLERS: Mapping[str, Handler] = {
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
}
