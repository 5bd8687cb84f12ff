# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A process as it is told on the screen what it is."""

from collections.abc import Iterator
import shlex
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    # few launches are asked
    from colcon_yamllaunch.engine.description import Description
    from colcon_yamllaunch.engine.description import Parameter


def description_lines(description: 'Description') -> Iterator[str]:
    """Return lines with all of a process or component, first its name."""
    label = description.label
    name = '' if description.name == label else description.name
    fields = (
        ('node', description.node),
        ('package', description.package),
        ('in ROS 2', name),
        ('from', description.position),
        *(
            (place.kind, _place(place.title, place.position))
            for place in description.within
        ),
        ('command', shlex.join(description.argv)),
        ('plugin', description.plugin),
        ('container', description.container),
        ('folder', description.cwd),
        ('log', description.log),
    )
    yield f'{label}:'
    for field, value in fields:
        if value:
            yield f'  {field}: {value}'
    if description.environment:
        yield '  environment:'
        for variable, text in description.environment:
            yield f'    {variable}' + (
                ' unset' if text is None else f'={shlex.quote(text)}'
            )
    if description.parameters:
        yield '  parameters:'
        yield from map(_parameter, description.parameters)
    if description.remaps:
        yield '  remapping:'
        for rule in description.remaps:
            yield f'    {rule}'


def _place(title: str, position: str) -> str:
    is_told = position.startswith(title)
    return position if is_told else f'{title} ({position})'


def _parameter(parameter: 'Parameter') -> str:
    origins = ''.join(f', from {origin}' for origin in parameter.origins)
    value = f'{parameter.name}: {parameter.value}'
    return f'    {value}  ({parameter.position}{origins})'
