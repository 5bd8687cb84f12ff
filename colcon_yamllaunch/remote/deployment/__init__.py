# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The deployment file: which machines there are, and what runs where.

:mod:`.deployment_file` reads it, :mod:`.placement` cuts a plan into the parts
of the machines, and :mod:`.remote_paths` translates paths of the workspace.
"""
