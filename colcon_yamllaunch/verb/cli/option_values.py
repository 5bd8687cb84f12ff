# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the values of options are read as."""

from collections.abc import Callable
from collections.abc import Mapping
import math
from pathlib import Path
import re
import shlex
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.runtime.streams.line_pattern import LinePattern
from colcon_yamllaunch.verb.cli.option_table import Kind
from colcon_yamllaunch.verb.cli.option_table import NO_LIMIT
from colcon_yamllaunch.verb.cli.option_table import Option

#: Bytes that a limit for logs has at least.
SMALLEST_LOG_LIMIT = 1_000_000

_SIZE = re.compile(r'(\d+(?:\.\d+)?) ?([kmgt]?)(i?b?)', re.IGNORECASE)
_POWERS = ('', 'k', 'm', 'g', 't')


def read_value(option: Option, given: Any) -> Any:
    """
    Read what argparse has got for an option.

    :param given: A text or texts, or for an option without a value True
    :raises UserError: when it makes no sense
    """
    if option.value is None:
        return given
    read = READERS[option.value.kind]
    if isinstance(given, str):
        return read(option.name, given)
    return tuple(read(option.name, text) for text in given)


def _file(option: str, text: str) -> Path:
    if not text:
        raise UserError(f'{option} needs the name of a file')
    return Path(text).expanduser()


def _words(option: str, text: str) -> tuple[str, ...]:
    """Split a text as a shell would."""
    try:
        return tuple(shlex.split(text))
    except ValueError as e:
        raise UserError(f'{option} has an open quote: {e}') from e


def _pattern(option: str, text: str) -> LinePattern:
    if not text:
        raise UserError(
            f'{option} needs a regular expression, and this one is empty'
        )
    try:
        return LinePattern(text)
    except (re.error, OverflowError, RecursionError) as e:
        raise UserError(
            f"{option}: '{text}' is no regular expression: {e}"
        ) from e


def _seconds(option: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise UserError(
            f"{option} needs a number of seconds above 0, not '{text}'"
        )
    return value


def _size(option: str, text: str) -> int | None:
    """Return a number of bytes, or None for no limit."""
    if text == NO_LIMIT:
        return None
    match = _SIZE.fullmatch(text.strip())
    if match is None:
        raise UserError(
            f"{option} takes a size such as 500MB or 2GB, or '{NO_LIMIT}', "
            f"not '{text}'"
        )
    number, prefix, unit = match.groups()
    # as in coreutils: kB is 1000 bytes, KiB and K are 1024
    base = 1000 if unit.lower() == 'b' else 1024
    size = int(float(number) * base ** _POWERS.index(prefix.lower()))
    if size < SMALLEST_LOG_LIMIT:
        raise UserError(
            f"{option} is at least 1MB, not '{text}'; '{NO_LIMIT}' means no "
            'limit'
        )
    return size


READERS: Mapping[Kind, Callable[[str, str], Any]] = {
    'text': lambda _, text: text,
    'file': _file,
    'path': lambda _, text: Path(text).expanduser(),
    'pattern': _pattern,
    'seconds': _seconds,
    'size': _size,
    'words': _words,
}
