# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The part of the launch language that needs the worker for Python launch files.

Input: a launch file in Python, or an action or substitution of another
package. Output: entries of the plan.

- Start reading at `python_visit`. `python_source` reads what stands in a file
  that is not run, and `exposed_actions` has the actions of other packages.
- `worker_dialogue` sends requests and makes entries of the answers,
  `worker_scope` translates scopes, and `growing_launch` handles answers while
  the launch runs.
"""
