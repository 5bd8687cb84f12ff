# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The values that parameters of nodes have."""

from collections.abc import Iterable
from functools import lru_cache
import json

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.syntax.yaml_reader import (
    construct,
    load_yaml,
    plain_kind,
    UnusableYamlError,
)
from colcon_yamllaunch.plan.plan import ParameterFile, SetParameter
from colcon_yamllaunch.plan.position import Position

ScalarValue = str | int | float | bool
ParameterContent = ScalarValue | tuple[ScalarValue, ...]


class ParameterTypeError(Exception):
    """A text is no value of the type that a parameter is to have."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """
    A parameter of a node.

    :param name: Its full name, parts separated by dots
    :param value: Its value, None when it is not known
    :param position: Where it is set
    :param origins: Where the launch configurations were set that the value
      was made of, nearest first
    """

    name: str
    value: ParameterContent | None
    position: Position
    origins: tuple[Position, ...] = ()

    def as_set(self) -> SetParameter:
        """Return what a plan says of it, once its value is known."""
        assert self.value is not None
        value = to_yaml(self.value)
        return SetParameter(self.name, value, self.position, self.origins)

    def as_json(self) -> SetParameter:
        """Return the same, with the value as JSON."""
        assert self.value is not None
        value = to_json(self.value)
        return SetParameter(self.name, value, self.position, self.origins)


@lru_cache(maxsize=256)
def parse_boolean(text: str) -> bool | None:
    """Return the YAML 1.1 boolean, `1` or `0` that a text is, else None."""
    text = text.strip()
    if text in ('0', '1'):
        return text == '1'
    if plain_kind(text) == 'bool':
        return construct('bool', text) is True
    return None


def infer(text: str) -> ParameterContent:
    """
    Return what YAML takes a text for, as ROS 2 does after substitutions.

    An empty text, which is nothing in YAML, stays one in ROS 2.

    :raises ParameterTypeError: when it is nothing that a parameter can be
    """
    if not text:
        return text
    kind = plain_kind(text)
    if kind in ('int', 'float', 'bool'):
        try:
            value = construct(kind, text)
        except ValueError as e:
            # Python reads no number of thousands of digits
            raise ParameterTypeError(
                f'the value {_shown(text)} is no number: {e}'
            ) from e
        assert value is not None
        return value
    if kind == 'str' and not _looks_like_yaml(text):
        return text
    try:
        loaded = load_yaml(text)
    except UnusableYamlError as e:
        raise ParameterTypeError(
            f'the value {_shown(text)} is not YAML'
        ) from e
    return _check(loaded, text)


def coerce(text: str, kind: str) -> ParameterContent:
    """
    Return a text as a value of a type.

    :param kind: str, bool, int, float, or yaml
    :raises ParameterTypeError: when it is none
    """
    if kind == 'yaml':
        return infer(text)
    if kind == 'str':
        return text
    try:
        if kind == 'bool':
            value = parse_boolean(text)
            if value is None:
                raise ValueError
            return value
        return int(text) if kind == 'int' else float(text)
    except ValueError as e:
        raise ParameterTypeError(
            f'the value {_shown(text)} is no {kind}'
        ) from e


def to_yaml(value: ParameterContent) -> str:
    """
    Return a value as YAML that ROS 2's parser reads as the same value.

    Texts are always quoted: ROS 2's parser takes an unquoted `1e-3`, `on` or
    `0x10` for something else.
    """
    if isinstance(value, tuple):
        return f'[{", ".join(to_yaml(item) for item in value)}]'
    if isinstance(value, bool):
        return 'true' if value else 'false'
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, int):
        return str(value)
    return _float(value)


def to_json(value: ParameterContent) -> str:
    """
    Return a value as JSON, which tells whole numbers from others.

    What JSON has no word for is written as in YAML: `.inf`, `-.inf`, `.nan`.
    """
    if isinstance(value, tuple):
        return f'[{", ".join(to_json(item) for item in value)}]'
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=not value.isprintable())
    return to_yaml(value)


def parameter_file(
    pattern: str, parameters: Iterable[SetParameter]
) -> ParameterFile:
    """
    Return a file with parameters.

    :param pattern: The nodes that they are for: a full name or `/**`
    """
    lines = [f'{_quoted(pattern)}:', '  ros__parameters:']
    # the last of several values counts, and keeps its place
    values = {p.name: p.value for p in parameters}
    lines.extend(
        f'    {_quoted(name)}: {value}' for name, value in values.items()
    )
    return ParameterFile('\n'.join(lines) + '\n', tuple(parameters))


def _quoted(text: str) -> str:
    # a JSON string is a YAML string in double quotes; beyond the basic plane
    # JSON would write surrogates, which YAML does not join
    quoted = json.dumps(text, ensure_ascii=False)
    return ''.join(
        c
        if c.isprintable()
        else f'\\u{ord(c):04x}'
        if ord(c) < 0x10000
        else f'\\U{ord(c):08x}'
        for c in quoted
    )


def _float(value: float) -> str:
    text = repr(value)
    if text in ('inf', '-inf', 'nan'):
        return text.replace('inf', '.inf').replace('nan', '.nan')
    if 'e' in text and '.' not in text:
        # YAML 1.1 wants the dot
        text = text.replace('e', '.0e')
    return text


def _looks_like_yaml(text: str) -> bool:
    if text != text.strip() or '\n' in text or '\t' in text:
        return True
    return (
        text[:1] in '[{\'"!&*#|>%@`-?:,]}'
        or ': ' in text
        or ' #' in text
        or text.endswith(':')
    )


def _check(value: object, text: str) -> ParameterContent:
    if isinstance(value, str | int | float | bool):
        return value
    if isinstance(value, list):
        items = tuple(value)
        kinds = {type(item) for item in items}
        if len(kinds) <= 1 and kinds <= {str, int, float, bool}:
            return items
        raise ParameterTypeError(
            f'the list {_shown(text)} has values of several types or of none '
            'that a parameter can have'
        )
    what = 'nothing' if value is None else 'a date'
    if isinstance(value, dict):
        what = 'a mapping'
    raise ParameterTypeError(
        f'YAML reads the value {_shown(text)} as {what}, which no parameter '
        "can be; 'type: str' keeps it a text"
    )


def _shown(text: str) -> str:
    return repr(text if len(text) <= 60 else text[:57] + '…')
