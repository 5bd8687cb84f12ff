# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What users are told about builds."""

import os
import time

from colcon_yamllaunch.workspace.building.build_report import (
    after_build,
    after_failure,
    before_build,
    explanation,
)
from colcon_yamllaunch.workspace.freshness.build_record import (
    BuildMode,
    Decision,
    Reason,
)
import pytest


def stale(name, *texts, mode=BuildMode.BUILD):
    return Decision(name, tuple(Reason(text, mode) for text in texts))


FLOW = stale('flow', 'src/flow.cpp changed')
MY_PKG = stale('my_pkg', 'new file scripts/new.py')


def test_line_after_a_build():
    assert after_build([FLOW, MY_PKG], 14) == (
        '2 packages built (flow: src/flow.cpp changed; '
        'my_pkg: new file scripts/new.py), 14 up to date'
    )


def test_line_before_a_build():
    assert before_build([FLOW], 1) == (
        'building 1 package (flow: src/flow.cpp changed), 1 up to date…'
    )


@pytest.mark.parametrize(
    ('fresh', 'line'),
    [
        (0, 'no package of the workspace is needed'),
        (1, '1 package up to date'),
        (16, '16 packages up to date'),
    ],
)
def test_line_when_nothing_was_built(fresh, line):
    assert after_build([], fresh) == line


def test_packages_with_the_same_reason_share_it():
    many = [stale(f'pkg_{n}', 'never built') for n in range(100)]
    assert after_build(many, 0) == (
        '100 packages built (pkg_0, pkg_1, pkg_2 and 97 more: never built)'
    )


@pytest.mark.parametrize(
    ('texts', 'line'),
    [
        (('a.cpp changed', 'b.cpp changed'), 'a.cpp, b.cpp changed'),
        (('new file a', 'b changed'), 'new file a, b changed'),
        (
            ('a was deleted', 'b changed', 'c changed', 'd changed'),
            'a was deleted, b, c, d changed',
        ),
        (('a changed', 'base was built', 'the compiler changed'), None),
        (
            [f'src/file_{n}.cpp changed' for n in range(5)],
            'src/file_0.cpp, src/file_1.cpp, src/file_2.cpp, src/file_3.cpp '
            'changed, and 1 more reason',
        ),
        (
            ('a changed', f'{"b" * 80} changed'),
            'a changed, and 1 more reason',
        ),
    ],
)
def test_reasons_have_names_as_far_as_they_fit(texts, line):
    text = after_build([stale('flow', *texts)], 0)
    assert text == f'1 package built (flow: {line or ", ".join(texts)})'


def test_hundred_reasons_make_a_short_line():
    many = [
        stale(f'pkg_{n}', *(f'src/{"x" * 300}{n}{m}.cpp' for m in range(9)))
        for n in range(100)
    ]
    line = after_build(many, 3)
    assert len(line) < 600
    assert '96 more, which --why tells of' in line
    assert ', and 8 more reasons' in line
    assert line.endswith('3 up to date')


@pytest.mark.parametrize(
    ('arguments', 'line'),
    [
        (
            (['flow'], ['base'], ['top']),
            'flow failed to build; 1 package built; not built: top',
        ),
        ((['flow'], [], []), 'flow failed to build'),
        (
            ([], [], ['a', 'b']),
            'the build was interrupted; not built: a, b',
        ),
    ],
)
def test_line_after_a_failure(arguments, line):
    assert after_failure(*arguments) == line


def test_explanation_of_what_is_stale():
    decision = stale('lib', 'a.h changed', 'b.h changed', mode=BuildMode.CLEAN)
    assert explanation(decision, ('top', 'mid', 'lib'), 'demo.yaml') == (
        'lib: to be built, as a.h changed, b.h changed [from scratch]; '
        'needed by demo.yaml → top → mid'
    )


def test_explanation_of_what_is_fresh(monkeypatch):
    monkeypatch.setitem(os.environ, 'TZ', 'UTC')
    time.tzset()
    decision = Decision('lib', built_at=1_795_260_000_000_000_000)
    assert explanation(decision, ('lib',), 'demo.yaml') == (
        'lib: up to date since its build at 2026-11-21 11:20:00; '
        'needed by demo.yaml'
    )
    monkeypatch.undo()
    time.tzset()


def test_explanation_of_many_reasons():
    decision = stale('lib', *(f'{n}.h changed' for n in range(20)))
    line = explanation(decision, ('lib',), 'demo.yaml')
    assert '7.h changed, and 12 more reasons; needed' in line
