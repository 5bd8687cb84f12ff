# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The handlers of the actions, and the makers of the substitutions."""
