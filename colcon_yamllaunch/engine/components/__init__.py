# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Components and lifecycle nodes: what happens in the ROS graph, and when."""
