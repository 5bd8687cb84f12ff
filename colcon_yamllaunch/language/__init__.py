# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The ROS 2 launch language: from a launch file to a plan.

Input: a launch file, its arguments and an environment (`evaluation.request`).
Output: a plan, or problems with their positions.

- `syntax/` reads YAML and XML (`yaml_reader`, `xml_reader`) into the tree of
  actions of a file (`launch_tree`); `diagnostics` shows problems, `errors`
  explains syntax errors.
- `vocabulary/` has the tables of actions, substitutions and types.
- `evaluation/` walks through the actions (`walk`) with their `scope`, and
  collects the plan (`plan_draft`) and problems (`findings`). `actions/` has
  the handler of each action.
- `policies/` has the two ways to walk: `evaluate` makes a plan, and `check`
  looks at every branch, also to list launch arguments.
- `python_files/` asks the worker that visits Python launch files (see
  `python_launch/`).
- `reports` writes what a check found.
"""
