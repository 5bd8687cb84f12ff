# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How large a sweep may be."""

#: Runs that a sweep may have; a slip of the pen is more often the reason for
#: more of them than a plan for the next years.
MAXIMUM_RUNS = 1_000_000
