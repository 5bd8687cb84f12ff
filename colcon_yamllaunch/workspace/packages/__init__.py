# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The packages of a workspace: where they and their files are.

- `workspace_root` finds the workspace, `package_index` its packages, and
  `package_locator` the installed files of each `package`.
- `launch_files` chooses a launch file, and `missing_files` explains files that
  are not installed.
- `build_files` reads CMake files and `setup.py`, and `python_modules` finds
  imports; neither runs anything.
"""
