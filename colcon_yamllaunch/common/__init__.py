# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""General helpers without knowledge of launches; they import nothing else."""
