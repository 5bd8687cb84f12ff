# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The modules of the host program import one another from their folder."""

from pathlib import Path
import sys

from colcon_yamllaunch import ros

FOLDER = Path(next(iter(ros.__path__)), 'launch_host')

# at the end: no other test is to find anything there
sys.path.append(str(FOLDER))
