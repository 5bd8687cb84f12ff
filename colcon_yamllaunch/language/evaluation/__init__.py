# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The walk through the actions, and what it knows on the way.

- `walk` visits the actions in order; it starts from a `request`, which
  also declares the worker for Python launch files.
- `launch_files` reads each launch file once, and `budget` limits what a
  launch may make.
- `attributes` reads the attributes of an action, `call` the arguments of a
  substitution. `scope` has what earlier actions have set, and texts that are
  known or left open.
- `plan_draft` collects the plan, and `findings` problems, packages, programs
  and nodes.
"""
