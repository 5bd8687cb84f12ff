# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What each verb does when colcon asks for its arguments."""

from functools import partial
import logging
import os
import sys
from typing import Any

from colcon_yamllaunch.verb.cli.command_line import add_options
from colcon_yamllaunch.verb.cli.command_line import hide_rare_options
from colcon_yamllaunch.verb.cli.options import Verb


def add_verb_arguments(parser: Any, verb: Verb) -> dict[str, str]:
    """Add the options of a verb; return the user's environment."""
    open_standard_streams()
    # on a full disk each message to colcon's log would show a traceback
    logging.raiseExceptions = False
    # what colcon adds to the environment is not the user's
    environment = dict(os.environ)
    add_options(parser, verb)
    parser.print_help = partial(_print_help, verb, parser)
    if '_ARGCOMPLETE' in environment:
        from colcon_yamllaunch.verb.completion.completing import complete

        complete(verb, parser, environment)
    return environment


def _print_help(verb: Verb, parser: Any) -> None:
    """Do what argparse does for `--help`, and say if that is impossible."""
    from colcon_yamllaunch.verb.cli.messages import report_errors
    from colcon_yamllaunch.verb.cli.messages import show_help

    hide_rare_options(parser, verb)
    code = report_errors(verb, lambda: show_help(parser))
    if code:
        parser.exit(code)


def open_standard_streams() -> None:
    """
    Open what is closed of standard input, output and error on nothing.

    Otherwise the next file that is opened would take its place, and there
    would be nothing to print to: for Python, the stream is then None.
    """
    streams = (sys.stdin, sys.stdout, sys.stderr)
    if all(stream is not None for stream in streams):
        return
    descriptor = os.open(os.devnull, os.O_RDWR)
    while descriptor <= 2:
        descriptor = os.dup(descriptor)
    os.close(descriptor)
    sys.stdin = sys.stdin or os.fdopen(0, closefd=False)
    sys.stdout = sys.stdout or os.fdopen(1, 'w', closefd=False)
    sys.stderr = sys.stderr or os.fdopen(2, 'w', closefd=False)
