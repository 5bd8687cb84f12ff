# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Build, source and launch a ROS 2 package's YAML launch file."""

__version__ = '0.1.0'
