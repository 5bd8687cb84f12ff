# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The launch arguments that launch files declare."""

from __future__ import annotations

import os
from typing import Any
from typing import TYPE_CHECKING

from .channel import Json
from .descriptions import as_written
from .visit import declared_arguments

if TYPE_CHECKING:
    from .visit import Visitor


def install(visitor: Visitor) -> None:
    """Let the visitor answer requests for arguments."""
    visitor.requests['arguments'] = lambda r: _tell_arguments(visitor, r)


def _tell_arguments(visitor: Visitor, request: Json) -> None:
    """Tell the arguments of a file and of what it includes."""
    path = request['path']
    visitor.positions.otherwise = [path, 1, 1]
    visitor.reads_frontends = True
    try:
        arguments = declared_arguments(visitor.description(path))
    finally:
        visitor.reads_frontends = False
    for argument, includes in arguments:
        default = argument.default_value
        choices = argument.choices
        # one that is declared in YAML or XML has none
        position = visitor.positions.of(argument, *(includes or ()))
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
