# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The walk through the actions, and what it knows on the way.

- `walk` visits the actions in order; it starts from a `request`, which
  also declares the worker for Python launch files.
- `attributes` reads the attributes of an action. `scope` has what earlier
  actions have set, and texts that are known or left open.
- `findings` collects problems, packages, programs and nodes.
"""
