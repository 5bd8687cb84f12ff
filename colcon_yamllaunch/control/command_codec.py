# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Commands and responses as messages of the control protocol, and back."""

from collections.abc import Mapping
from typing import Any, TypeVar

from colcon_yamllaunch.common.codec import Codec, CodecError
from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.engine import commands
from colcon_yamllaunch.engine.commands import Command
from colcon_yamllaunch.plan.plan_json import SPECIAL, TAGS

_T = TypeVar('_T')


def read_request(kind: type[_T], message: Mapping[str, Any]) -> _T:
    """
    Return the command, or what else a request stands for.

    :raises ProtocolError: when a field is missing or of another type
    """
    try:
        return _CODEC.from_json(kind, message)
    except CodecError as error:
        name, problem = error.path.lstrip('.'), error.problem
        raise ProtocolError(f"the '{name}' {problem}") from error


def fields_of(command: Command[Any]) -> dict[str, Any]:
    """Return the fields of the request that asks for a command."""
    fields: dict[str, Any] = _CODEC.to_json(command)
    return fields


def request_of(command: Command[Any]) -> dict[str, Any]:
    """Return the request that asks for a command."""
    return protocol.request(command.name, **fields_of(command))


def response_of(command: Command[Any], answer: Mapping[str, Any]) -> Any:
    """
    Return the response to a command that an answer stands for.

    It is `Refused` if the answer is malformed.
    """
    if not answer.get('ok'):
        return commands.Refused(str(answer.get('error')))
    try:
        match command:
            case commands.Describe():
                from colcon_yamllaunch.engine import description

                described = description.from_json(answer.get('description'))
                return commands.Described(described)
            case commands.Tree():
                from colcon_yamllaunch.engine import description

                return commands.PlanTree(
                    description.tree_from_json(answer.get('tree'))
                )
            case commands.RestartChanged():
                return _CODEC.from_json(commands.Restarted, answer)
            case _:
                return commands.DONE
    except CodecError as error:
        return commands.Refused(f'the answer is malformed: {error}')


def _read_bytes(data: object) -> bytes:
    try:
        return protocol.bytes_of(data)
    except ProtocolError as error:
        raise CodecError('is not a text with a byte a character') from error


_CODEC = Codec(
    TAGS,
    special={**SPECIAL, bytes: (protocol.text_of, _read_bytes)},
    # clients of a later version may send more
    accept_unknown=True,
)
