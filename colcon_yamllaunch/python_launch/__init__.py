# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Python launch files.

`worker/` is the worker: a program that runs in the sourced environment and
visits a launch file with ROS 2's own `launch`. :mod:`.worker_process` starts
it and exchanges messages with it, and :mod:`.plan_feed` extends the plan while
the launch runs. What its messages mean for the plan is in
`language/python_files/`.
"""
