# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which processes take much of a processor."""

from types import SimpleNamespace

from colcon_yamllaunch.control import resource_usage
from colcon_yamllaunch.control.resource_usage import UsageSample
from colcon_yamllaunch.terminal import status_model
from colcon_yamllaunch.terminal.status_model import CpuShares
import pytest


@pytest.fixture
def machine(monkeypatch):
    """Return a machine with two processors."""
    made = SimpleNamespace(idle=0.0, seconds={}, looks=0)

    def sample_usage(groups, clock):
        made.looks += 1
        sizes = dict.fromkeys(groups, 0)
        return UsageSample(
            clock(), {g: made.seconds[g] for g in groups}, sizes
        )

    monkeypatch.setattr(resource_usage, 'sample_usage', sample_usage)
    monkeypatch.setattr(status_model.os, 'cpu_count', lambda: 2)
    monkeypatch.setattr(status_model, '_idle_seconds', lambda: made.idle)
    monkeypatch.setattr(
        status_model.cgroup, 'process_folder', lambda pid: None
    )
    return made


def test_idle_machine_measures_no_process(machine):
    shares = CpuShares()
    for now in range(0, 10, 2):
        machine.idle = 2 * now - 0.1
        assert shares.measure({'a': 7}, float(now)) == {}
    assert machine.looks == 0


def test_busy_machine_returns_shares_of_one_processor(machine):
    shares = CpuShares()
    groups = {'a': 7, 'b': 8}
    for now in range(0, 10, 2):
        machine.seconds = {7: 0.9 * now, 8: 0.1 * now}
        found = shares.measure(groups, float(now))
    assert found == {'a': pytest.approx(0.9), 'b': pytest.approx(0.1)}
    # one that was started anew begins from nothing
    machine.seconds = {9: 5.0, 8: 1.0}
    found = shares.measure({'a': 9, 'b': 8}, 10.0)
    assert found == {'a': 0.0, 'b': pytest.approx(0.1)}


def test_idle_control_group_measures_no_process(machine, monkeypatch):
    monkeypatch.setattr(
        status_model.cgroup, 'process_folder', lambda _: '/cgroup/launch/0'
    )
    monkeypatch.setattr(
        status_model.cgroup, 'processor_time', {'/cgroup/launch': 0.0}.get
    )
    shares = CpuShares()
    for now in range(0, 10, 2):
        assert shares.measure({'a': 7}, float(now)) == {}
    assert machine.looks == 0
    for now in range(10, 16, 2):
        spent = 0.75 * (now - 10) + 8.0
        machine.seconds = {7: spent}
        monkeypatch.setattr(
            status_model.cgroup,
            'processor_time',
            {'/cgroup/launch': spent}.get,
        )
        found = shares.measure({'a': 7}, float(now))
    assert found == {'a': pytest.approx(0.75)}


def test_idle_seconds_are_read_from_proc():
    assert status_model._idle_seconds() > 0.0
