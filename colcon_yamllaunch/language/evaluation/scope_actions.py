# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The actions that change the scope or show a line."""

import os

from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.language.evaluation.evaluation_state import State
from colcon_yamllaunch.language.evaluation.node_parameters import (
    evaluate_value,
)
from colcon_yamllaunch.language.plan.plan import Message
from colcon_yamllaunch.language.plan.plan import Shutdown
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.position import Position
from colcon_yamllaunch.language.syntax.ros_names import join_namespace
from colcon_yamllaunch.language.syntax.ros_names import namespace_problem
from colcon_yamllaunch.language.tree.launch_tree import Item
from colcon_yamllaunch.language.vocabulary.parameter_value import Parameter
from colcon_yamllaunch.language.vocabulary.substitutions import (
    AlreadyReportedError,
)

#: The values of a `bool_arg`, as ROS 2 lists them.
BOOLEAN_CHOICES = ('true', 'false', 'True', 'False', 'TRUE', 'FALSE')

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


def visit_arg(state: State, item: Item) -> None:
    """Declare a launch argument."""
    choices = [
        choice.texts['value'].plain for choice in item.items.get('choice', ())
    ]
    _declare(state, item, choices)


def visit_bool_arg(state: State, item: Item) -> None:
    """Declare a launch argument that is true or false."""
    _declare(state, item, list(BOOLEAN_CHOICES))


def _declare(state: State, item: Item, choices: list[str]) -> None:
    name = item.texts['name'].plain
    scope = state.scope
    state.declared.add(name)
    if name not in scope.configurations:
        try:
            value = _default(state, item, name)
            set_configuration(state, name, value, item.position)
        except (LaunchError, AlreadyReportedError):
            scope.failed.add(name)
            raise
    value = scope.configurations[name]
    if choices and value not in choices:
        raise error(
            f"launch argument '{name}' cannot be '{value}'",
            item.position,
            hint=did_you_mean(value, choices)
            or f'it is one of {", ".join(choices)}',
            length=len('arg'),
        )


def _default(state: State, item: Item, name: str) -> str:
    default = item.texts.get('default')
    if default is not None:
        return default.evaluate(state)
    given = f'{name}:=…'
    if state.depth > 1:
        given = f"arg: [{{name: {name}, value: …}}] in the 'include'"
    raise error(
        f"launch argument '{name}' is required, and was not given",
        item.position,
        hint=f'give it: {given}',
        length=len('arg'),
    )


def visit_let(state: State, item: Item) -> None:
    """Set a launch configuration."""
    name = state.text(item, 'name')
    try:
        value = state.text(item, 'value')
        set_configuration(state, name, value, item.position)
    except (LaunchError, AlreadyReportedError):
        state.scope.failed.add(name)
        state.scope.configurations.pop(name, None)
        raise


def set_configuration(
    state: State, name: str, value: str, position: Position
) -> None:
    """
    Set a launch configuration in the scope.

    Must be called right after the value was evaluated: what it was made of is
    remembered with it.

    :param position: Where it is set
    """
    state.scope.configurations[name] = value
    state.scope.origins[name] = (position, *state.origins)
    state.scope.failed.discard(name)


def visit_reset(state: State, item: Item) -> None:
    """Forget all launch configurations but some."""
    keep = state.pairs(item, 'keep')
    state.scope.reset_configurations()
    state.scope.configurations.update(keep)


def visit_set_env(state: State, item: Item) -> None:
    """Set an environment variable."""
    set_variable(
        state, item, state.text(item, 'name'), state.text(item, 'value')
    )


def set_variable(state: State, item: Item, name: str, value: str) -> None:
    """
    Set an environment variable.

    :raises LaunchError: if a process cannot have such a variable (POSIX)
    """
    check_variable(item, name, value)
    state.scope.environment[name] = value


def check_variable(item: Item, name: str, value: str) -> None:
    """
    Check that a process can have an environment variable.

    :raises LaunchError: if it cannot (POSIX)
    """
    if not name or '=' in name or '\0' in name + value:
        raise error(
            f"there can be no environment variable '{name}' with that value",
            item.position,
        )


def visit_unset_env(state: State, item: Item) -> None:
    """Unset an environment variable."""
    state.scope.environment.pop(state.text(item, 'name'), None)


def visit_append_env(state: State, item: Item) -> None:
    """Append to an environment variable, or put something in front."""
    name = state.text(item, 'name')
    value = state.text(item, 'value')
    separator = state.text(item, 'separator', os.pathsep)
    before = state.scope.environment.get(name)
    if before is not None:
        parts = [before, value]
        if state.boolean(item, 'prepend', False):
            parts.reverse()
        value = separator.join(parts)
    set_variable(state, item, name, value)


def visit_reset_env(state: State, _item: Item) -> None:
    """Undo all changes to the environment."""
    state.scope.environment = dict(state.environment)


def visit_log(state: State, item: Item) -> None:
    """Show a line."""
    level = state.text(item, 'level', 'INFO').upper()
    if level not in _LEVELS:
        raise error(
            f"there is no log level '{level}'",
            item.texts['level'].position,
            hint=did_you_mean(level, _LEVELS)
            or f'it is one of {", ".join(_LEVELS)}',
        )
    _log(state, item, _LEVELS[level])


def visit_log_info(state: State, item: Item) -> None:
    """Show a line."""
    _log(state, item, 'INFO')


def visit_log_warning(state: State, item: Item) -> None:
    """Show a warning."""
    _log(state, item, 'WARNING')


def visit_log_error(state: State, item: Item) -> None:
    """Show an error."""
    _log(state, item, 'ERROR')


def visit_log_debug(state: State, item: Item) -> None:
    """Show a line for debugging."""
    _log(state, item, 'DEBUG')


def _log(state: State, item: Item, level: str) -> None:
    state.entries.append(Message(level, state.text(item, 'message')))


def visit_shutdown(state: State, item: Item) -> None:
    """End the launch."""
    state.entries.append(Shutdown(state.text(item, 'reason')))


def visit_push_ros_namespace(state: State, item: Item) -> None:
    """Put the nodes that follow into a namespace."""
    pushed = state.text(item, 'namespace')
    if not pushed:
        return
    namespace = join_namespace(state.scope.namespace, pushed)
    problem = namespace_problem(namespace)
    if problem is not None:
        text = item.texts['namespace']
        raise error(problem, text.position, length=text.length)
    state.scope.namespace = namespace


def visit_set_parameter(state: State, item: Item) -> None:
    """Set a parameter of the nodes that follow."""
    name = state.text(item, 'name')
    value = evaluate_value(state, item.values['value'], None, infer_text=True)
    parameter = Parameter(name, value, item.position, state.origins)
    state.scope.parameters += (parameter,)


def visit_set_parameters_from_file(state: State, item: Item) -> None:
    """Set parameters of the nodes that follow from a file."""
    path = os.path.join(state.cwd, state.text(item, 'filename'))
    if not os.path.isfile(path):
        text = item.texts['filename']
        raise error(
            f"the parameter file '{path}' does not exist",
            text.position,
            hint=did_you_mean(path, state.packages.similar(path)),
            length=text.length,
            may_pass_after_build=state.packages.may_appear(path),
        )
    state.scope.parameters += (path,)


def visit_set_remap(state: State, item: Item) -> None:
    """Remap a name in the nodes that follow."""
    pair = (state.text(item, 'from'), state.text(item, 'to'))
    state.scope.remaps += (pair,)


def visit_set_use_sim_time(state: State, item: Item) -> None:
    """Set use_sim_time of the nodes that follow."""
    value = state.boolean(item, 'value', False)
    parameter = Parameter('use_sim_time', value, item.position, state.origins)
    state.scope.parameters += (parameter,)


def visit_set_ros_log_dir(state: State, item: Item) -> None:
    """Set the folder for the logs of the nodes that follow."""
    current = state.scope.environment.get('ROS_LOG_DIR', state.log_folder)
    path = os.path.join(current, state.text(item, 'new_log_dir'))
    if not os.path.isabs(path):
        text = item.texts['new_log_dir']
        raise error(
            f"the log folder '{path}' is not an absolute path",
            text.position,
            length=text.length,
        )
    set_variable(state, item, 'ROS_LOG_DIR', path)
