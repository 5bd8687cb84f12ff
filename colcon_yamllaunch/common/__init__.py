# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What all rooms may use: plain helpers that know nothing of launching."""
