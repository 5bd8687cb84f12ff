# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The walk through the actions, and what it knows on the way.

- `walk` visits the actions in order; it starts from a `request`.
- `attributes` reads the attributes of an action, `values` has texts that are
  known or left open, `scope` what earlier actions have set.
- `findings` collects problems, packages, programs and nodes.
- `launch_worker` is the worker for Python launch files, as the walk sees
  it.
"""
