# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The command line of `colcon launch`."""

from collections.abc import Sequence
from dataclasses import field
import os
from pathlib import Path
import re
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine.limits import LOG_LIMIT
from colcon_yamllaunch.engine.output.line_pattern import LinePattern
from colcon_yamllaunch.verb.cli.option_parser import parse_more
from colcon_yamllaunch.verb.cli.option_parser import read_options
from colcon_yamllaunch.verb.cli.option_parser import refuse_unknown
from colcon_yamllaunch.verb.cli.option_scanner import normalised
from colcon_yamllaunch.verb.cli.option_scanner import SEPARATOR
from colcon_yamllaunch.verb.cli.option_table import REQUESTS
from colcon_yamllaunch.verb.cli.option_table import TEXT
from colcon_yamllaunch.verb.cli.option_table import Verb

_ARGUMENT = re.compile(r'[^-][^\s]*?:=|:=')
#: The launch arguments that options stand for, by their keys.
PREFIXES = ('launch_prefix', 'launch_prefix_filter')


@dataclass(frozen=True, slots=True)
class ControlOptions:
    """
    What the user asks of running launches.

    :param action: `status`, `stop`, `restart`, `lifecycle`, `logs`, `attach`
      or `ui`
    :param names: The processes and components, by name or glob
    :param launch: Which launch is meant: its package, launch file, title or
      process id; None when that is clear
    :param follow: Whether `logs` waits for more
    :param status_format: How `status` is shown
    :param transition: What `lifecycle` has nodes do
    """

    action: str
    names: tuple[str, ...] = ()
    launch: str | None = None
    follow: bool = False
    status_format: str = TEXT
    transition: str = ''


@dataclass(frozen=True, slots=True)
class LaunchOptions:
    """
    What the user asks for; the options by their keys in the table.

    :param positionals: The package and the launch file, or a path
    :param control: What is asked of running launches, if anything is; then
      there is nothing else
    """

    positionals: tuple[str, ...] = ()
    arguments: dict[str, str] = field(default_factory=dict)
    control: ControlOptions | None = None
    version: bool = False
    show_args: bool = False
    check: str | None = None
    portable: bool = False
    plan: str | None = None
    run_commands: bool = False
    from_plan: Path | None = None
    schema: bool = False
    workspace: Path | None = None
    paths: tuple[str, ...] | None = None
    no_build: bool = False
    build_all: bool = False
    build_args: tuple[str, ...] = ()
    why: bool = False
    force: bool = False
    quiet: bool = False
    verbose: bool = False
    tty: bool = False
    no_color: bool = False
    no_status: bool = False
    log_limit: int | None = LOG_LIMIT
    watch: str | None = None
    on: str | None = None
    deploy: Path | None = None
    until: tuple[LinePattern, ...] = ()
    timeout: float | None = None
    for_: float | None = None
    junit: Path | None = None
    attach: str | None = None
    ui: bool = False

    @property
    def is_deployed(self) -> bool:
        """Whether anything is to run on other machines."""
        return self.on is not None or self.deploy is not None

    @property
    def inspects(self) -> bool:
        """Whether something is shown instead of running."""
        formats = self.check, self.plan
        return self.show_args or self.schema or formats != (None, None)

    @property
    def checks_all(self) -> bool:
        """Whether all launch files of the workspace are to be checked."""
        names_none = not self.positionals and not self.arguments
        return self.check is not None and names_none

    @property
    def runs(self) -> bool:
        """Whether what is in the workspace may be run."""
        return not self.inspects or self.run_commands


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
    control = _control_options(values, positionals)
    if control is not None:
        read_options(values, 'launch')
        return LaunchOptions(control=control)
    refuse_unknown(positionals, 'launch')
    if values.paths is not None:
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
    options = LaunchOptions(tuple(positionals), meant, attach=attach, **read)
    _refuse_unclear(options)
    return options


def split_line(
    known: Any, verb: Verb = 'launch'
) -> tuple[Any, list[str], list[str]]:
    """
    Tell options, other words and launch arguments apart, in any order.

    Return the values of all options, the words that belong to none (and
    options that do not exist), and the launch arguments.

    :raises UserError: when an option lacks its value
    """
    words = [word for word in known.positionals if word != SEPARATOR]
    # an option that takes any number of values would take them, too
    arguments, words = split_arguments(normalised(words, verb))
    values, positionals = parse_more(words, known, verb)
    return values, positionals, arguments


def _control_options(
    values: Any, positionals: Sequence[str]
) -> ControlOptions | None:
    """Return what is asked of running launches; None for a new launch."""
    actions = [name.removeprefix('--') for name in REQUESTS]
    given = [name for name in actions if getattr(values, name) is not None]
    launches = positionals or values.from_plan is not None
    if values.attach is not None and not launches:
        given.append('attach')
    if values.ui and not launches:
        given.append('ui')
    if not given:
        return None
    action = given[0]
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


def split_arguments(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Separate the launch arguments from the other words."""
    arguments = [word for word in words if _ARGUMENT.match(word)]
    return arguments, [word for word in words if not _ARGUMENT.match(word)]


def named(word: str) -> tuple[str, str]:
    """
    Return a launch argument and its value.

    :raises UserError: when it has no name
    """
    name, _, value = word.partition(':=')
    if not name:
        raise UserError(
            f"the launch argument '{word}' has no name",
            'it is written name:=value',
        )
    return name, value


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
