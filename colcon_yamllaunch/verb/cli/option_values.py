# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The readers of option values.

Each gets the name of the option, for its errors, and a word.
"""

import math
from pathlib import Path
import re
import shlex
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.errors import UserError

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.output.line_pattern import LinePattern
    from colcon_yamllaunch.sweep.run import Metric

#: The value of `--log-limit` for no limit.
NO_LIMIT = 'none'
#: Bytes that a limit for logs has at least.
SMALLEST_LOG_LIMIT = 1_000_000

_SIZE = r'(\d+(?:\.\d+)?) ?([kmgt]?)(i?b?)'
_POWERS = ('', 'k', 'm', 'g', 't')


def read_text(_option: str, text: str) -> str:
    """Return the word as it is."""
    return text


def read_path(_option: str, text: str) -> Path:
    """Return a path, with `~` expanded."""
    return Path(text).expanduser()


def read_file(option: str, text: str) -> Path:
    """
    Return the path of a file.

    :raises UserError: if it is empty
    """
    if not text:
        raise UserError(f'{option} needs the name of a file')
    return read_path(option, text)


def read_words(option: str, text: str) -> tuple[str, ...]:
    """
    Split a text as a shell would.

    :raises UserError: if a quote is open
    """
    try:
        return tuple(shlex.split(text))
    except ValueError as e:
        raise UserError(f'{option} has an open quote: {e}') from e


def read_pattern(option: str, text: str) -> 'LinePattern':
    """
    Return a regular expression.

    :raises UserError: if it is empty or invalid
    """
    if not text:
        raise UserError(
            f'{option} needs a regular expression, and this one is empty'
        )
    # few launches wait for a line
    from colcon_yamllaunch.engine.output.line_pattern import LinePattern

    try:
        return LinePattern(text)
    except (re.error, OverflowError, RecursionError) as e:
        raise UserError(
            f"{option}: '{text}' is no regular expression: {e}"
        ) from e


def read_seconds(option: str, text: str) -> float:
    """
    Return a positive number of seconds.

    :raises UserError: if it is anything else
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise UserError(
            f"{option} needs a number of seconds above 0, not '{text}'"
        )
    return value


def read_count(option: str, text: str) -> int:
    """
    Return a positive number.

    :raises UserError: if it is anything else
    """
    if not (text.isascii() and text.isdigit()) or not 0 < int(text) < 10**9:
        raise UserError(f"{option} needs a number from 1 on, not '{text}'")
    return int(text)


def read_share(option: str, text: str) -> float:
    """
    Return a percentage as a number from 0 to 1.

    :raises UserError: if it is anything else
    """
    number, sign, rest = text.strip().partition('%')
    try:
        value = float(number)
    except ValueError:
        value = math.nan
    if rest or not sign or not 0 <= value <= 100:
        raise UserError(
            f"{option} needs a share of all runs, such as 95%, not '{text}'"
        )
    return value / 100


def read_metric(option: str, text: str) -> 'Metric':
    """
    Return what is measured in a sweep.

    :raises UserError: if it has no name or no group
    """
    # no other verb has it
    from colcon_yamllaunch.sweep.run import read_metric as read

    return read(option, text)


def read_place(option: str, text: str) -> tuple[str, ...]:
    """
    Return the options of `sbatch` from `slurm:OPTION=VALUE,…`.

    :raises UserError: if it is anything else
    """
    from colcon_yamllaunch.sweep.slurm_client import read_slurm_options

    return read_slurm_options(option, text)


def read_size(option: str, text: str) -> int | None:
    """
    Return a number of bytes, or None for no limit.

    :param option: The option or variable that has it
    :raises UserError: when it is no size, or too small
    """
    if text == NO_LIMIT:
        return None
    match = re.fullmatch(_SIZE, text.strip(), re.IGNORECASE)
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
            f"{option} is at least 1MB, not '{text}'",
            f"'{NO_LIMIT}' means no limit",
        )
    return size
