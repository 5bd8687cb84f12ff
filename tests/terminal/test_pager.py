# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is shown after a pager."""

from unittest.mock import Mock

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.terminal.pager import KEPT, PagedOutput, Pager


def test_held_events_keep_order_and_time(process):
    kitchen = process('kitchen')
    paged = PagedOutput(Mock(Pager))
    happened = (
        events.Output(kitchen, 'stdout', b'21 degrees\n'),
        events.Warned('it is warm'),
        events.Output(kitchen, 'stdout', b'22 degrees\n'),
    )
    for event in happened:
        paged.hold(event)
    times, found = zip(*paged.held(), strict=True)
    assert found == happened
    assert list(times) == sorted(times)
    assert paged.lost == 0


def test_too_much_held_output_drops_the_oldest_output(process):
    kitchen = process('kitchen')
    paged = PagedOutput(Mock(Pager))
    paged.hold(events.Warned('it is warm'))
    line = b'x' * (KEPT // 4 - 1) + b'\n'
    for number in range(6):
        data = b'%d\n%b' % (number, line)
        paged.hold(events.Output(kitchen, 'stdout', data))
    found = [event for _, event in paged.held()]
    assert found[0] == events.Warned('it is warm')
    data = [e.data[:1] for e in found if isinstance(e, events.Output)]
    assert data == [b'3', b'4', b'5']
    assert paged.lost == 6
