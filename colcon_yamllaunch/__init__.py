# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Build, source and launch a ROS 2 package's launch file (YAML, XML, Python).

The verbs are in `verb/`. They read launch files (`language/`,
`python_launch/`) into a plan (`plan/`), build the packages that it needs
(`workspace/`), and run it:
:mod:`.run` does so from the first process to the exit code, with the engine
(`engine/`), its observers (`observers/`), the control socket (`control/`) and
the terminal (`terminal/`). `watch/`, `sweep/` and `remote/` are optional.
"""

__version__ = '0.1.0'
