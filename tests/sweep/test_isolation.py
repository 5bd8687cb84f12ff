# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Networks, domains, and the end with the parent."""

from collections.abc import Callable
import os
from pathlib import Path
import socket

from colcon_yamllaunch.sweep import isolation
import pytest

DEADLINE = 30


def in_child(action: Callable[[], str]) -> str:
    """Return what an action in a fork returns."""
    reader, writer = os.pipe()
    pid = os.fork()
    if not pid:
        try:
            os.write(writer, action().encode() or b' ')
        except BaseException as e:  # noqa: BLE001 - the parent tells
            os.write(writer, f'error: {e!r}'.encode())
        finally:
            os._exit(0)
    os.close(writer)
    with open(reader, 'rb') as file:
        said = file.read().decode()
    os.waitpid(pid, 0)
    return said


@pytest.fixture
def network() -> None:
    reason = isolation.reason_for_no_network()
    if reason:
        pytest.skip(f'no process can have a network of its own: {reason}')


@pytest.mark.usefixtures('network')
def test_a_process_can_enter_its_own_network() -> None:
    outside = socket.create_server(('127.0.0.1', 0))
    port = outside.getsockname()[1]
    uid = os.getuid()

    def look() -> str:
        isolation.enter_own_network()
        # the same port, as nobody else has it here
        with (
            socket.create_server(('127.0.0.1', port)) as inside,
            socket.create_connection(('127.0.0.1', port)),
        ):
            inside.accept()[0].close()
        names = ' '.join(name for _, name in socket.if_nameindex())
        assert os.getuid() == uid
        Path('/dev/shm/colcon-sweep-test').write_text('x')
        return names

    with outside:
        assert in_child(look).split()[0] == 'lo'
    # neither is what is shared there seen here
    assert not Path('/dev/shm/colcon-sweep-test').exists()


def test_dds_ports_of_all_domains_are_free() -> None:
    """The default port mapping of RTPS, and Linux's ephemeral ports."""
    for number in isolation.DOMAIN_IDS:
        # those of 45 participants
        ports = range(7400 + 250 * number, 7400 + 250 * number + 100)
        assert ports[0] > 7400
        assert ports[-1] < 65536
        assert not set(ports) & set(range(32768, 61000))


def test_concurrent_runs_get_different_domains(tmp_path: Path) -> None:
    environment = {'TMPDIR': str(tmp_path), 'ROS_DOMAIN_ID': '7'}
    ids = isolation.DomainIds(environment, shared=True)
    taken = {ids.reserve() for _ in range(ids.count)}
    assert taken == {*isolation.DOMAIN_IDS} - {7}
    assert ids.reserve() is None
    # neither in another sweep of the user
    other = isolation.DomainIds(environment, shared=True)
    assert other.reserve() is None
    ids.release(5)
    assert other.reserve() == 5
    assert ids.reserve() is None
    other.close()
    assert ids.reserve() == 5
    ids.close()


def test_separate_networks_may_share_domains(tmp_path: Path) -> None:
    ids = isolation.DomainIds({'TMPDIR': str(tmp_path)}, shared=False)
    taken = [ids.reserve() for _ in range(300)]
    assert None not in taken
    assert len(set(taken[: ids.count])) == ids.count
    assert not list(tmp_path.iterdir())


def test_domains_work_without_a_lock_folder(tmp_path: Path) -> None:
    ids = isolation.DomainIds(
        {'TMPDIR': str(tmp_path / 'missing')}, shared=True
    )
    assert ids.reserve() == 1
    assert ids.reserve() == 2
