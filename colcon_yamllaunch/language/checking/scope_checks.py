# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the actions that change the scope leave to those behind them."""

from collections.abc import Callable
from collections.abc import Mapping
import os

from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.language.checking.attributes import check_pairs
from colcon_yamllaunch.language.checking.check_state import Checking
from colcon_yamllaunch.language.checking.parameter_checks import (
    check_parameter_file,
)
from colcon_yamllaunch.language.checking.parameter_checks import check_value
from colcon_yamllaunch.language.checking.possible_scope import Binding
from colcon_yamllaunch.language.checking.possible_scope import unknown
from colcon_yamllaunch.language.checking.possible_scope import Value
from colcon_yamllaunch.language.checking.possible_values import ANY_VARIABLE
from colcon_yamllaunch.language.evaluation.scope_actions import BOOLEAN_CHOICES
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.ros_names import join_namespace
from colcon_yamllaunch.language.syntax.ros_names import namespace_problem
from colcon_yamllaunch.language.tree.launch_tree import Entity
from colcon_yamllaunch.language.tree.launch_tree import Item

Values = dict[str, Value]


def _set(checking: Checking, name: str | None, binding: Binding) -> None:
    if name is None:
        checking.scope.configurations.is_open = True
    else:
        checking.scope.configurations.own[name] = binding


def set_pair(
    checking: Checking, item: Item, name: Value, value: Value
) -> None:
    """Set a launch configuration as an item of a list says."""
    text = item.texts['value']
    binding = Binding(value, text.position, text.length, checking.includes())
    _set(checking, name.text, binding)


def _arg(checking: Checking, entity: Entity, values: Values) -> None:
    item = entity.item
    name = item.texts['name'].plain
    binding = checking.scope.configurations.get(name)
    if binding is None:
        binding = _default(checking, item, name, values.get('default'))
        _set(checking, name, binding)
    choices = list(BOOLEAN_CHOICES)
    if entity.action.name == 'arg':
        items = item.items.get('choice', ())
        choices = [choice.texts['value'].plain for choice in items]
    given = binding.value.text
    if choices and given is not None and given not in choices:
        problem = Diagnostic(
            'error',
            f"launch argument '{name}' cannot be '{given}'",
            binding.position or item.position,
            did_you_mean(given, choices)
            or f'it is one of {", ".join(choices)}',
            binding.length if binding.position else len('arg'),
            binding.includes,
        )
        checking.state.diagnostics.append(problem)


def _default(
    checking: Checking, item: Item, name: str, default: Value | None
) -> Binding:
    # the user may give another value, even to an included launch file
    source = f'$(var {name})'
    if default is None:
        if not checking.scope.configurations.may_have_others():
            _report_required(checking, name)
        return Binding(unknown(source, {source}))
    text = item.texts['default']
    value = Value(default.text, source, default.sources | {source})
    return Binding(value, text.position, text.length, checking.includes())


def _report_required(checking: Checking, name: str) -> None:
    include = checking.open[-1]
    if include.origin is None or checking.never:
        return
    text = include.origin
    is_certain = include.conditions == checking.conditions
    problem = Diagnostic(
        'error' if is_certain else 'warning',
        f"'{os.path.basename(include.path)}' requires the launch argument "
        f"'{name}', which is not passed",
        text.position,
        f'pass it: arg: [{{name: {name}, value: …}}]',
        text.length,
        checking.includes()[1:],
    )
    checking.state.diagnostics.append(problem)


def _let(checking: Checking, entity: Entity, values: Values) -> None:
    set_pair(checking, entity.item, values['name'], values['value'])


def _reset(checking: Checking, entity: Entity, _: Values) -> None:
    keep = check_pairs(checking, entity.item.items.get('keep', ()))
    checking.scope.reset()
    for pair in keep:
        set_pair(checking, *pair)


def _set_env(checking: Checking, entity: Entity, values: Values) -> None:
    name, value = values['name'].text, values['value']
    if name is None:
        checking.scope.environment.is_open = True
        return
    if not name or '=' in name or '\0' in name + (value.text or ''):
        checking.error(
            f"there can be no environment variable '{name}' with that value",
            entity.item.position,
            length=len(entity.action.name),
        )
    checking.scope.environment.own[name] = Binding(value)


def _change_env(checking: Checking, _: Entity, values: Values) -> None:
    name = values['name'].text
    if name is not None:
        source = f'$(env {name})'
        checking.scope.environment.own[name] = Binding(
            unknown(source, {source})
        )


def _reset_env(checking: Checking, _: Entity, __: Values) -> None:
    checking.scope.environment.clear()


def _push_ros_namespace(
    checking: Checking, entity: Entity, values: Values
) -> None:
    scope, pushed = checking.scope, values['namespace']
    base = scope.namespace
    if pushed.text == '':
        return
    if pushed.text is None:
        scope.namespace = pushed
        return
    outer = base.text if base is not None else None
    namespace = join_namespace(outer, pushed.text)
    problem = namespace_problem(namespace)
    if problem is not None:
        text = entity.item.texts['namespace']
        checking.error(problem, text.position, length=text.length)
    elif base is None or base.text is not None or pushed.text[0] == '/':
        scope.namespace = Value(namespace, namespace)


def _set_parameter(checking: Checking, entity: Entity, values: Values) -> None:
    item = entity.item
    name = values['name'].text
    check_value(checking, item.values['value'], None, infer_text=True)
    checking.scope.parameters |= {ANY_VARIABLE if name is None else name}


def _set_use_sim_time(checking: Checking, _: Entity, __: Values) -> None:
    checking.scope.parameters |= {'use_sim_time'}


def _set_parameters_from_file(
    checking: Checking, entity: Entity, values: Values
) -> None:
    text = entity.item.texts['filename']
    check_parameter_file(checking, text, values['filename'], is_needed=True)


def _set_remap(checking: Checking, _: Entity, values: Values) -> None:
    old = values['from'].text
    if old is not None:
        checking.scope.remaps |= {old}


#: What each action does that changes the scope.
SETTINGS: Mapping[str, Callable[[Checking, Entity, Values], None]] = {
    'arg': _arg,
    'bool_arg': _arg,
    'let': _let,
    'reset': _reset,
    'set_env': _set_env,
    'unset_env': _change_env,
    'append_env': _change_env,
    'reset_env': _reset_env,
    'push_ros_namespace': _push_ros_namespace,
    'set_parameter': _set_parameter,
    'set_parameters_from_file': _set_parameters_from_file,
    'set_remap': _set_remap,
    'set_use_sim_time': _set_use_sim_time,
}
