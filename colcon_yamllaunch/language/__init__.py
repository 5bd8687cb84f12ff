# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The ROS 2 launch language: from a launch file to a plan."""
