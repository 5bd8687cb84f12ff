# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Values in a deployment file, and the errors of wrong ones."""

from collections.abc import Callable, Mapping, Sequence
import math
import re
import shlex
from typing import TypeVar

from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.language.syntax import yaml_reader
from colcon_yamllaunch.language.syntax.diagnostics import (
    Diagnostic,
    error,
    LaunchError,
)
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar, Value

#: The name of a variable.
VARIABLE = re.compile(r'[A-Za-z_][A-Za-z0-9_]*')
#: The longest time in a deployment file, in seconds.
YEAR = 365 * 86400
_Choice = TypeVar('_Choice', bound=str)

#: The keys and values of a mapping.
Pairs = Mapping[str, tuple[Scalar, Value]]


def wrong_value(message: str, value: Value, hint: str) -> LaunchError:
    """Return an error that underlines a scalar, or the start of others."""
    span = value if isinstance(value, Scalar) else value.position
    return error(message, span, hint=hint)


def pairs_of(value: Value, what: str, hint: str | None = None) -> Pairs:
    """
    Return the keys and values of a mapping.

    :param what: Names the value in errors
    :raises LaunchError: when it is something else
    """
    if not isinstance(value, yaml_reader.Mapping):
        raise error(f'{what} is not a mapping', value.position, hint=hint)
    return value.pairs


def check_keys(pairs: Pairs, known: Sequence[str], where: str) -> None:
    """
    Check that a mapping has only known keys.

    :param where: Names the mapping in errors
    :raises LaunchError: with all keys that are not known
    """
    wrong = [
        Diagnostic(
            'error',
            f"{where} has no key '{name}'",
            key.position,
            did_you_mean(name, known) or f'there are {", ".join(known)}',
            key.length,
        )
        for name, (key, _) in pairs.items()
        if name not in known
    ]
    if wrong:
        raise LaunchError(*wrong)


def text(value: Value, what: str, hint: str) -> str:
    """
    Return a text that is not empty, of one line.

    :param what: Names the value in errors
    :raises LaunchError: when it is something else
    """
    if not isinstance(value, Scalar):
        raise wrong_value(f'{what} is not a text', value, hint)
    if value.kind == 'null' or not value.text.strip():
        raise wrong_value(f'{what} is empty', value, hint)
    if not value.text.isprintable():
        raise wrong_value(f'{what} is not a text of one line', value, hint)
    return value.text


def pattern(value: Value, what: str) -> str:
    """Return a name or glob."""
    return text(value, what, 'a name, or a pattern with *, ? and […]')


def choice(value: Value, key: str, choices: Sequence[_Choice]) -> _Choice:
    """Return one of some words."""
    hint = f'it is one of {", ".join(choices)}'
    word = text(value, f"'{key}'", hint)
    for known in choices:
        if word == known:
            return known
    message = f"'{key}' has no value '{word}'"
    raise wrong_value(message, value, did_you_mean(word, choices) or hint)


def words(value: Value, key: str, item: str, hint: str) -> tuple[str, ...]:
    """Return a list of words, or a text split into words."""
    if isinstance(value, yaml_reader.Sequence):
        what = f"{item} of '{key}'"
        return tuple(text(v, what, hint) for v in value.items)
    try:
        return tuple(shlex.split(text(value, f"'{key}'", hint)))
    except ValueError as e:
        message = f"'{key}' has an open quote: {e}"
        raise wrong_value(message, value, hint) from e


def number(
    value: Value,
    key: str,
    lowest: float,
    highest: float,
    *,
    what: str = 'a number',
    read: Callable[[str], float] = float,
) -> float:
    """
    Return a number.

    :param what: What it is, such as `a number of seconds`
    :param read: Returns the number that a text is, or raises ValueError
    :raises LaunchError: when it is none, or out of the range
    """
    limit = '' if highest == math.inf else f' to {highest:g}'
    hint = f'{what} from {lowest:g}{limit}'
    word = text(value, f"'{key}'", hint)
    try:
        found = read(word)
    except ValueError:
        found = math.nan
    if not lowest <= found <= highest or found == math.inf:
        raise wrong_value(f"'{key}' has no value '{word}'", value, hint)
    return found


def whole_number(value: Value, key: str, lowest: int, highest: float) -> int:
    """Return a whole number in a range; see :func:`number`."""
    return int(
        number(value, key, lowest, highest, what='a whole number', read=int)
    )


def seconds(value: Value, key: str, lowest: float = 0.0) -> float:
    """Return a number of seconds, at most a year."""
    return number(value, key, lowest, YEAR, what='a number of seconds')


def flag(value: Value, key: str) -> bool:
    """
    Return whether a value is true.

    :raises LaunchError: when it is neither true nor false
    """
    if isinstance(value, Scalar) and value.kind == 'bool':
        return bool(value.value)
    raise wrong_value(f"'{key}' is not true or false", value, f'{key}: true')


def variables(
    value: Value, hint: str
) -> tuple[tuple[str, ...], tuple[tuple[str, str], ...]]:
    """Return names of variables without a value, and those with values."""
    given: list[tuple[Value, Value | None]] = [(value, None)]
    if isinstance(value, yaml_reader.Sequence):
        given = [(item, None) for item in value.items]
    elif isinstance(value, yaml_reader.Mapping):
        given = list(value.pairs.values())
    names: dict[str, None] = {}
    values = []
    for item, content in given:
        name = text(item, "a name in 'env'", hint)
        if VARIABLE.fullmatch(name) is None:
            raise wrong_value(f"'{name}' is no name of a variable", item, hint)
        if content is not None and not isinstance(content, Scalar):
            message = f"the value of '{name}' is not a text"
            raise wrong_value(message, content, hint)
        if content is None or content.kind == 'null':
            names[name] = None
        elif '\0' in content.text:
            raise error(f"the value of '{name}' has a null character", content)
        else:
            values.append((name, content.text))
    return tuple(names), tuple(values)
