# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Connecting with a machine, before the launch.

Start with :mod:`.machine_connection`. :mod:`.connect_process` makes the
command that connects, and runs it and its watchdog. :mod:`.bootstrap` sends
our program, and :mod:`.connection_errors` explains why a machine cannot be
reached. To add a way to reach a machine, see CONTRIBUTING.md.
"""
