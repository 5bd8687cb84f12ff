# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What can be done with, and told of, the parts of a launch that runs."""
