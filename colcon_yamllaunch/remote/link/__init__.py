# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The launcher's side of the parts on machines, while the launch runs.

:mod:`.remote_parts` is what the engine uses. :mod:`.remote_part` is the part
on one machine, and :mod:`.machine_link` its connection: it detects a loss and
connects again.
"""
