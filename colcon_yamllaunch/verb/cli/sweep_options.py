# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The command line of `colcon sweep`."""

from dataclasses import field
from pathlib import Path
from typing import Any
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine.output.line_pattern import LinePattern
from colcon_yamllaunch.verb.cli.launch_options import LaunchOptions
from colcon_yamllaunch.verb.cli.launch_options import named
from colcon_yamllaunch.verb.cli.launch_options import PREFIXES
from colcon_yamllaunch.verb.cli.launch_options import split_arguments
from colcon_yamllaunch.verb.cli.launch_options import split_line
from colcon_yamllaunch.verb.cli.option_parser import read_options
from colcon_yamllaunch.verb.cli.option_parser import refuse_unknown
from colcon_yamllaunch.verb.cli.option_table import RUN_LOG_LIMIT

if TYPE_CHECKING:
    from colcon_yamllaunch.sweep.run import Metric

_USAGE = (
    'usage: colcon sweep PKG FILE name:=1..100, or '
    'colcon sweep path/to/file.yaml name:=1..100'
)


@dataclass(frozen=True, slots=True)
class SweepOptions:
    """
    What the user asks for; the options by their keys in the table.

    :param positionals: The package and the launch file, or a path
    :param arguments: What was written for each launch argument
    :param fixed: Launch arguments that options stand for
    """

    positionals: tuple[str, ...] = ()
    arguments: dict[str, str] = field(default_factory=dict)
    fixed: dict[str, str] = field(default_factory=dict)
    version: bool = False
    table: Path | None = None
    repeat: int = 1
    jobs: int | None = None
    on: tuple[str, ...] | None = None
    share_network: bool = False
    again: str | None = None
    until: tuple[LinePattern, ...] = ()
    timeout: float | None = None
    for_: float | None = None
    metric: 'tuple[Metric, ...]' = ()
    require: float | None = None
    results: Path | None = None
    workspace: Path | None = None
    paths: tuple[str, ...] | None = None
    no_build: bool = False
    build_all: bool = False
    build_args: tuple[str, ...] = ()
    why: bool = False
    force: bool = False
    quiet: bool = False
    tty: bool = False
    no_color: bool = False
    log_limit: int | None = RUN_LOG_LIMIT

    def as_launch(self) -> LaunchOptions:
        """Return the options of each of its launches, without arguments."""
        return LaunchOptions(
            self.positionals,
            dict(self.fixed),
            workspace=self.workspace,
            paths=self.paths,
            no_build=self.no_build,
            build_all=self.build_all,
            build_args=self.build_args,
            why=self.why,
            force=self.force,
            quiet=self.quiet,
            no_color=self.no_color,
        )


def parse_sweep_options(known: Any) -> SweepOptions:
    """
    Read the whole command line.

    :param known: What colcon's parser has made of it: options that stand
      before the first word, and `positionals`
    :raises UserError: when it makes no sense
    """
    values, positionals, arguments = split_line(known, 'sweep')
    if values.version:
        return SweepOptions(version=True)
    refuse_unknown(positionals, 'sweep')
    if values.paths is not None:
        # it takes whatever follows
        more, values.paths = split_arguments(values.paths)
        arguments = more + arguments
    read = read_options(values, 'sweep')
    fixed = {
        key.replace('_', '-'): read.pop(key) for key in PREFIXES if key in read
    }
    given: dict[str, str] = {}
    for name, value in map(named, arguments):
        if name in given:
            raise UserError(
                f"the launch argument '{name}' is given twice",
                'several values are written as one list: '
                f'{name}:={given[name]},{value}',
            )
        given[name] = value
    options = SweepOptions(tuple(positionals), given, fixed, **read)
    _refuse_unclear(options)
    return options


def _refuse_unclear(options: SweepOptions) -> None:
    if not options.positionals:
        if options.paths:
            raise UserError(
                '--paths took all that follows it',
                "put it behind PKG and FILE, or '--' after the paths",
            )
        raise UserError('there is nothing to launch', _USAGE)
    names = [metric.name for metric in options.metric]
    for name in names:
        if names.count(name) > 1:
            raise UserError(
                f"--metric: there are two that are called '{name}'"
            )
    both = options.timeout is not None and options.for_ is not None
    if both and not options.until:
        raise UserError(
            '--for and --timeout exclude one another: the one ends a run with '
            'success, the other with failure',
            'with --until, --timeout is for what comes before, and --for for '
            'what comes after',
        )
