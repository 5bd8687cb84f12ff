# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The colcon verbs: arguments in, exit code out.

- `launch`, `run`, `sweep` and `create` are what colcon loads (with `argv` and
  `environment_variables`): a class for each verb, derived from `options_verb`.
- `options` describes all options, `command_line` reads them, `target` finds
  the workspace and the launch file.
- `launch_main`, `run_main`, `sweep_main` and `create_main` execute a verb. All
  steps of a launch are functions of one `LaunchContext` (`context`): `prepare`
  evaluates the launch file, builds and checks, on other `machines` too, and
  `run_launch` runs the plan; `log_folders` has its logs. `inspect_launch`
  shows it instead (`--plan`, `--check`); `watch_launch` (`--watch`) and
  `sweep_main` prepare it several times, and `demo` launches a sample.
- `controlling` acts on running launches. `reading_logs` shows logs, `timeline`
  how a launch started, and `background_launch` a new launch on the full
  screen.
- `completing` answers Tab, with `process_candidates`.
- `code_state` says which code a sweep ran; it asks `git`.

If nothing else is said, an `environment` is the user's, and `known` is what
colcon's parser has read of the command line.
"""
