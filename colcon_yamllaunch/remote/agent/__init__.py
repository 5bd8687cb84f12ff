# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The program on a machine.

It needs only Python's standard library. :mod:`.machine_agent` answers
requests before the launch, and :mod:`.part_engine` runs a part.
:mod:`.uplink` is its connection to the launcher, and stops the part if nothing
is heard of it.
"""
