# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The part of the launch language that needs the worker for Python launch files.

Input: a launch file in Python, or an action or substitution of another
package. Output: entries of the plan. Start reading at `python_visit`, which
uses `worker_dialogue`; `exposed_actions` is about other packages.
"""
