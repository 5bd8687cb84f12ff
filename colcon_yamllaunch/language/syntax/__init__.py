# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""From the bytes of a launch file to the tree of its actions."""
