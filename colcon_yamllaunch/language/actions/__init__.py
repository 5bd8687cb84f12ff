# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The handlers of the actions, and the makers of the substitutions.

- `handlers` is the table of all actions, and has the handlers of those without
  a module of their own. `process_actions` and `component_actions` have those
  that run something.
- `node_names`, `parameters` and `parameter_files` have what nodes and
  components share.
- `substitution_makers` computes substitutions. `commands` runs those of
  `$(command …)`, and `expressions` those of `$(eval …)`.
"""
