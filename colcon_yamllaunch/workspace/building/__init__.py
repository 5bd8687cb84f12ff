# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Building packages, by way of colcon.

`update` brings packages up to date, while `build_lock` keeps other launches
out. `build_processes` handles the processes of a build, and `build_report`
says which packages are built, and why.
"""
