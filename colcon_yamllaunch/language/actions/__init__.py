# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The handlers of the actions, and the makers of the substitutions.

- `handlers` is the table of all actions. `flow_actions`, `scope_actions`,
  `process_actions` and `component_actions` each have those of one family.
- `node_parameters` and `parameter_files` have the parameters of nodes.
- `substitution_makers` computes substitutions, and `expressions` those of
  `$(eval …)` that a check may compute.
"""
