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
from colcon_yamllaunch.verb.cli.command_line import split_line
from colcon_yamllaunch.verb.cli.options import ControlOptions
from colcon_yamllaunch.verb.cli.options import LaunchOptions
from colcon_yamllaunch.verb.cli.options import REQUESTS
from colcon_yamllaunch.verb.cli.options import SweepOptions
from colcon_yamllaunch.verb.cli.options import TEXT


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
    # the process of a new launch is no request to a running one
    attach, values.attach = values.attach, None
    read = read_options(values, 'launch')
    if read.pop('of', None) is not None:
        raise UserError(
            '--of LAUNCH is about a launch that runs, and what else is given '
            'begins one'
        )
    meant = {**dict(map(named, arguments)), **pop_prefixes(read)}
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
        refuse_paths_alone(options)
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
    refuse_two_ends(options, 'the launch')


def refuse_two_ends(options: LaunchOptions | SweepOptions, what: str) -> None:
    """
    Refuse `--for` with `--timeout` if there is no `--until`.

    :param what: What they end
    :raises UserError: if both are given
    """
    if options.until or options.timeout is None or options.for_ is None:
        return
    raise UserError(
        f'--for and --timeout exclude one another: the one ends {what} with '
        'success, the other with failure',
        'with --until, --timeout is for what comes before, and --for for '
        'what comes after',
    )


def refuse_paths_alone(options: LaunchOptions | SweepOptions) -> None:
    """
    Refuse paths without a launch file.

    :raises UserError: if there are paths
    """
    if options.paths:
        raise UserError(
            '--paths took all that follows it',
            "put it behind PKG and FILE, or '--' after the paths",
        )


def pop_prefixes(read: dict[str, Any]) -> dict[str, str]:
    """Remove the options that are launch arguments, and return these."""
    return {
        key.replace('_', '-'): read.pop(key)
        for key in ('launch_prefix', 'launch_prefix_filter')
        if key in read
    }
