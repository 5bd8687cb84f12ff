# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A link that is cut, for a while or for good."""

import re
import sys

import pytest
from support.deployer import Deployer, HERE
from support.sshd import Sshd
from support.time_limits import within

pytestmark = pytest.mark.xdist_group('link_lost')

#: Seconds after which a lost link has been told, and a busy machine's more.
TOLD_AFTER = 5.0
LATE = 10.0
#: Prints numbered lines for some seconds.
COUNTING = """\
import sys, time
for number in range(int(sys.argv[1])):
    print('line', number, flush=number % 50 == 0)
    if number % 50 == 0:
        time.sleep(float(sys.argv[2]))
print('all printed', flush=True)
"""


def test_a_part_stops_by_itself(deployer: Deployer, sshd: Sshd) -> None:
    deployer.places(
        {
            'stubborn': ('arm', (*deployer.talker, 'ignores')),
            'other': ('gpu', deployer.talker),
            'own': (HERE, deployer.talker),
        },
        sync='none',
    )
    launch = deployer.deploys()
    for name in ('stubborn', 'other', 'own'):
        launch.wait_for(rf'{name}\S*\] +up')
    sshd['arm'].link.hold()
    with within(TOLD_AFTER + LATE):
        launch.wait_for('arm: the link is lost')
    states = deployer.launch('--status')
    assert re.search(r'arm│stubborn\S* +unknown ', states)
    assert re.search(r'gpu│other\S* +running ', states)
    sshd.wait_until_empty('arm')
    assert sshd.left('gpu')
    sshd['arm'].link.release()
    launch.wait_for('arm is gone')
    launch.interrupt()
    sshd.wait_until_empty()
    assert 'Traceback' not in launch.output


@pytest.mark.parametrize('broken', [False, True])
def test_a_part_runs_on_and_nothing_is_lost(
    deployer: Deployer, sshd: Sshd, broken: bool
) -> None:
    script = deployer.write('counting.py', COUNTING)
    count = 20_000
    command = (sys.executable, str(script), str(count), '0.02')
    deployer.places(
        {'counts': ('arm', command), 'stays': ('arm', deployer.talker)},
        sync='none',
        on_lost='keep',
    )
    launch = deployer.deploys()
    launch.wait_for('line 1000')
    link = sshd['arm'].link
    if broken:
        link.break_off()
    else:
        link.hold()
        launch.wait_for('arm: the link is lost')
        link.release()
    launch.wait_for(r'all printed')
    launch.interrupt()
    sshd.wait_until_empty()
    lines = re.findall(r'line (\d+)$', deployer.logged('counts'), re.M)
    assert list(map(int, lines)) == [*range(count)]


def test_broken_connection_restarts_the_part(
    deployer: Deployer, sshd: Sshd
) -> None:
    deployer.places(
        {
            'stubborn': ('arm', (*deployer.talker, 'ignores')),
            'own': (HERE, deployer.talker),
        },
        sync='none',
        on_lost='restart',
    )
    launch = deployer.deploys()
    for name in ('stubborn', 'own'):
        launch.wait_for(rf'{name}\S*\] +up')
    sshd['arm'].link.break_off()
    launch.wait_for(r'(?s)is gone.*stubborn\S*\] +up')
    # the first one has ended before
    talkers = [line for line in sshd.left('arm') if 'talker.py' in line]
    assert len(talkers) == 1
    assert launch.interrupt() == 0, launch.output
    sshd.wait_until_empty()
