# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import sys
from tempfile import TemporaryDirectory

from setuptools import setup

# A folder `build` in the clone would bring deleted modules back.
with TemporaryDirectory() as folder:
    options = {'build': {'build_base': folder}}
    if 'develop' not in sys.argv:
        options['egg_info'] = {'egg_base': folder}
    setup(options=options)
