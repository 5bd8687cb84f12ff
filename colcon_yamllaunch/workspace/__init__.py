# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The workspace: its packages, their build, the sourced environment.

Start with `workspace_session`, the workspace of a launch with the packages as
its launch file sees them, and `builds`, the builds of a launch.

- `packages/` finds the workspace and its packages, and the files and programs
  in them. `package.closure` returns the packages that a launch needs,
  `build_files` reads CMake files and `setup.py`.
- `freshness/` decides whether a package is built (`freshness`), from the
  record of its last build (`build_record`) and what has changed since.
- `building/` builds what is stale (`update`), one launch at a time
  (`build_lock`). `colcon/` is the only part that uses colcon
  (`colcon_adapter`), and keeps what it said (`colcon_cache`).
- `environment/` sources `setup.bash` in a bash subshell (`sourcing`), or
  returns the same variables from its cache (`environment_cache`).
- `create/` makes packages (`colcon create`).
"""
