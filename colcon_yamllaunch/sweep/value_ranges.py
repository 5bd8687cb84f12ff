# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The values of one launch argument of a sweep.

They are written as a list, `lab,street`, whose items may be ranges of
numbers, `1..10` or `0..1..0.25`, as brace expansion of bash has them: first,
last and step. A range counts down if it ends below its beginning, and keeps
zeros in front, `001..120`. Anything else is a value as it stands.
"""

from decimal import Decimal
import re

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.sweep.run_limits import MAXIMUM_RUNS

_NUMBER = r'[+-]?\d+(?:\.\d+)?'
_RANGE = re.compile(rf'({_NUMBER})\.\.({_NUMBER})(?:\.\.({_NUMBER}))?')
# what is certainly meant as one, with something that is no number
_NEARLY = re.compile(rf'{_NUMBER}\.\.+[^/]*|[^/]*\.\.+{_NUMBER}')
_OPENING = '([{'
_CLOSING = ')]}'
#: Digits that a number of a range has at most.
_MAXIMUM_DIGITS = 12


def values_of(name: str, text: str) -> tuple[str, ...]:
    r"""
    Return the values of a launch argument.

    A comma in brackets is part of a value, and so is `\,`.

    :param name: The argument, for errors
    :param text: What the user wrote behind `:=`
    :raises UserError: when a range makes no sense, or a value comes twice
    """
    place = f"in '{name}:={text}'"
    items = _items(text)
    values: list[str] = []
    for item in items:
        if not item and len(items) > 1:
            raise UserError(
                f'{place} a value of the list is empty',
                'there is a comma too many',
            )
        values.extend(_expanded(item, place))
        if len(values) > MAXIMUM_RUNS:
            raise _too_many(place)
    seen: set[str] = set()
    for value in values:
        if value in seen:
            raise UserError(
                f"{place} the value '{value}' comes twice",
                'to run each combination several times: --repeat N',
            )
        seen.add(value)
    return tuple(values)


def _items(text: str) -> list[str]:
    """Split a list at its commas, but not within brackets."""
    items, item, depth, escaped = [], '', 0, False
    for character in text:
        if escaped:
            # any other backslash stays what it is
            item += character if character == ',' else f'\\{character}'
            escaped = False
            continue
        if character == '\\':
            escaped = True
            continue
        if character == ',' and depth == 0:
            items.append(item)
            item = ''
            continue
        depth += character in _OPENING
        depth -= character in _CLOSING and depth > 0
        item += character
    return [*items, item + '\\' * escaped]


def _expanded(item: str, place: str) -> list[str]:
    """Return the numbers of a range, or the item itself."""
    found = _RANGE.fullmatch(item)
    if found is None:
        if _NEARLY.fullmatch(item):
            raise UserError(
                f"{place} the range '{item}' is not made of numbers",
                'it is written first..last or first..last..step',
            )
        return [item]
    first_text, last_text, step_text = found.groups()
    if max(map(len, (first_text, last_text, step_text or ''))) > (
        _MAXIMUM_DIGITS
    ):
        raise UserError(f"{place} the range '{item}' has too long numbers")
    first, last = Decimal(first_text), Decimal(last_text)
    step = Decimal(1) if step_text is None else abs(Decimal(step_text))
    if not step:
        raise UserError(
            f"{place} the range '{item}' has a step of 0, and would never end"
        )
    if step_text is not None and Decimal(step_text) < 0 and last > first:
        raise UserError(
            f"{place} the range '{item}' counts down from {first_text}, and "
            f'never gets to {last_text}'
        )
    if abs(last - first) / step >= MAXIMUM_RUNS:
        raise _too_many(place)
    count = int(abs(last - first) / step) + 1
    if last < first:
        step = -step
    # all have as many decimals as the one that has most: 0.0, 0.5, 1.0
    decimals = max(
        _decimals(text) for text in (first_text, last_text, step_text or '')
    )
    width = 0
    if any(re.match(r'[+-]?0\d', text) for text in (first_text, last_text)):
        width = max(len(t.lstrip('+')) for t in (first_text, last_text))
    zeros = f'0{width}' if width else ''
    return [
        f'{first + number * step:{zeros}.{decimals}f}'
        for number in range(count)
    ]


def _decimals(text: str) -> int:
    return len(text.partition('.')[2])


def _too_many(place: str) -> UserError:
    return UserError(
        f'{place} there are more than {MAXIMUM_RUNS:,} values, which is what '
        'a sweep may have'
    )
