# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The options that are about running launches, or about the keyboard."""

from collections.abc import Sequence
from typing import Any

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.verb.cli.exclusion import at_most_one
from colcon_yamllaunch.verb.cli.exclusion import option_of

#: What can be asked of a running launch, with a list of names.
ACTIONS = ('stop', 'restart', 'logs')
#: The formats of `--status`.
STATUS_FORMATS = ('text', 'json')

_ATTACH = '--attach'
_OF = '--of'


@dataclass(frozen=True, slots=True)
class ControlOptions:
    """
    What the user asks of running launches.

    :param action: `status`, `stop`, `restart`, `logs` or `attach`
    :param names: The processes, by name or glob
    :param launch: Which launch is meant: its package, launch file, title or
      process id; None when that is clear
    :param follow: Whether `logs` waits for more
    :param status_format: One of :data:`STATUS_FORMATS`
    """

    action: str
    names: tuple[str, ...] = ()
    launch: str | None = None
    follow: bool = False
    status_format: str = 'text'


def add_control_options(group: Any) -> None:
    """Add the options to a group of a parser."""
    group.add_argument(
        '--status',
        nargs='?',
        const='text',
        metavar='FORMAT',
        help='Show all running launches and their processes; --status=json '
        'for programs',
    )
    group.add_argument(
        '--stop',
        nargs='*',
        metavar='NAME',
        help='Stop processes, by name or glob; without a name, the launch',
    )
    group.add_argument(
        '--restart',
        nargs='*',
        metavar='NAME',
        help='Start processes anew, by name or glob',
    )
    group.add_argument(
        '--logs',
        nargs='*',
        metavar='NAME',
        help='Show what processes wrote, by name or glob',
    )
    group.add_argument(
        '-f',
        '--follow',
        action='store_true',
        help='With --logs: the last lines, then what comes',
    )
    group.add_argument(
        _ATTACH,
        metavar='NAME',
        help='Connect the keyboard to a process: with PKG FILE to one of the '
        'new launch, else to one of a running launch; Ctrl-] detaches',
    )
    group.add_argument(
        _OF,
        metavar='LAUNCH',
        help='Which running launch is meant, where that is not clear: its '
        'package, launch file or pid',
    )


def is_control(argv: Sequence[str]) -> bool:
    """
    Tell whether a command line only looks at running launches.

    This is known before the command line is parsed, since then colcon has
    made a folder for logs already.
    """
    options = {word.partition('=')[0] for word in argv}
    if options & {'--status', *(f'--{name}' for name in ACTIONS)}:
        return True
    words = list(argv[argv.index('launch') + 1 :]) if 'launch' in argv else []
    for option in (_ATTACH, _OF):
        if option in words:
            index = words.index(option)
            del words[index : index + 2]
    return _ATTACH in options and all(word.startswith('--') for word in words)


def control_options(
    options: Any, words: Sequence[str], *, has_plan: bool
) -> ControlOptions | None:
    """
    Return what is asked of running launches.

    :param options: The parsed options
    :param words: The words that belong to no option
    :param has_plan: Whether a saved plan is launched
    :returns: None when something is launched
    :raises WorkspaceError: if it makes no sense
    """
    given = [
        name
        for name in ('status', *ACTIONS)
        if getattr(options, name) is not None
    ]
    if options.attach is not None and (given or not (words or has_plan)):
        given.append('attach')
    at_most_one([option_of(name) for name in given])
    if not given:
        _refuse_alone(options)
        return None
    action = given[0]
    _check_action(action, options, words)
    if action == 'attach':
        names = [options.attach]
    else:
        names = [*(getattr(options, action) or ()), *words]
    return ControlOptions(
        action,
        tuple(names) if action != 'status' else (),
        options.of,
        options.follow,
        options.status or 'text',
    )


def _check_action(action: str, options: Any, words: Sequence[str]) -> None:
    if options.follow and action != 'logs':
        raise WorkspaceError('-f goes with --logs')
    if action == 'status' and words:
        raise WorkspaceError(
            f"--status takes no '{words[0]}': it shows all running launches; "
            'one of them with --of LAUNCH'
        )
    if action == 'status' and options.status not in STATUS_FORMATS:
        raise WorkspaceError(
            f"--status has no format '{options.status}': it is one of "
            f'{", ".join(STATUS_FORMATS)}'
        )
    if action == 'restart' and not (options.restart or words):
        raise WorkspaceError(
            "--restart needs the NAME of a process; '*' means all of them"
        )


def _refuse_alone(options: Any) -> None:
    if options.follow:
        raise WorkspaceError('-f goes with --logs')
    if options.of is not None:
        raise WorkspaceError(
            '--of LAUNCH goes with --status, --stop, --restart, --logs and '
            '--attach NAME'
        )


def prefix_arguments(options: Any, has_plan: bool) -> dict[str, str]:
    """
    Return the launch arguments that the options about the prefix stand for.

    :raises WorkspaceError: if a saved plan is launched, whose command lines
      are made already
    """
    given = {
        'launch-prefix': options.launch_prefix,
        'launch-prefix-filter': options.launch_prefix_filter,
    }
    arguments = {n: value for n, value in given.items() if value is not None}
    if arguments and has_plan:
        raise WorkspaceError(
            f'--{next(iter(arguments))} goes with a launch file: the command '
            'lines of a saved plan are made already'
        )
    return arguments


def add_prefix_options(parser: Any) -> None:
    """Add `--launch-prefix` and its filter, as `ros2 launch` has them."""
    parser.add_argument(
        '--launch-prefix',
        metavar='COMMAND',
        help='A command to start executables with, such as "gdb -ex run '
        '--args"; in one word',
    )
    parser.add_argument(
        '--launch-prefix-filter',
        metavar='REGEX',
        help='Use the prefix for executables whose name matches from its '
        'start',
    )
