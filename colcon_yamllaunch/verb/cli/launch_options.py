# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Read the command line of `colcon launch`."""

from collections.abc import Sequence
import os
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.verb.cli.command_line import named
from colcon_yamllaunch.verb.cli.command_line import read_options
from colcon_yamllaunch.verb.cli.command_line import refuse_unknown
from colcon_yamllaunch.verb.cli.command_line import split_arguments
from colcon_yamllaunch.verb.cli.command_line import split_line
from colcon_yamllaunch.verb.cli.options import ControlOptions
from colcon_yamllaunch.verb.cli.options import LaunchOptions
from colcon_yamllaunch.verb.cli.options import REQUESTS
from colcon_yamllaunch.verb.cli.options import TEXT

#: The launch arguments that options stand for, by their keys.
PREFIXES = ('launch_prefix', 'launch_prefix_filter')


def parse_launch_options(known: Any) -> LaunchOptions:
    """
    Read the whole command line.

    :param known: What colcon's parser has made of it: options that stand
      before the first word, and `positionals`
    :raises UserError: when it makes no sense
    """
    values, positionals, arguments = split_line(known)
    if values.version:
        return LaunchOptions(version=True)
    if values.help_all:
        return LaunchOptions(help_all=True)
    control = _control_options(values, positionals)
    if control is not None:
        read_options(values, 'launch')
        return LaunchOptions(control=control)
    refuse_unknown(positionals, 'launch')
    if values.paths:
        # it takes whatever follows
        more, values.paths = split_arguments(values.paths)
        arguments = more + arguments
    # the process of a new launch is no request to a running one
    attach, values.attach = values.attach, None
    read = read_options(values, 'launch')
    if read.pop('of', None) is not None:
        raise UserError(
            '--of LAUNCH is about a launch that runs, and what else is given '
            'begins one'
        )
    meant = dict(map(named, arguments))
    for key in PREFIXES:
        if key in read:
            meant[key.replace('_', '-')] = read.pop(key)
    options = LaunchOptions(
        positionals=tuple(positionals), arguments=meant, attach=attach, **read
    )
    _refuse_unclear(options)
    return options


def control_action(values: Any, positionals: Sequence[str]) -> str | None:
    """Return what is asked of running launches; None for a new launch."""
    actions = [name.removeprefix('--') for name in REQUESTS]
    if not positionals and values.from_plan is None:
        # with something to launch, these two are about the new launch
        actions += ['attach', 'ui']
    given = (a for a in actions if getattr(values, a) not in (None, False))
    return next(given, None)


def _control_options(
    values: Any, positionals: Sequence[str]
) -> ControlOptions | None:
    action = control_action(values, positionals)
    if action is None:
        return None
    names: Sequence[str] = positionals
    if action == 'attach':
        names = (values.attach,)
    elif action not in ('status', 'ui'):
        names = (*getattr(values, action), *positionals)
    _refuse_options(action, names)
    if action == 'status' and positionals:
        raise UserError(
            f"--status takes no '{positionals[0]}'",
            'it shows all running launches; one of them with --of LAUNCH',
        )
    if action == 'restart' and not (values.restart or positionals):
        raise UserError(
            '--restart needs the NAME of a process or component',
            "'*' means all of them",
        )
    transition = ''
    if action == 'lifecycle':
        names, transition = _read_transition(names)
    return ControlOptions(
        action,
        tuple(names),
        values.of,
        values.follow,
        values.status or TEXT,
        transition,
    )


def _refuse_options(action: str, names: Sequence[str]) -> None:
    """Refuse options that do not exist, which argparse takes for names."""
    if '--all' in names:
        meant = f"--{action} '*' means all of a launch"
        if action in ('status', 'stop'):
            meant = f"--{action} --of '*' means all launches"
        raise UserError("there is no option '--all'", meant)
    refuse_unknown(names, 'launch')


def _read_transition(words: Sequence[str]) -> tuple[Sequence[str], str]:
    """Tell the names of nodes from the transition behind them."""
    from colcon_yamllaunch.common.suggestions import one_of
    from colcon_yamllaunch.engine.components.transitions import TRANSITIONS

    *names, last = words or ('',)
    if last in TRANSITIONS and names:
        return names, last
    if len(words) < 2:
        raise UserError(
            '--lifecycle needs the NAME of a lifecycle node and a transition',
            f'it is one of {", ".join(TRANSITIONS)}',
        )
    raise UserError(
        f"--lifecycle: there is no transition '{last}'",
        one_of(last, TRANSITIONS),
    )


def _refuse_unclear(options: LaunchOptions) -> None:
    if options.from_plan is not None:
        if options.inspects or options.positionals:
            raise UserError('--from-plan FILE takes nothing else to launch')
    elif not (options.positionals or options.schema or options.checks_all):
        if options.paths:
            raise UserError(
                '--paths took all that follows it',
                "put it behind PKG and FILE, or '--' after the paths",
            )
        # most command lines name something
        from colcon_yamllaunch.verb.cli.log_base import workspace_root
        from colcon_yamllaunch.verb.cli.target import launch_commands
        from colcon_yamllaunch.workspace.colcon.package_scan import (
            scan_packages,
        )

        root = workspace_root(options.workspace, ())
        raise UserError(
            'there is nothing to launch',
            'usage: colcon launch PKG FILE, or '
            'colcon launch path/to/file.yaml'
            + launch_commands(scan_packages(root, os.environ)),
        )
    if options.watch is not None and options.timeout and not options.until:
        raise UserError(
            '--watch goes on until it is stopped',
            'with it, --timeout is for what --until waits for',
        )
    if options.until or options.timeout is None or options.for_ is None:
        return
    raise UserError(
        '--for and --timeout exclude one another: the one ends the launch '
        'with success, the other with failure',
        'with --until, --timeout is for what comes before, and --for for '
        'what comes after',
    )
