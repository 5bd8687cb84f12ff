# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The scope of a walk as the messages of the worker have it."""

from collections.abc import Mapping
import os
from typing import Any

from colcon_yamllaunch.language.evaluation.request import WorkerMessage
from colcon_yamllaunch.language.evaluation.scope import (
    known,
    Names,
    UNSET,
    Value,
)
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.vocabulary.parameter import (
    Parameter,
    ParameterContent,
)
from colcon_yamllaunch.plan.position import Span


def scope_as_json(walk: Walk) -> dict[str, Any]:
    """Return the scope of a walk as far as it is known."""
    scope = walk.scope
    variables = scope.environment.all().items()
    return {
        'configurations': {
            name: value.text
            for name, value in scope.configurations.all().items()
            if value.text is not None
        },
        'environment': {
            name: value.text
            for name, value in variables
            if (value is UNSET or value.text is not None)
            and value.text != walk.environment.get(name)
        },
        'namespace': scope.namespace and scope.namespace.text,
        'parameters': [
            {'file': parameter}
            if isinstance(parameter, str)
            else {'name': parameter.name, 'value': parameter.value}
            for parameter in scope.parameters
            if isinstance(parameter, str) or parameter.value is not None
        ],
        'remaps': [list(pair) for pair in scope.remaps],
        'uses_sim_time': scope.uses_sim_time,
        'processes': walk.draft.process_count,
    }


def apply_scope(walk: Walk, said: WorkerMessage, origin: Span) -> None:
    """
    Update the scope of a walk to that of the worker, keeping origins.

    :param said: The whole scope
    :param origin: What has changed it
    """
    scope = walk.scope
    _apply_names(walk, scope.configurations, said['configurations'], origin)
    _apply_environment(walk, said['environment'], origin)
    namespace = said['namespace']
    if (scope.namespace and scope.namespace.text) != namespace:
        scope.namespace = namespace and _changed(walk, namespace, origin)
    scope.parameters = tuple(
        _parameters(walk, said.get('parameters', ()), origin)
    )
    scope.remaps = tuple((str(a), str(b)) for a, b in said.get('remaps', ()))
    scope.uses_sim_time = said.get('uses_sim_time') is True


def content(value: object) -> ParameterContent | None:
    """Return a value of the worker as a parameter value, or None."""
    if isinstance(value, list):
        items = tuple(v for v in value if isinstance(v, _SCALARS))
        return items if len(items) == len(value) else None
    return value if isinstance(value, _SCALARS) else None


_SCALARS = (str, bool, int, float)


def _changed(walk: Walk, text: str, origin: Span) -> Value:
    if walk.is_launch:
        return known(text)._replace(origins=(origin.position,))
    # another launch may come to something else
    source = str(origin.position)
    return Value(text, text, frozenset((source,)))


def _apply_names(
    walk: Walk, names: Names, said: Mapping[str, str], origin: Span
) -> None:
    before = {n: v for n, v in names.all().items() if v.text is not None}
    kept = {n: v for n, v in before.items() if n in said}
    if len(kept) < len(before):
        names.clear()
        for name, value in kept.items():
            names.set(name, value)
    for name, text in said.items():
        if name not in kept or kept[name].text != text:
            names.set(name, _changed(walk, text, origin))


def _apply_environment(
    walk: Walk, said: Mapping[str, str | None], origin: Span
) -> None:
    names = walk.scope.environment
    before = names.all()
    changes = dict(said)
    for name, value in before.items():
        if value is UNSET or value.text is not None:
            # what differs no more is as it was before the launch
            changes.setdefault(name, walk.environment.get(name))
    for name, text in changes.items():
        old = before.get(name)
        current = walk.environment.get(name) if old is None else old.text
        is_unknown = old not in (None, UNSET) and current is None
        if text != current or is_unknown:
            new = UNSET if text is None else _changed(walk, text, origin)
            names.set(name, new)


def _parameters(
    walk: Walk, said: list[WorkerMessage], origin: Span
) -> list[Parameter | str]:
    before = list(walk.scope.parameters)
    found: list[Parameter | str] = []
    for one in said:
        new: Parameter | str
        if 'file' in one:
            new = os.path.join(walk.cwd, str(one['file']))
            walk.file_places.setdefault(new, walk.place_of(origin))
        else:
            value = content(one['value'])
            if value is None:
                continue
            new = Parameter(str(one['name']), value, origin.position)
        old = next((p for p in before if _is_same(p, new)), new)
        found.append(old)
    return found


def _is_same(one: Parameter | str, other: Parameter | str) -> bool:
    if isinstance(one, str) or isinstance(other, str):
        return one == other
    return (one.name, one.value, type(one.value)) == (
        other.name,
        other.value,
        type(other.value),
    )
