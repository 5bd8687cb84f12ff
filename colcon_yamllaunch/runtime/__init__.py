# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The engine that runs a plan: processes, output, logs and signals."""
