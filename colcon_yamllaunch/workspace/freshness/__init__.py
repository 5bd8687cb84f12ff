# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Whether what was built last still is what a build would give now.

`freshness` decides that. `build_record` has the last build, `source_changes`
what changed in the source since, `build_inputs` the other files that the build
read, and `build_products` the files that it made.
"""
