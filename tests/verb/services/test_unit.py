# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Unit files and environments, as systemd reads them."""

import subprocess

from colcon_yamllaunch.plan.member_settings import MemberSettings
from colcon_yamllaunch.plan.plan import Plan, Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.service.unit import (
    environment_text,
    kept_variables,
    STOP_MARGIN,
    stop_seconds,
    Unit,
)

AT = Position('/ws/demo.yaml', 1, 1)


def process(label: str, seconds: float, *after: str) -> Process:
    """Return a process that may take some seconds to stop."""
    settings = MemberSettings(AT, after=after)
    return Process(
        *(label, ('true',), '/', AT),
        sigterm_timeout=seconds,
        sigkill_timeout=1.0,
        settings=settings,
    )


def test_time_to_stop_is_that_of_all_stages() -> None:
    plan = Plan((process('a', 1), process('b', 5), process('c', 20, 'a', 'b')))
    assert stop_seconds(plan) == 6 + 21 + STOP_MARGIN
    assert stop_seconds(Plan()) == STOP_MARGIN


def test_special_characters_are_not_replaced() -> None:
    unit = Unit(
        *('x', '50% of\nit', ['/a b', '%h', '$HOME', '"', '\\'], '/e%', None),
        has_journal=True,
    )
    lines = unit.text(Plan()).splitlines()
    assert lines[0].endswith(' 50%% of it')
    assert r'ExecStart="/a b" "%%h" "$$HOME" "\"" "\\"' in lines
    assert 'EnvironmentFile=/e%%' in lines


def test_environment_is_read_back_exactly() -> None:
    # systemd unquotes as a shell does between double quotes
    values = {'A': 'a "b" `c` $d \\e\nf\'g  ', 'B': '', 'C': 'ä;#='}
    text = environment_text({**values, 'BAD': '\udcff'})
    printed = subprocess.run(
        ['env', '-i', 'sh', '-c', f'set -a\n{text}exec env -0'],
        capture_output=True,
        check=True,
    ).stdout.decode()
    found = dict(item.split('=', 1) for item in printed.split('\0')[:-1])
    assert {k: v for k, v in found.items() if k != 'PWD'} == values


def test_variables_of_a_session_are_not_kept() -> None:
    user = {'PATH': '/bin', 'TOKEN': 'x', 'ROS_DOMAIN_ID': '1', 'PWD': '/'}
    sourced = {**user, 'PATH': '/ws/bin:/bin', 'MODELS': '/ws', 'PWD': '/a'}
    assert kept_variables(sourced, user) == {
        'PATH': '/ws/bin:/bin',
        'ROS_DOMAIN_ID': '1',
        'MODELS': '/ws',
    }
