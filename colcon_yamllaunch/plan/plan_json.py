# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Plans as JSON and back.

The JSON has the fields of the plan's classes under their names, in their
order. Where several classes may stand, `type` tells which: `process`,
`component`, `message`, `shutdown`, `timer`, `after_ready`, `change_state`,
`signal`, `call`, or `parameter_file` among the arguments. The environment is
an object with null for a variable that is unset.
"""

from collections import Counter
import json
from typing import Any

from colcon_yamllaunch.common.codec import (
    Codec,
    CodecError,
    from_json,
    only,
    Read,
    read_float,
    Write,
)
from colcon_yamllaunch.plan.plan import (
    AfterReady,
    ChangeState,
    Component,
    Message,
    ParameterFile,
    Plan,
    Process,
    Shutdown,
    SignalProcess,
    Timer,
    Variables,
    WorkerCall,
)

#: How many values and separators the JSON of a plan may have: a process takes
#: some thirty.
MAXIMUM_VALUES = 2_000_000

#: The version of the format; it changes when a reader of the old one would
#: misunderstand the new one.
VERSION = 1

#: The names of the classes that a plan consists of.
TAGS: dict[type, str] = {
    AfterReady: 'after_ready',
    ChangeState: 'change_state',
    Component: 'component',
    WorkerCall: 'call',
    Message: 'message',
    ParameterFile: 'parameter_file',
    Process: 'process',
    Shutdown: 'shutdown',
    SignalProcess: 'signal',
    Timer: 'timer',
}


class PlanFormatError(Exception):
    """A text is no plan; the message says why."""


def plan_to_json(plan: Plan) -> str:
    """Return a plan as JSON."""
    data = {'version': VERSION, **_CODEC.to_json(plan)}
    return json.dumps(data, indent=2, ensure_ascii=False)


def plan_from_json(text: str) -> Plan:
    """
    Return the plan in a JSON text.

    :raises PlanFormatError: when it has none
    """
    if sum(map(text.count, '[{,')) > MAXIMUM_VALUES:
        raise PlanFormatError(f'it has more than {MAXIMUM_VALUES} values')
    try:
        data = json.loads(text, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as e:
        raise PlanFormatError(f'it is not JSON: {e}') from e
    if not isinstance(data, dict) or 'version' not in data:
        raise PlanFormatError("it has no 'version'")
    version = data.pop('version')
    if version != VERSION:
        raise PlanFormatError(
            f'its version is {version}, but only {VERSION} is known'
        )
    try:
        plan = _CODEC.from_json(Plan, data, 'plan')
    except CodecError as e:
        raise PlanFormatError(str(e)) from e
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


def _refuse_constant(name: str) -> None:
    # JSON has none of them (RFC 8259, 6)
    raise ValueError(f'{name} is no number')


def _read_seconds(data: object) -> float:
    seconds = read_float(data)
    if seconds < 0:
        raise CodecError('is no time that can be waited for')
    return seconds


def _read_environment(data: object) -> Variables:
    variables = from_json(dict[str, str | None], data)
    return tuple(sorted(variables.items()))


#: How values of some types are written and read.
SPECIAL: dict[Any, tuple[Write | None, Read]] = {
    float: (None, _read_seconds),
    # of any size, as a plan is the user's own
    int: (None, lambda data: only(int, data)),
    Variables: (dict, _read_environment),
}
_CODEC = Codec(TAGS, special=SPECIAL)
