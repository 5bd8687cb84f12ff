# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The deployment file: the machines, and the rules for the processes.

:mod:`.deployment_file` reads it, :mod:`.placement` divides a plan into the
parts of the machines, and :mod:`.remote_paths` replaces the paths of the
workspace, and selects the environment variables that are sent
(`sent_variables`).
"""
