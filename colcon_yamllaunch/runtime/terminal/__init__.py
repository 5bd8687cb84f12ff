# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The terminal of a launch: who has it, and what its keys have done."""
