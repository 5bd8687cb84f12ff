# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""All that is known of one process or component, as text."""

from collections.abc import Mapping
from collections.abc import Sequence
import shlex
from typing import Any

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.table import duration
from colcon_yamllaunch.common.table import size
from colcon_yamllaunch.runtime.clients.resource_usage import Usage
from colcon_yamllaunch.runtime.control.launch_states import ComponentState
from colcon_yamllaunch.runtime.control.launch_states import ProcessState
from colcon_yamllaunch.ui.launch_model import LaunchModel
from colcon_yamllaunch.ui.part_rows import state_of
from rich.text import Text

_BARS = '▁▂▃▄▅▆▇█'


def in_short(model: LaunchModel, label: str, width: int) -> Text:
    """Return a process or component in four lines: state and resources."""
    part = model.part(label)
    text = Text(no_wrap=True, overflow='ellipsis')
    if part is None:
        return text
    text.append(one_line(label), 'bold')
    if part.node is not None:
        text.append(f'  {one_line(part.node)}', 'dim')
    text.append(f'\n{state_of(part)}')
    if isinstance(part, ProcessState) and part.pid is not None:
        up = duration(model.now_of(part.seconds))
        text.append(f'  pid {part.pid}  up {up}')
        if part.restarts:
            text.append(f'  restarts {part.restarts}')
    elif isinstance(part, ComponentState):
        text.append(f'  {one_line(part.plugin)}')
    history = list(model.usage.get(label, ()))
    if history:
        for name, shown, values in _resources(history):
            text.append(f'\n{name} ', 'dim')
            text.append(f'{shown:>10} ')
            room = max(0, width - len(name) - 13)
            text.append(curve(values[-room:] if room else ()), 'cyan')
    return text


def curve(values: Sequence[float]) -> str:
    """Draw numbers above 0, the largest one highest."""
    top = max(values, default=0.0)
    if not top:
        return _BARS[0] * len(values)
    last = len(_BARS) - 1
    return ''.join(_BARS[round(v / top * last)] for v in values)


def in_full(
    model: LaunchModel, label: str, description: Mapping[str, Any]
) -> Text:
    """
    Return a process or component with all that is known of it.

    :param description: As `protocol` has it
    """
    text = in_short(model, label, 60)
    text.no_wrap = False
    _section(text, 'From', [str(description.get('position'))])
    _section(
        text,
        'In',
        [
            f'{w.get("kind")} {w.get("title")} ({w.get("position")})'
            for w in _objects(description.get('within'))
        ],
    )
    argv = description.get('argv')
    if isinstance(argv, list) and argv:
        _section(text, 'Command line', [shlex.join(map(str, argv))])
    cwd = description.get('cwd')
    _section(text, 'Working directory', [str(cwd)] if cwd else [])
    for title, key in (
        ('Component', 'plugin'),
        ('Container', 'container'),
        ('Package', 'package'),
        ('Log', 'log'),
    ):
        value = description.get(key)
        _section(text, title, [str(value)] if value else [])
    _section(
        text,
        'Parameters',
        [
            f'{p.get("name")}: {p.get("value")}  ({_origin(p)})'
            for p in _objects(description.get('parameters'))
        ],
    )
    remaps = description.get('remaps')
    if isinstance(remaps, list):
        _section(text, 'Remappings', [str(r) for r in remaps])
    environment = description.get('environment')
    if isinstance(environment, Mapping):
        _section(
            text,
            'Environment, as far as it is its own',
            [
                f'{name} is unset' if value is None else f'{name}={value}'
                for name, value in environment.items()
            ],
        )
    return text


def _resources(
    history: Sequence[Usage],
) -> list[tuple[str, str, list[float]]]:
    latest = history[-1]
    return [
        ('CPU', f'{latest.cpu:.1%}', [u.cpu for u in history]),
        ('RAM', size(latest.memory), [float(u.memory) for u in history]),
    ]


def _section(text: Text, title: str, lines: Sequence[str]) -> None:
    if lines:
        text.append(f'\n\n{title}', 'bold')
        for line in lines:
            text.append(f'\n  {one_line(line)}')


def _objects(value: object) -> list[Mapping[str, Any]]:
    items = value if isinstance(value, list) else []
    return [item for item in items if isinstance(item, Mapping)]


def _origin(parameter: Mapping[str, Any]) -> str:
    origins = parameter.get('origins')
    places = [parameter.get('position')]
    if isinstance(origins, list):
        places += origins
    return ', from '.join(str(place) for place in places)
