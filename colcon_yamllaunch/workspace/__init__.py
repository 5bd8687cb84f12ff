# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The workspace: its packages, their build, the sourced environment.

- `packages/` finds the workspace and its packages, and the files and programs
  in them. `closure` returns the packages that a launch needs.
- `freshness/` decides whether a package is built (`build_decision`), from the
  record of its last build and what has changed since (`source_changes`).
- `building/` builds what is stale (`update`), one launch at a time
  (`build_lock`). `colcon/` is the only part that uses colcon
  (`colcon_adapter`).
- `environment/` sources `setup.bash` in a bash subshell (`sourcing`), or
  returns the same variables from its cache.
- `extensions/` finds what packages add to the launch language, and `create/`
  makes packages (`colcon create`).
"""
