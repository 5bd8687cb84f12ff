# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Processes that wait for others on other machines."""

import os
from pathlib import Path
import re
import signal
import time

from support.deployer import Deployer, HERE

#: Seconds after which a second Ctrl-C is no echo of the first one.
ECHO = 0.5
#: Each ends at SIGINT, and says so.
PART = (
    "trap 'echo NAME down; kill $!; exit 0' INT; echo NAME up; sleep 600 & "
    'wait'
)
ORDER = (
    {'match': 'filter', 'after': 'driver'},
    {'match': 'control', 'after': 'filter'},
    {'match': 'screen', 'after': 'control'},
    # so that what one says arrives before the next one starts
    {'match': '*', 'ready': {'log': ' up$'}},
)


def part(name: str) -> tuple[str, ...]:
    return ('bash', '-c', PART.replace('NAME', name))


def places(deployer: Deployer) -> None:
    """Put a chain of four onto two machines and this computer."""
    homes = {name: deployer.root.parent / name for name in ('arm', 'base')}
    for home in homes.values():
        home.mkdir(exist_ok=True)
    deployer.places(
        {
            'screen': (HERE, part('screen')),
            'control': ('arm', part('control')),
            'filter': ('base', part('filter')),
            'driver': ('arm', part('driver')),
        },
        {
            name: {'connect': f'env HOME={home}'}
            for name, home in homes.items()
        },
        timeouts=20,
        rules=ORDER,
        sync='none',
    )


def test_they_start_and_stop_in_order(deployer: Deployer) -> None:
    places(deployer)
    launch = deployer.deploys()
    launch.wait_for('screen up')
    assert launch.interrupt() == 0, launch.output
    said = re.findall(r'\] +(\w+ (?:up|down))', launch.output)
    assert said == [
        'driver up',
        'filter up',
        'control up',
        'screen up',
        'screen down',
        'control down',
        'filter down',
        'driver down',
    ]


def test_a_second_interrupt_does_not_keep_the_order(
    deployer: Deployer, tmp_path: Path
) -> None:
    deployer.places(
        {
            'screen': (HERE, (*deployer.talker, 'ignores')),
            'driver': ('arm', part('driver')),
        },
        {'arm': {'connect': f'env HOME={tmp_path}'}},
        timeouts=5,
        rules=({'match': 'screen', 'after': 'driver'},),
        sync='none',
    )
    launch = deployer.deploys()
    launch.wait_for(r'screen\S*\] +up')
    launch.wait_for('driver up')
    os.kill(launch.process.pid, signal.SIGINT)
    launch.wait_for('stopping')
    time.sleep(ECHO)
    os.kill(launch.process.pid, signal.SIGINT)
    # though what waited for it still runs
    launch.wait_for(r'driver-\d: .* after')
    assert re.search(r'screen-\d: .* after', launch.output) is None
    launch.interrupt()
    deployer.wait_until_empty()


def test_what_waits_for_a_machine_that_is_gone_never_starts(
    deployer: Deployer, tmp_path: Path
) -> None:
    connect = f'sh -c \'echo $$ > {tmp_path}/pid; exec $0 "$@"\''
    deployer.places(
        {
            'nav': (HERE, part('nav')),
            'driver': ('arm', part('driver')),
        },
        {'arm': {'connect': f'{connect} env HOME={tmp_path}'}},
        rules=(
            {'match': 'driver', 'ready': {'log': 'never'}},
            {'match': 'nav', 'after': 'driver'},
        ),
        sync='none',
    )
    launch = deployer.deploys()
    launch.wait_for('driver up')
    os.kill(int((tmp_path / 'pid').read_text()), signal.SIGKILL)
    launch.wait_for('nav-1: not started, as it waits for arm│driver-2')
    assert launch.end() == 1
    assert 'nav up' not in launch.output
