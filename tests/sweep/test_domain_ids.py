# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Each run has a ROS_DOMAIN_ID of its own."""

from pathlib import Path

from colcon_yamllaunch.sweep.domain_ids import DOMAIN_IDS
from colcon_yamllaunch.sweep.domain_ids import DomainIds


def test_the_ports_of_all_are_free_for_dds() -> None:
    """The default port mapping of RTPS, and Linux's ephemeral ports."""
    for number in DOMAIN_IDS:
        # those of 45 participants
        ports = range(7400 + 250 * number, 7400 + 250 * number + 100)
        assert ports[0] > 7400
        assert ports[-1] < 65536
        assert not set(ports) & set(range(32768, 61000))


def test_nobody_has_the_same(tmp_path: Path) -> None:
    environment = {'TMPDIR': str(tmp_path), 'ROS_DOMAIN_ID': '7'}
    ids = DomainIds(environment, shared=True)
    taken = {ids.take() for _ in range(ids.count)}
    assert taken == {*DOMAIN_IDS} - {7}
    assert ids.take() is None
    # neither in another sweep of the user
    other = DomainIds(environment, shared=True)
    assert other.take() is None
    ids.give_back(5)
    assert other.take() == 5
    assert ids.take() is None
    other.close()
    assert ids.take() == 5
    ids.close()


def test_in_networks_of_their_own_there_are_enough(tmp_path: Path) -> None:
    ids = DomainIds({'TMPDIR': str(tmp_path)}, shared=False)
    taken = [ids.take() for _ in range(300)]
    assert None not in taken
    assert len(set(taken[: ids.count])) == ids.count
    assert not list(tmp_path.iterdir())


def test_a_folder_of_somebody_else_is_not_used(tmp_path: Path) -> None:
    ids = DomainIds({'TMPDIR': str(tmp_path / 'missing')}, shared=True)
    assert ids.take() == 1
    assert ids.take() == 2
