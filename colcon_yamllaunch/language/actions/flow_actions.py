# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The actions that have others inside, and those that are of the launch."""

from collections.abc import Iterable, Iterator, Mapping
from typing import TypeVar

from colcon_yamllaunch.language.actions.scope_actions import (
    kept,
    set_configuration,
)
from colcon_yamllaunch.language.evaluation.attributes import Attributes
from colcon_yamllaunch.language.evaluation.scope import ANY_NAME, Guard
from colcon_yamllaunch.language.evaluation.values import unknown, Value
from colcon_yamllaunch.language.evaluation.walk import (
    Handler,
    MAXIMUM_ACTIONS,
    Walk,
)
from colcon_yamllaunch.language.syntax.yaml_reader import (
    load_yaml,
    UnusableYamlError,
)
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
        walk.count_action(attributes)
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


#: What does each action that has others inside.
FLOW_HANDLERS: Mapping[str, Handler] = {
    'group': _group,
    'timer': _timer,
    'ros_timer': _timer,
    'for': _for,
    'for_each': _for_each,
    'include': _include,
}
#: What does each action that shows a line or ends the launch.
MESSAGE_HANDLERS: Mapping[str, Handler] = {
    'log': _log,
    'log_info': _log,
    'log_warning': _log,
    'log_error': _log,
    'log_debug': _log,
    'shutdown': _shutdown,
}
