# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from support.controlled import no_shared_folders

__all__ = ['no_shared_folders']
