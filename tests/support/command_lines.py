# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Command lines, read as colcon reads them before it calls a verb."""

import argparse

from colcon_yamllaunch.verb.command_line import (
    add_options,
    parse_launch_options,
    parse_sweep_options,
)
from colcon_yamllaunch.verb.options import LaunchOptions, SweepOptions, Verb


def known(verb: Verb, *words: str) -> argparse.Namespace:
    """Return what colcon's parser makes of words behind a verb."""
    parser = argparse.ArgumentParser()
    parser.add_argument('positionals', nargs=argparse.REMAINDER)
    add_options(parser, verb)
    return parser.parse_args(words)


def launch_options(*words: str) -> LaunchOptions:
    """Return the options of `colcon launch` with some words."""
    return parse_launch_options(known('launch', *words))


def sweep_options(*words: str) -> SweepOptions:
    """Return the options of `colcon sweep` with some words."""
    return parse_sweep_options(known('sweep', *words))
