# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How many random cases a test tries that is asked for few."""

import os

from hypothesis import HealthCheck, settings

#: A busy machine is no failure.
RANDOM = settings(
    max_examples=1000
    if os.environ.get('HYPOTHESIS_PROFILE') == 'long'
    else 20,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
