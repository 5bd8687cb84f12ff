# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""colcon in a program that is not its command."""

import os
from pathlib import Path

from colcon_core.location import set_default_config_path
from colcon_core.location import set_default_log_path


def set_up_colcon() -> None:
    """
    Set up what colcon's command does before it calls a verb.

    Nothing is logged to files: all is said.
    """
    set_default_config_path(path=Path('~/.colcon').expanduser())
    if os.environ.get('COLCON_HOME'):
        set_default_config_path(path=os.environ['COLCON_HOME'])
    set_default_log_path(base_path=os.devnull)
