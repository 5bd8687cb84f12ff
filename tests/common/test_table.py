# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from colcon_yamllaunch.common.table import decimal_size
import pytest


@pytest.mark.parametrize(
    ('size', 'text'),
    [
        (0, '0 bytes'),
        (999, '999 bytes'),
        (1500, '1.5 kB'),
        (2_000_000_000, '2 GB'),
        (1 << 30, '1.074 GB'),
        (5_000_000_000_000, '5000 GB'),
    ],
)
def test_size_of_a_limit(size, text):
    assert decimal_size(size) == text
