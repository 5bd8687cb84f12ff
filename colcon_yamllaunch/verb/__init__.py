# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The colcon verbs: arguments in, exit code out.

- `extensions` is what colcon loads: a class for each verb.
- `options` has all options (`option` says what one is), `command_line` reads
  them, `target` finds the workspace and the launch file.
- `launch`, `run`, `sweep` and `create` each have the `main` of a verb. A
  launch goes through `context`, `prepare` (plan and `builds`, with `preflight`
  and `machines`) and `run_launch`. `inspect_launch` and `watch_launch` are
  `--plan` and the like, and `--watch`.
- `controlling` and what it imports act on running launches.
- `completing` answers Tab.

If nothing else is said, an `environment` is the user's, and `known` is what
colcon's parser has read of the command line.
"""
