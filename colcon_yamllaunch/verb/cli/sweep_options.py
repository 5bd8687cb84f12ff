# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Read the command line of `colcon sweep`."""

from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.verb.cli.command_line import named
from colcon_yamllaunch.verb.cli.command_line import read_options
from colcon_yamllaunch.verb.cli.command_line import refuse_unknown
from colcon_yamllaunch.verb.cli.command_line import split_line
from colcon_yamllaunch.verb.cli.launch_options import pop_prefixes
from colcon_yamllaunch.verb.cli.launch_options import refuse_paths_alone
from colcon_yamllaunch.verb.cli.launch_options import refuse_two_ends
from colcon_yamllaunch.verb.cli.options import SweepOptions

_USAGE = (
    'usage: colcon sweep PKG FILE name:=1..100, or '
    'colcon sweep path/to/file.yaml name:=1..100'
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
    read = read_options(values, 'sweep')
    fixed = pop_prefixes(read)
    given: dict[str, str] = {}
    for name, value in map(named, arguments):
        if name in given:
            raise UserError(
                f"the launch argument '{name}' is given twice",
                'several values are written as one list: '
                f'{name}:={given[name]},{value}',
            )
        given[name] = value
    options = SweepOptions(
        positionals=tuple(positionals), arguments=given, fixed=fixed, **read
    )
    _refuse_unclear(options)
    return options


def _refuse_unclear(options: SweepOptions) -> None:
    if not options.positionals:
        refuse_paths_alone(options)
        raise UserError('there is nothing to launch', _USAGE)
    names = [metric.name for metric in options.metric]
    for name in names:
        if names.count(name) > 1:
            raise UserError(
                f"--metric: there are two that are called '{name}'"
            )
    refuse_two_ends(options, 'a run')
