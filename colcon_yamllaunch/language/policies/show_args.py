# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The launch arguments of a launch file, laid out for a reader."""

from collections.abc import Iterator

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.language.evaluation.declared_argument import (
    DeclaredArgument,
)
from colcon_yamllaunch.language.policies.check import Declarations
from colcon_yamllaunch.plan.position import shown_position

_INDENT = ' ' * 8


def show_arguments(declarations: Declarations, cwd: str) -> str:
    """
    Lay the launch arguments of a launch file out.

    The layout is that of `ros2 launch --show-args`, with more lines in it:
    where each argument is declared, and which includes could not be followed.
    There is no line end after the last line.

    :param cwd: The folder that paths are shown relative to
    """
    return '\n'.join(_lines(declarations, cwd))


def _lines(declarations: Declarations, cwd: str) -> Iterator[str]:
    arguments = declarations.arguments
    yield "Arguments (pass arguments as '<name>:=<value>'):"
    for argument in arguments:
        yield ''
        yield from _argument(argument, cwd)
    if not arguments:
        yield ''
        yield '  No arguments.'
    if any(argument.is_conditional for argument in arguments):
        yield ''
        yield (
            '* argument(s) which are only used if specific conditions occur'
        )
    if declarations.not_followed:
        yield ''
        yield 'Includes that may have more arguments:'
        for position, reason in declarations.not_followed.items():
            yield ''
            yield f'    {shown_position(position, cwd)}:'
            yield _indented(reason)


def _argument(argument: DeclaredArgument, cwd: str) -> Iterator[str]:
    mark = '*' if argument.is_conditional else ''
    yield f"    '{one_line(argument.name)}':{mark}"
    yield _indented(_description(argument))
    if argument.default is None:
        yield f'{_INDENT}(required)'
    else:
        yield _indented(f"(default: '{argument.default}')")
    yield f'{_INDENT}(declared at {shown_position(argument.position, cwd)})'
    if argument.set_at is not None:
        place = shown_position(argument.set_at, cwd)
        yield f'{_INDENT}(always set at {place})'


def _description(argument: DeclaredArgument) -> str:
    # the words are ROS 2's (DeclareLaunchArgument)
    choices = ', '.join(f"'{choice}'" for choice in argument.choices)
    if argument.description is None:
        return f'One of: [{choices}]' if choices else 'no description given'
    if not choices:
        return argument.description
    stop = '' if argument.description.endswith('.') else '.'
    return f'{argument.description}{stop} Valid choices are: [{choices}]'


def _indented(text: str) -> str:
    lines = text.rstrip('\n').split('\n')
    return '\n'.join(f'{_INDENT}{line}'.rstrip() for line in lines)
