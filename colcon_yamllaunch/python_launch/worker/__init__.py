# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The worker: a program that visits Python launch files with ROS 2's `launch`.

It runs with the Python of the sourced environment, as `python3
FOLDER-OF-THIS-FILE`. It imports nothing of this project but its own modules,
and nothing of ROS 2 before it has said what is missing. ROS 2's own `launch`
and `launch_ros` visit the descriptions; what would start is only prepared, and
reported to the launcher.

- Start reading at `visit`, which answers requests. `channel` reads and writes
  their lines, and its docstring is the protocol.
- `entries` prepares what would start. `events` runs event handlers, `timers`
  runs timers, and `descriptions` shows both as text.
- `extensions` has actions of other packages, `packages` finds packages, and
  `imports` patches, postpones and reports what is imported.
- `positions` finds where launch files say something, `errors` explains what
  goes wrong.
"""
