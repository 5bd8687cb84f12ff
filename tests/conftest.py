# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What all tests share."""

from collections.abc import Generator, Iterator
from functools import cache
import importlib.util
import os
from pathlib import Path
import random
import re
import signal
import socket
import sys
import sysconfig
from typing import Any

from hypothesis import HealthCheck, settings
import pytest
from support.forks import Forks
from support.namespaces import NamespaceMachine, skip_without_namespaces
from support.ros_parts import build_once
from support.ros_setup import read_setup, RosSetup, SKIPPED
from support.slurm import skip_without_slurm, Slurm
from support.sshd import skip_without_sshd, Sshd

pytest_plugins = ['support.language_fixtures', 'support.launch_fixtures']

# The background job of a script ignores Ctrl-C and Ctrl-\, nohup makes SIGHUP
# ignored, and so would all that tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGQUIT, signal.SIG_DFL)
signal.signal(signal.SIGHUP, signal.SIG_DFL)

# the machine's load must never decide a test, so no example has a deadline
settings.register_profile(
    'default',
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile(
    'quick', settings.get_profile('default'), max_examples=10
)
settings.register_profile(
    'long', settings.get_profile('default'), max_examples=10_000
)
settings.load_profile(os.environ.get('HYPOTHESIS_PROFILE', 'default'))

#: The ids whose ports lie below Linux's ephemeral ones (ROS 2's guide to
#: ROS_DOMAIN_ID); 0 is left out, since it is what everybody else uses.
DOMAIN_IDS = range(1, 102)

#: The fixtures with which a test builds, launches or runs nodes of ROS, which
#: makes it one of those that only `make test` runs.
FULL_FIXTURES = frozenset(
    {
        'deployer',
        'forks',
        'make_user',
        'ros_domain_id',
        'ros_parts',
        'ros_setup',
        'user',
    }
)
#: Folders whose tests belong to the contract, whatever they import.
CONTRACT_FOLDERS = frozenset({'conformance', 'docs', 'python_launch'})
#: What no other test may start, or import.
FULL_PROGRAMS = frozenset({'cmake', 'colcon', 'rclpy'})
#: The events of Python that tell of that (see the table of audit events).
_STARTS = frozenset(
    {'import', 'os.exec', 'os.posix_spawn', 'subprocess.Popen'}
)

#: The test that runs, if it is one of `make quick`.
_quick: list[pytest.Item] = []


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Have one more than there are processors, as many tests wait."""
    return len(os.sched_getaffinity(0)) + 1


@cache
def _is_contract(path: Path) -> bool:
    """Return whether the tests in `path` import nothing of the product."""
    if CONTRACT_FOLDERS.intersection(path.parts):
        return True
    text = path.read_text(encoding='utf-8')
    return re.search(r'^\s*(from|import) colcon_yaml', text, re.M) is None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests of `make gate`, slow ones and those that share a part."""
    for item in items:
        if _is_contract(item.path):
            item.add_marker('contract')
        if FULL_FIXTURES.intersection(getattr(item, 'fixturenames', ())):
            item.add_marker('full')
        # one Slurm is enough for all workers
        if 'slurm' in getattr(item, 'fixturenames', ()):
            item.add_marker(pytest.mark.xdist_group('slurm'))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, Any, Any]:
    """Keep in mind which test runs."""
    if item.get_closest_marker('full') is None:
        _quick.append(item)
    try:
        return (yield)
    finally:
        _quick.clear()


def _guard(event: str, arguments: tuple[Any, ...]) -> None:
    """Fail a test of `make quick` that is about to need more than it may."""
    if event not in _STARTS or not _quick:
        return
    name = Path(os.fsdecode(arguments[0])).name
    if name in FULL_PROGRAMS:
        pytest.fail(f'it needs {name}, so it has to be marked `full`')


sys.addaudithook(_guard)


def _claim(domain_id: int) -> socket.socket | None:
    """
    Claim a domain id on this machine for as long as the socket is open.

    The socket's name is in Linux's abstract namespace, so it leaves no file
    behind, and the claim ends even if the test is killed.
    """
    claim = socket.socket(socket.AF_UNIX)
    try:
        claim.bind(f'\0colcon-yamllaunch-test-domain-{domain_id}')
    except OSError:
        claim.close()
        return None
    return claim


@pytest.fixture
def ros_domain_id() -> Iterator[int]:
    """Give a ROS_DOMAIN_ID that no other running test has."""
    for domain_id in random.sample(DOMAIN_IDS, len(DOMAIN_IDS)):
        claim = _claim(domain_id)
        if claim is not None:
            with claim:
                yield domain_id
            return
    pytest.fail('every ROS_DOMAIN_ID is in use by another test')


@pytest.fixture(scope='session')
def forks() -> Iterator[Forks]:
    """Return what runs code in processes that have colcon imported."""
    forks = Forks()
    yield forks
    forks.close()


@pytest.fixture(scope='session')
def ros_parts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the install space of an underlay with component containers."""
    if importlib.util.find_spec('rclpy') is None:
        pytest.skip('rclpy is not installed (the extra "ros")')
    if not Path(sysconfig.get_path('include'), 'Python.h').exists():
        pytest.skip('Python.h is not installed (Debian: python3-dev)')
    folder = tmp_path_factory.getbasetemp()
    # below this, each worker has a folder of its own
    if 'PYTEST_XDIST_WORKER' in os.environ:
        folder = folder.parent
    return build_once(folder)


@pytest.fixture(scope='session')
def ros_setup(tmp_path_factory: pytest.TempPathFactory) -> RosSetup:
    """Return a ROS 2 that has `launch`, as the wheels have none."""
    setup = read_setup(tmp_path_factory.mktemp('ros_setup'))
    if setup is None:
        pytest.skip(SKIPPED)
    return setup


@pytest.fixture
def sshd(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sshd]:
    """Return machines that `ssh` leads to, all of them on this one."""
    skip_without_sshd()
    with Sshd(tmp_path_factory.mktemp('sshd')) as server:
        yield server


@pytest.fixture(scope='session')
def slurm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Slurm]:
    """Return a Slurm with one node, without jobs unless a test left some."""
    skip_without_slurm()
    with Slurm(tmp_path_factory.mktemp('slurm')) as servers:
        yield servers


@pytest.fixture
def namespace(
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[NamespaceMachine]:
    """Return a machine of namespaces that a command leads to."""
    skip_without_namespaces()
    with NamespaceMachine(tmp_path_factory.mktemp('namespace')) as machine:
        yield machine
