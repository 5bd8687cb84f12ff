# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Starting programs, and what the system reports about them.

:mod:`.spawn` starts a program in its own process group, :mod:`.cgroup` in the
control group of the launch. :mod:`.children` collects ended and suspended
children, and :mod:`.core_dumps` finds core dumps.
"""
