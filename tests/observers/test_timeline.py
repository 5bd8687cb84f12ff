# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How a launch started, from the records of its events."""

from html.parser import HTMLParser
from typing import Any
from xml.etree import ElementTree

from colcon_yamllaunch.observers.timeline import (
    chain_as_text,
    page,
    Timeline,
    timeline_of,
)
from hypothesis import given
from hypothesis import strategies as st


def record(time: float, event: str, label: str = '', **more: Any) -> Any:
    named = {'label': label, 'name': label} if label else {}
    return {'time': 1000.0 + time, 'event': event, **named, **more}


RECORDS = [
    record(0.0, 'started', 'driver', pid=1),
    record(0.0, 'started', 'map', pid=2),
    record(0.1, 'waiting', 'nav', labels=['driver', 'map']),
    record(0.1, 'waiting', 'rviz', labels=['nav']),
    record(1.0, 'ready', 'driver', seconds=1.0),
    record(1.0, 'waiting', 'nav', labels=['map']),
    record(2.5, 'ready', 'map', seconds=2.5),
    record(2.5, 'started', 'nav', pid=3),
    record(3.0, 'ready', 'nav', seconds=0.5),
    record(3.0, 'started', 'rviz', pid=4),
    record(3.0, 'ready', 'rviz', seconds=0.0),
    # a restart is no start
    record(4.0, 'exited', 'driver', pid=1),
    record(4.5, 'started', 'driver', pid=5),
    record(60.0, 'ended', exit_code=0),
]


def drawing(timeline: Timeline) -> ElementTree.Element:
    text = page(timeline, 'a & b')
    start = text.index('<svg')
    return ElementTree.fromstring(text[start : text.index('</svg>') + 6])


def test_the_longest_chain_leads_to_the_last_one() -> None:
    assert chain_as_text(timeline_of(RECORDS)).splitlines()[1:] == [
        'rviz @3.000 s +0.000 s',
        '└─nav @3.000 s +0.500 s',
        '  └─map @2.500 s +2.500 s',
    ]


def test_page_draws_each_start() -> None:
    timeline = timeline_of(RECORDS)
    assert [start.label for start in timeline.starts] == [
        *('driver', 'map', 'nav', 'rviz'),
    ]
    bars = [
        (bar.get('class'), bar[0].text)
        for bar in drawing(timeline).iter('rect')
    ]
    assert ('waiting', 'nav: waiting 0.100 s to 2.500 s') in bars
    assert ('starting', 'map: starting 0.000 s to 2.500 s') in bars
    # what happens long after the start is not drawn
    assert ('ready', 'map: ready 2.500 s on') in bars
    assert sum(1 for _ in drawing(timeline).iter('path')) == 3
    assert '<h1>How a &amp; b started</h1>' in page(timeline, 'a & b')


def test_what_was_not_ready_is_named() -> None:
    timeline = timeline_of(
        [
            record(0.0, 'started', 'driver', pid=1),
            record(0.0, 'waiting', 'nav', labels=['driver']),
            record(5.0, 'not_ready', 'driver', conditions=['the file x']),
            record(7.0, 'not_started', 'nav', labels=['driver']),
            record(8.0, 'ended', exit_code=1),
        ]
    )
    assert chain_as_text(timeline).splitlines()[1:] == [
        'driver @0.000 s +0.000 s',
        'driver was not ready: waited for the file x',
        'nav was not ready: not started',
    ]
    kinds = [bar.get('class') for bar in drawing(timeline).iter('rect')]
    assert kinds == ['failed', 'waiting']


def test_launch_that_does_not_know_readiness_has_starts_only() -> None:
    timeline = timeline_of(
        [
            record(0.0, 'started', 'a', pid=1),
            record(2.0, 'loaded', 'b', node='/b'),
        ]
    )
    assert chain_as_text(timeline).splitlines()[1:] == ['b @2.000 s']


JSON = st.recursive(
    st.none() | st.booleans() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner, max_size=2),
    max_leaves=3,
)
NAMES = st.sampled_from(
    [
        *('started', 'waiting', 'ready', 'not_ready', 'not_started'),
        *('start_failed', 'exited', 'loaded', 'ended'),
    ]
)


@given(
    st.lists(
        st.fixed_dictionaries(
            {'time': st.floats(0, 1e9) | JSON, 'event': NAMES | JSON},
            optional={
                'label': st.text(max_size=3) | JSON,
                'labels': st.lists(st.text(max_size=3)) | JSON,
                'conditions': st.lists(st.text(max_size=3)),
                'reason': JSON,
            },
        ),
        max_size=6,
    )
)
def test_any_records_make_a_page(records: list[dict[str, Any]]) -> None:
    timeline = timeline_of(records)
    chain_as_text(timeline)
    HTMLParser().feed(page(timeline, 'x'))
