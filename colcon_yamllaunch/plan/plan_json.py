# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Plans as JSON and back.

The JSON has the fields of the plan's classes under their names, in their
order. Where several classes may stand, `type` tells which: `process`,
`component`, `message`, `shutdown`, `timer`, `change_state`, `signal`, `call`,
or `parameter_file` among the arguments. The environment is an object with null
for a variable that is unset.
"""

from collections import Counter
import dataclasses
import json
import math
import re
import types
import typing
from typing import Any

from colcon_yamllaunch.plan import plan as plan_module
from colcon_yamllaunch.plan.plan import ChangeState
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import HostCall
from colcon_yamllaunch.plan.plan import Message
from colcon_yamllaunch.plan.plan import ParameterFile
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.plan import Shutdown
from colcon_yamllaunch.plan.plan import SignalProcess
from colcon_yamllaunch.plan.plan import Timer

#: How many values and separators the JSON of a plan may have: a process takes
#: some thirty.
MAXIMUM_VALUES = 2_000_000

#: The version of the format; it changes when a reader of the old one would
#: misunderstand the new one.
VERSION = 1

_TAGGED: dict[type, str] = {
    ChangeState: 'change_state',
    Component: 'component',
    HostCall: 'call',
    Message: 'message',
    ParameterFile: 'parameter_file',
    Process: 'process',
    Shutdown: 'shutdown',
    SignalProcess: 'signal',
    Timer: 'timer',
}
_ENVIRONMENT = 'environment'


class PlanFormatError(Exception):
    """A text is no plan; the message says why."""


def plan_to_json(plan: Plan) -> str:
    """Return a plan as JSON."""
    data = {'version': VERSION, **_encode(plan)}
    return json.dumps(data, indent=2, ensure_ascii=False)


def plan_from_json(text: str) -> Plan:
    """
    Return the plan that JSON tells of.

    :raises PlanFormatError: when it tells of none
    """
    if sum(map(text.count, '[{,')) > MAXIMUM_VALUES:
        raise PlanFormatError(f'it has more than {MAXIMUM_VALUES} values')
    try:
        data = json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as e:
        raise PlanFormatError(f'it is not JSON: {e}') from e
    if not isinstance(data, dict) or 'version' not in data:
        raise PlanFormatError("it has no 'version'")
    if data['version'] != VERSION:
        raise PlanFormatError(
            f'its version is {data["version"]}, but only {VERSION} is known'
        )
    fields = {name: data[name] for name in data if name != 'version'}
    plan: Plan = _decode(Plan, fields, 'plan')
    _check_labels(plan)
    return plan


def _check_labels(plan: Plan) -> None:
    labels = [process.label for process in plan.processes()]
    labels += [component.label for component in plan.components()]
    for label, count in Counter(labels).items():
        if count > 1:
            raise PlanFormatError(
                f"{count} processes or components have the label '{label}': "
                'give each one of its own'
            )


def _encode(value: Any) -> Any:
    if dataclasses.is_dataclass(value):
        tag = _TAGGED.get(type(value))
        data: dict[str, Any] = {} if tag is None else {'type': tag}
        for field in dataclasses.fields(value):
            content = getattr(value, field.name)
            data[field.name] = (
                dict(content)
                if field.name == _ENVIRONMENT
                else _encode(content)
            )
        return data
    if isinstance(value, tuple):
        return [_encode(item) for item in value]
    return value


def _decode(hint: Any, data: Any, where: str) -> Any:
    if dataclasses.is_dataclass(hint):
        return _decode_object(hint, data, where)
    origin = typing.get_origin(hint)
    if origin in (typing.Union, types.UnionType):
        return _decode_one_of(typing.get_args(hint), data, where)
    if origin is tuple:
        if not isinstance(data, list):
            raise PlanFormatError(f'{where} is not a list')
        element = typing.get_args(hint)[0]
        return tuple(
            _decode(element, item, f'{where}[{index}]')
            for index, item in enumerate(data)
        )
    if hint is float:
        return _decode_seconds(data, where)
    if type(data) is not hint:
        raise PlanFormatError(f'{where} is not of the type {hint.__name__}')
    return data


def _refuse_constant(name: str) -> None:
    # JSON has none of them (RFC 8259, 6)
    raise ValueError(f'{name} is no number')


def _decode_seconds(data: Any, where: str) -> float:
    if type(data) not in (int, float):
        raise PlanFormatError(f'{where} is not of the type float')
    try:
        seconds = float(data)
    except OverflowError:
        seconds = math.inf
    if not 0 <= seconds < math.inf:
        raise PlanFormatError(f'{where} is no time that can be waited for')
    return seconds


def _decode_object(hint: Any, data: Any, where: str) -> Any:
    if not isinstance(data, dict):
        raise PlanFormatError(f'{where} is not an object')
    hints = typing.get_type_hints(hint, vars(plan_module))
    fields = {field.name: field for field in dataclasses.fields(hint)}
    unknown = sorted(data.keys() - fields.keys() - {'type'})
    if unknown:
        raise PlanFormatError(f"{where} has an unknown field '{unknown[0]}'")
    values = {}
    for name, field in fields.items():
        inner = f'{where}.{name}'
        if name in data:
            content = data[name]
            values[name] = (
                _decode_environment(content, inner)
                if name == _ENVIRONMENT
                else _decode(hints[name], content, inner)
            )
        elif field.default is dataclasses.MISSING:
            raise PlanFormatError(f'{inner} is missing')
    return hint(**values)


def _decode_environment(
    data: Any, where: str
) -> tuple[tuple[str, str | None], ...]:
    if not isinstance(data, dict):
        raise PlanFormatError(f'{where} is not an object')
    return tuple(
        (name, _decode(str | None, value, f'{where}.{name}'))
        for name, value in sorted(data.items())
    )


def _decode_one_of(hints: tuple[Any, ...], data: Any, where: str) -> Any:
    if data is None and type(None) in hints:
        return None
    tag = data.get('type') if isinstance(data, dict) else None
    for hint in hints:
        if hint in _TAGGED:
            if tag == _TAGGED[hint]:
                return _decode(hint, data, where)
        elif isinstance(data, hint) and hint is not type(None):
            return data
    names = ' or '.join(_name(h) for h in hints if h is not type(None))
    raise PlanFormatError(f'{where} is not {names}')


def _name(hint: Any) -> str:
    words = re.sub('(?<!^)([A-Z])', r' \1', hint.__name__).lower()
    return f'a {words}'
