# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Making packages (`new_package`) and nodes in them (`added_node`).

`sample` copies the sample workspace.
"""
