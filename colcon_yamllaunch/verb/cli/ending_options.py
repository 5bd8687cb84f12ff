# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The options that say when a launch ends, and what is shown of it."""

from collections.abc import Sequence
import math
from pathlib import Path
import re
from typing import Any

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.runtime.core.events import Verbosity
from colcon_yamllaunch.runtime.streams.line_pattern import LinePattern
from colcon_yamllaunch.verb.cli.exclusion import excluded
from colcon_yamllaunch.verb.cli.exclusion import option_of

_UNTIL = '--until'


@dataclass(frozen=True, slots=True)
class LaunchRunOptions:
    """
    How a launch runs.

    :param until: What must be found in lines of its processes
    :param timeout: Seconds that this may take at most
    :param duration: Seconds that the launch goes on for after that
    :param junit: The file for a JUnit report, if one is wanted
    :param verbosity: How much is shown
    """

    until: tuple[LinePattern, ...] = ()
    timeout: float | None = None
    duration: float | None = None
    junit: Path | None = None
    verbosity: Verbosity = 'normal'


def add_shown(group: Any) -> None:
    """Add the options that say what is shown."""
    group.add_argument(
        '--quiet',
        action='store_true',
        help='Show only the output of the processes, warnings and failures',
    )
    group.add_argument(
        '--verbose',
        action='store_true',
        help='Show also the command line of each process, the variables that '
        'it gets, its parameters, and where each of them comes from',
    )


def add_ending(group: Any) -> None:
    """Add the options that say when a launch ends, and with what result."""
    group.add_argument(
        _UNTIL,
        action='append',
        metavar='REGEX',
        help='End with success as soon as a line of a process matches; '
        'given several times, all must have matched',
    )
    group.add_argument(
        '--timeout',
        metavar='SECONDS',
        help='End with failure when --until takes longer; without --until, '
        'when the launch does',
    )
    group.add_argument(
        '--for',
        dest='duration',
        metavar='SECONDS',
        help='Run for a time, and end with failure as soon as a process '
        'fails; with --until, the time starts when all has matched',
    )
    group.add_argument(
        '--junit',
        metavar='FILE',
        help='Write a JUnit report with a case for each process and --until',
    )


def joined_patterns(words: Sequence[str]) -> list[str]:
    """Join --until with its value, which may look like anything."""
    joined: list[str] = []
    for word in words:
        if joined and joined[-1] == _UNTIL:
            joined[-1] = f'{_UNTIL}={word}'
        else:
            joined.append(word)
    return joined


def run_options(options: Any, look: str | None) -> LaunchRunOptions:
    """
    Read the options that were added here.

    :param options: What the parser has made of them
    :param look: The name of what is shown instead of running, if anything is
    :raises WorkspaceError: if they make no sense
    """
    if look is not None:
        _refuse_with_look(options, look)
    if options.quiet and options.verbose:
        raise excluded('--quiet', '--verbose')
    until = tuple(_pattern(text) for text in options.until or ())
    timeout = _seconds('--timeout', options.timeout)
    duration = _seconds('--for', options.duration)
    if timeout is not None and duration is not None and not until:
        raise WorkspaceError(
            '--for and --timeout exclude one another: the one ends the launch '
            'with success, the other with failure. With --until, --timeout '
            'is for what comes before, and --for for what comes after'
        )
    if options.junit == '':
        raise WorkspaceError('--junit needs the name of a file')
    return LaunchRunOptions(
        until=until,
        timeout=timeout,
        duration=duration,
        junit=None if options.junit is None else Path(options.junit),
        verbosity='quiet'
        if options.quiet
        else 'verbose'
        if options.verbose
        else 'normal',
    )


def _refuse_with_look(options: Any, look: str) -> None:
    for name, given in (
        (_UNTIL, options.until),
        ('--timeout', options.timeout),
        ('--for', options.duration),
        ('--junit', options.junit),
        ('--quiet', options.quiet),
        ('--verbose', options.verbose),
    ):
        if given:
            raise WorkspaceError(
                f'{name} is about a launch that runs, and {option_of(look)} '
                'runs none'
            )


def _pattern(text: str) -> LinePattern:
    if not text:
        raise WorkspaceError(
            '--until needs a regular expression, and this one is empty'
        )
    try:
        return LinePattern(text)
    except (re.error, OverflowError, RecursionError) as e:
        raise WorkspaceError(
            f"--until: '{text}' is no regular expression: {e}"
        ) from e


def _seconds(option: str, text: str | None) -> float | None:
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise WorkspaceError(
            f"{option} needs a number of seconds above 0, not '{text}'"
        )
    return value
