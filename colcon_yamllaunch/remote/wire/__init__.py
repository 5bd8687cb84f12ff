# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The messages of a connection to a machine.

:mod:`.frames` reads and writes them, and :mod:`.numbered` delivers each
exactly once.
"""
