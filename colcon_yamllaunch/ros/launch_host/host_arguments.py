# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The launch arguments that launch files declare."""

from __future__ import annotations

import importlib
import os
from typing import Any
from typing import TYPE_CHECKING

from host_texts import as_written

if TYPE_CHECKING:
    from host_visit import Visitor

    # as code, this needs 3.9
    Json = dict[str, Any]


def install(visitor: Visitor) -> None:
    """Let the visitor answer requests for arguments."""
    visitor.requests['arguments'] = lambda r: _tell_arguments(visitor, r)


def _tell_arguments(visitor: Visitor, request: Json) -> None:
    """Tell the arguments of a file and of what it includes."""
    path = request['path']
    sources = importlib.import_module('launch.launch_description_sources')
    source = sources.PythonLaunchDescriptionSource(path)
    description = source.get_launch_description(visitor.context)
    for argument in description.get_launch_arguments():
        default = argument.default_value
        choices = argument.choices
        position = visitor.positions.of(argument)
        visitor.say(
            'argument',
            name=argument.name,
            default=None if default is None else as_written(default),
            description=_description(argument),
            choices=None if choices is None else [str(c) for c in choices],
            conditional=bool(argument._conditionally_included),
            position=position,
            file=os.path.abspath(str(position[0] if position else path)),
        )


def _description(argument: Any) -> str:
    """Return a description without what `launch` adds to it."""
    text = str(argument.description or '')
    if text == 'no description given':
        return ''
    if argument.choices is not None:
        choices = str(argument.choices)
        if text == f'One of: {choices}':
            return ''
        end = f' Valid choices are: {choices}'
        if text.endswith(end):
            text = text[: -len(end)]
    return text
