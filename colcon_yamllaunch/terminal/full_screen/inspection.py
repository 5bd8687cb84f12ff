# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""All that is known of one process or component, as text."""

from collections.abc import Sequence

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.table import duration
from colcon_yamllaunch.common.table import size
from colcon_yamllaunch.control.description_lines import description_lines
from colcon_yamllaunch.control.resource_usage import Usage
from colcon_yamllaunch.engine.description import Description
from colcon_yamllaunch.engine.state import ComponentState
from colcon_yamllaunch.engine.state import ProcessState
from colcon_yamllaunch.terminal.full_screen.launch_model import LaunchModel
from colcon_yamllaunch.terminal.status_model import state_of
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
        up = duration(model.state.seconds_of(part))
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


def in_full(model: LaunchModel, label: str, description: Description) -> Text:
    """Return a process or component with all that is known of it."""
    text = in_short(model, label, 60)
    text.no_wrap = False
    # below its name, which is there already
    for line in tuple(description_lines(description))[1:]:
        text.append(f'\n{one_line(line)}')
    return text


def _resources(
    history: Sequence[Usage],
) -> list[tuple[str, str, list[float]]]:
    latest = history[-1]
    return [
        ('CPU', f'{latest.cpu:.1%}', [u.cpu for u in history]),
        ('RAM', size(latest.memory), [float(u.memory) for u in history]),
    ]
