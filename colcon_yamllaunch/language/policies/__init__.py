# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The policies of the walk: running and checking.

`evaluate` makes a plan. `check` looks at every branch and runs nothing;
`cross_checks` compares arguments and node names once all is read, and
`portability` finds what ROS 2 does not accept.
"""
