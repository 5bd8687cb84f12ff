# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The environment that setup scripts make.

`sourcing` runs a setup script, `environment_cache` keeps its result, and
`hooks` knows what the environment hooks of packages do.
"""
