# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Metrics: how they are written, and what is found for them."""

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.sweep.run import read_metric, RunObserver
import pytest

PROCESS = Process('sim', ('sim',), '/', Position('a.yaml', 1, 1))


def found(metric: str, *outputs: bytes) -> str | None:
    search = RunObserver([read_metric('--metric', metric)])
    for data in outputs:
        search.handle(events.Output(PROCESS, 'stdout', data))
    return next(iter(search.found.values()), None)


def test_last_matching_line_is_the_metric() -> None:
    metric = r'time=reached after ([\d.]+) s'
    assert found(metric, b'nothing\n') is None
    assert found(metric, b'reached after 3.5 s\n') == '3.5'
    lines = b'reached after 1 s\nreached after 2 s\nwell\n'
    assert found(metric, lines, b'reached after 4 s\nbye\n', b'x\n') == '4'


def test_metric_group_may_be_any_group() -> None:
    assert found('a=x=(?:on|(off)|(up))', b'x=up\n') == 'up'
    assert found('a=(.*)=', b'one=two=3\n') == 'one=two'
    assert found(r'a=^(\w+)$', b'\x1b[1mred\x1b[0m\n') == 'red'
    # a line end is no part of a line
    assert found(r'a=speed\s+(\d)', b'speed\n7\nspeed 8\n') == '8'


def test_slow_regex_has_no_value() -> None:
    assert found('a=((a+)+)$', b'a' * 4000 + b'b\n') is None


@pytest.mark.parametrize(
    ('text', 'error'),
    [
        ('time', 'is written name=REGEX'),
        ('time=', 'is written name=REGEX'),
        ('=(x)', "'' is no name of a metric"),
        ('9=(x)', "'9' is no name of a metric"),
        ('time=reached', "'reached' has no group"),
        ('time=(?:x)', 'has no group'),
        ('time=(x', 'is no regular expression'),
    ],
)
def test_wrong_metrics_are_refused(text: str, error: str) -> None:
    with pytest.raises(UserError, match=r'^--metric') as caught:
        read_metric('--metric', text)
    assert error in str(caught.value)
