# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Ending processes: the escalation of signals, and the guard."""
