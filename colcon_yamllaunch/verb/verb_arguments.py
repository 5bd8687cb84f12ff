# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What each verb does when colcon asks for its arguments."""

import os
from typing import Any

from colcon_yamllaunch.verb.cli.log_base import choose_log_base
from colcon_yamllaunch.verb.cli.option_parser import add_options
from colcon_yamllaunch.verb.cli.option_table import Verb
from colcon_yamllaunch.verb.cli.standard_streams import open_standard_streams


def add_verb_arguments(parser: Any, verb: Verb) -> dict[str, str]:
    """Add the options of a verb; return the user's environment."""
    open_standard_streams()
    # what colcon adds to the environment is not the user's
    environment = dict(os.environ)
    add_options(parser, verb)
    choose_log_base(verb)
    if '_ARGCOMPLETE' in environment:
        from colcon_yamllaunch.verb.completion.completing import complete

        complete(verb, parser, environment)
    return environment
