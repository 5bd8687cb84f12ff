# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The options about output and logs."""

import re
from typing import Any

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.runtime.core.limits import LOG_LIMIT

#: Bytes that a limit for logs has at least.
SMALLEST_LOG_LIMIT = 1_000_000

_NO_LIMIT = 'none'
_SIZE = re.compile(r'(\d+(?:\.\d+)?) ?([kmgt]?)(i?b?)', re.IGNORECASE)
_POWERS = ('', 'k', 'm', 'g', 't')


@dataclass(frozen=True, slots=True)
class OutputOptions:
    """
    How output is shown and kept.

    :param tty: Whether each process writes to a terminal
    :param color: False for no colours, None for colours where they fit
    :param log_limit: What the log files may take together, in bytes, or None
    """

    tty: bool = False
    color: bool | None = None
    log_limit: int | None = LOG_LIMIT


def add_output_options(group: Any) -> None:
    """Add the options to a group of a parser."""
    group.add_argument(
        '--tty',
        action='store_true',
        help='Let each process write to a terminal of its own, as if the '
        'launch file said `emulate_tty: true` for all of them',
    )
    group.add_argument(
        '--no-color', action='store_true', help='Use no colours'
    )
    group.add_argument(
        '--log-limit',
        metavar='SIZE',
        help='What the log files of the launch may take together, such as '
        f'500MB, 2GB or {_NO_LIMIT} (default: {LOG_LIMIT // 10**9}GB)',
    )


def output_options(known: Any) -> OutputOptions:
    """
    Read the options.

    :param known: What the parser has made of the command line
    :raises WorkspaceError: if a size is none
    """
    return OutputOptions(
        tty=known.tty,
        color=False if known.no_color else None,
        log_limit=LOG_LIMIT
        if known.log_limit is None
        else _log_limit(known.log_limit),
    )


def _log_limit(text: str) -> int | None:
    if text == _NO_LIMIT:
        return None
    match = _SIZE.fullmatch(text.strip())
    if match is None:
        raise WorkspaceError(
            f"--log-limit takes a size such as 500MB or 2GB, or '{_NO_LIMIT}'"
            f", not '{text}'"
        )
    number, prefix, unit = match.groups()
    # as in coreutils: kB is 1000 bytes, KiB and K are 1024
    base = 1000 if unit.lower() == 'b' else 1024
    size = int(float(number) * base ** _POWERS.index(prefix.lower()))
    if size < SMALLEST_LOG_LIMIT:
        raise WorkspaceError(
            f"--log-limit is at least 1MB, not '{text}'; '{_NO_LIMIT}' means "
            'no limit'
        )
    return size
