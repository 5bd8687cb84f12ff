# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a client is asked to load, made of a component of a plan."""

from collections.abc import Iterable
import json
import math
import re
from typing import Any

from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import SetParameter

# texts, and the numbers that JSON has no words for
_TOKENS = re.compile(r'"(?:[^"\\]|\\.)*"|-?\.inf|\.nan')
_WORDS = {'.inf': 'Infinity', '-.inf': '-Infinity', '.nan': 'NaN'}


def load_request(component: Component) -> dict[str, Any]:
    """
    Return what a client is asked to load, see `ros_client`.

    :raises ValueError: when the value of a parameter cannot be read
    """
    return {
        'container': component.container,
        'package': component.package,
        'plugin': component.plugin,
        'name': component.name,
        'namespace': component.namespace,
        'remaps': list(component.remaps),
        'parameters': _values(component.parameters),
        'extra_arguments': _values(component.extra_arguments),
    }


def _values(parameters: Iterable[SetParameter]) -> list[list[Any]]:
    # the last of several with one name counts
    return [[n, v] for n, v in {p.name: _value(p) for p in parameters}.items()]


def _value(parameter: SetParameter) -> Any:
    text = _TOKENS.sub(
        lambda found: _WORDS.get(found[0], found[0]), parameter.value
    )
    try:
        return _sendable(json.loads(text))
    except (ValueError, RecursionError) as error:
        raise ValueError(
            f"the value of its parameter '{parameter.name}' is no JSON: "
            f'{parameter.value}'
        ) from error


def _sendable(value: Any) -> Any:
    if isinstance(value, list):
        return [_sendable(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        name = 'nan' if math.isnan(value) else 'inf' if value > 0 else '-inf'
        return {'double': name}
    return value
