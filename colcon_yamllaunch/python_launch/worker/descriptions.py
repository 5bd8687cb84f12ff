# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What objects of `launch` are: by class, as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterable
import math
from typing import Any


def is_a(thing: Any, *kinds: str) -> bool:
    """Say whether something is of a class of ROS 2, by the names of these."""
    return any(cls.__name__ in kinds for cls in type(thing).__mro__)


def as_written(substitutions: Any) -> str:
    """Return substitutions as a launch file in YAML would write them."""
    if isinstance(substitutions, str):
        return substitutions
    if not isinstance(substitutions, Iterable):
        substitutions = [substitutions]
    return ''.join(_one(substitution) for substitution in substitutions)


def _one(substitution: Any) -> str:
    if isinstance(substitution, str):
        return substitution
    kind = type(substitution).__name__
    if kind == 'TextSubstitution':
        return str(substitution.text)
    if kind == 'LaunchConfiguration':
        return f'$(var {as_written(substitution.variable_name)})'
    if kind == 'EnvironmentVariable':
        return f'$(env {as_written(substitution.name)})'
    if kind == 'PythonExpression':
        return f"$(eval '{as_written(substitution.expression)}')"
    if kind in ('FindPackageShare', 'FindPackage'):
        return f'$(find-pkg-share {as_written(substitution.package)})'
    if kind in ('ThisLaunchFile', 'ThisLaunchFileDir'):
        return '$(filename)' if kind == 'ThisLaunchFile' else '$(dirname)'
    if kind == 'PathJoinSubstitution':
        return '/'.join(
            as_written(part) for part in substitution.substitutions
        )
    if kind == 'NotSubstitution':
        return f'$(not {as_written(substitution.value)})'
    left = getattr(substitution, 'left', None)
    if left is not None and hasattr(substitution, 'right'):
        name = kind.replace('Substitution', '').lower()
        return f'$({name} {as_written(left)} {as_written(substitution.right)})'
    try:
        return str(substitution.describe())
    except Exception:  # noqa: BLE001 - it may be anyone's
        return f'$({kind})'


def condition_text(condition: Any) -> str:
    """Return a condition as a launch file in YAML would write it."""
    kind = type(condition).__name__
    word = 'unless' if kind == 'UnlessCondition' else 'if'
    for cls in type(condition).__mro__:
        start = f'_{cls.__name__}__'
        expression = getattr(condition, f'{start}predicate_expression', None)
        if expression is not None:
            return f'{word}: {as_written(expression)}'
        left = getattr(condition, f'{start}launch_configuration_name', None)
        if left is not None:
            value = getattr(condition, f'{start}expected_value', None)
            sign = '!=' if 'Not' in kind else '=='
            return f'if: $(var {left}) {sign} {as_written(value or "")}'
    return f'if: {kind}'


def as_json(value: Any) -> Any:
    """Return the value of a parameter as JSON has it, `.inf` for infinity."""
    if isinstance(value, bool):
        return value
    if isinstance(value, float):
        if math.isnan(value):
            return '.nan'
        if math.isinf(value):
            return '.inf' if value > 0 else '-.inf'
        return value
    if isinstance(value, (str, int)) or value is None:
        return value
    if isinstance(value, (bytes, bytearray)):
        return list(value)
    if hasattr(value, 'tolist'):
        return as_json(value.tolist())
    if isinstance(value, dict):
        return {str(name): as_json(one) for name, one in value.items()}
    if isinstance(value, Iterable):
        return [as_json(one) for one in value]
    return str(value)
