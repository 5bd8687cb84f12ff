# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Who is meant by a part of a name."""

from colcon_yamllaunch.terminal.keys import matching

NAMES = {
    'talker-2': ('talker-2', '/left/talker', 'left/talker', 'talker'),
    'left': ('left', '/left'),
    'Leftover': ('Leftover',),
    'map': ('map', '/world/map', 'demo::Map'),
}


def test_the_whole_name_comes_first_then_its_start_then_a_part() -> None:
    assert matching('left', NAMES) == ['left', 'talker-2', 'Leftover']
    assert matching('/left', NAMES) == ['left', 'talker-2']
    assert matching('over', NAMES) == ['Leftover']


def test_case_is_no_matter() -> None:
    assert matching('LEFTO', NAMES) == ['Leftover']
    assert matching('demo::map', NAMES) == ['map']


def test_the_full_names_of_nodes_count() -> None:
    assert matching('/world/', NAMES) == ['map']
    assert matching('left/talker', NAMES) == ['talker-2']


def test_nothing_means_all_in_the_order_of_the_plan() -> None:
    assert matching('', NAMES) == list(NAMES)
    assert matching('none', NAMES) == []
