# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The foot of the terminal of a launch: its status block, and its keys."""
