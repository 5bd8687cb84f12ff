# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What all parts of the engine share: events, outcomes, limits, time."""
