# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The base class of our verbs."""

import argparse
from functools import partial
from importlib import import_module
import logging
import os
from typing import Any, TYPE_CHECKING

from colcon_core.plugin_system import satisfies_version
from colcon_core.verb import VerbExtensionPoint

if TYPE_CHECKING:
    from colcon_yamllaunch.verb.options import Verb


class OptionsVerb(VerbExtensionPoint):  # type: ignore[misc]
    """
    A verb: options that are described in `options`, and other words.

    colcon imports the modules of all verbs for every command, so everything
    else is imported when a verb is used.
    """

    NAME: 'Verb'
    USAGE: str
    EPILOG: str
    #: The words that are no options: how many, and their name and help.
    NARGS: str = argparse.REMAINDER
    WORDS: str
    WORDS_HELP: str

    def __init__(self) -> None:
        super().__init__()
        satisfies_version(VerbExtensionPoint.EXTENSION_POINT_VERSION, '^1.0')
        self._environment: dict[str, str] = {}

    def add_arguments(self, *, parser: Any) -> None:  # noqa: D102
        from colcon_yamllaunch.common.messages import open_standard_streams
        from colcon_yamllaunch.verb.command_line import add_options, print_help

        open_standard_streams()
        # on a full disk each message to colcon's log would show a traceback
        logging.raiseExceptions = False
        # what colcon adds to the environment is not the user's
        self._environment = dict(os.environ)
        parser.usage = self.USAGE
        parser.epilog = self.EPILOG
        # an abbreviation could be a word of a program, or a mistake
        parser.allow_abbrev = self.NARGS != argparse.REMAINDER
        parser.add_argument(
            'positionals',
            nargs=self.NARGS,
            metavar=self.WORDS,
            help=self.WORDS_HELP,
        )
        add_options(parser, self.NAME)
        parser.print_help = partial(print_help, parser, self.NAME)
        if '_ARGCOMPLETE' in self._environment:
            from colcon_yamllaunch.verb.completing import complete

            complete(self.NAME, parser, self._environment)

    def main(self, *, context: Any) -> int:  # noqa: D102
        from colcon_yamllaunch.common.messages import report_errors
        from colcon_yamllaunch.engine.loop import accept_signals

        accept_signals()
        return report_errors(self.NAME, partial(self._execute, context.args))

    def _execute(self, known: Any) -> int:
        """Call `main` of the module for this verb, such as `launch_main`."""
        from colcon_yamllaunch.verb.command_line import read_command_line

        options = read_command_line(known, self.NAME)
        if options is None:
            return 0
        module = import_module(f'{__package__}.{self.NAME}_main')
        return int(module.main(options, known, self._environment))
