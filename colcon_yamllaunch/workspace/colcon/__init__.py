# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Requests to colcon, and the cache of its answers.

`colcon_adapter` has all requests to colcon, `colcon_cache` keeps the answers,
and `package_scan` finds packages without colcon, for completion.
"""
