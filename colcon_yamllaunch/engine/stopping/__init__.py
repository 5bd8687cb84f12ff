# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Stopping processes: SIGINT, SIGTERM, SIGKILL.

:mod:`.launch_stop` stops processes step by step and ends what they left
running, which :mod:`.launch_scan` finds. :mod:`.guard` is a process that stops
everything if the launcher is killed; :mod:`.guard_link` starts it.
"""
