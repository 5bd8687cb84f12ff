# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from colcon_yamllaunch.terminal.status_block import cut, cut_inside, width
import pytest

RED, RESET = '\x1b[31m', '\x1b[0m'


@pytest.mark.parametrize(
    ('text', 'cells'),
    [
        ('', 0),
        ('kitchen', 7),
        (f'{RED}kitchen{RESET}', 7),
        ('Küche', 5),
        ('Ku\u0308che', 5),
        ('台所', 4),
        ('● ×2', 4),
    ],
)
def test_width_of_a_text_in_cells(text, cells):
    assert width(text) == cells


@pytest.mark.parametrize(
    ('text', 'cells', 'expected'),
    [
        ('kitchen', 7, 'kitchen'),
        ('kitchen', 6, 'kitch…'),
        ('kitchen', 1, '…'),
        ('kitchen', 0, ''),
        ('台所です', 5, '台所…'),
        ('台所です', 4, '台…'),
        (f'{RED}kitchen{RESET}', 4, f'{RED}kit…{RESET}'),
        (f'{RED}kit{RESET}chen', 4, f'{RED}kit{RESET}…{RESET}'),
    ],
)
def test_text_is_cut_to_cells(text, cells, expected):
    assert cut(text, cells) == expected
    assert width(expected) <= cells


@pytest.mark.parametrize(
    ('text', 'cells', 'expected'),
    [
        ('low ×31', 7, 'low ×31'),
        ('very low ×31', 9, 'very… ×31'),
        ('very low ×31', 5, '… ×31'),
        ('very low ×31', 3, '…31'),
        ('very low ×31', 0, ''),
        ('とても台所', 7, 'と…台所'),
        (f'{RED}very low{RESET} ×31', 9, f'{RED}very…{RESET} ×31'),
    ],
)
def test_cut_inside(text, cells, expected):
    assert cut_inside(text, cells, 4) == expected
