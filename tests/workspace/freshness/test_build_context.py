# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is said of packages that another one is built on."""

from colcon_yamllaunch.workspace.freshness.build_record import (
    build_identifier,
    BuildContext,
    context_changes,
)

FIRST = build_identifier('1', '1', '1')
SECOND = build_identifier('1', '1', '2')


def test_dependencies_that_come_stay_and_go() -> None:
    before = BuildContext({}, {}, {'base': FIRST, 'mid': FIRST, 'old': FIRST})
    now = BuildContext({}, {}, {'base': FIRST, 'mid': SECOND, 'new': FIRST})
    assert sorted(r.text for r in context_changes(before, now)) == [
        'mid was rebuilt',
        'new is new among what it is built on',
        'old is no longer among what it is built on',
    ]
