# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a change of the launch file does on another machine."""

from collections.abc import Mapping, Sequence
import re
import shlex

from support.deployer import Deployer, HERE
from support.sshd import Sshd

Words = Sequence[str]


def _places(
    deployer: Deployer, processes: Mapping[str, tuple[str, Words]]
) -> None:
    deployer.places(processes)
    # by its first letter, so that the deployment file stays as it is
    rules = [{'match': 'a_*', 'machine': 'arm'}]
    deployer.write(
        'robot.yaml',
        f'{{machines: {{arm: {{ssh: arm}}}}, processes: {rules}}}',
    )


def test_a_plan_that_changes_is_changed_there(
    deployer: Deployer, sshd: Sshd
) -> None:
    talker = deployer.talker
    first = {
        'a_stays': ('arm', talker),
        'a_goes': ('arm', talker),
        'a_other': ('arm', talker),
        'here': (HERE, talker),
    }
    _places(deployer, first)
    launch = deployer.deploys('--watch')
    for name in first:
        launch.wait_for(rf'{name}\S*\] +up')
    second = {
        'a_stays': ('arm', talker),
        'a_other': ('arm', (*talker, 'changed')),
        'a_new': ('arm', (*talker, 'new')),
        'here': (HERE, talker),
    }
    _places(deployer, second)
    launch.wait_for(r"\[arm│a_other\S*\] +up \['changed'\]")
    launch.wait_for(r"\[arm│a_new\S*\] +up \['new'\]")
    launch.wait_for(r'\[watch\] .*plain\.yaml.*')
    text = deployer.launch('--status')
    assert re.search(r'arm│a_new\S* +running', text)
    assert not re.search(r'a_goes\S* +running', text)
    output = launch.output
    assert len(re.findall(r'a_stays\S*\] +up', output)) == 1
    assert len(re.findall(r'here\S*\] +up', output)) == 1
    assert launch.interrupt() == 0
    assert 'Traceback' not in launch.output
    assert shlex.join(talker) not in launch.output
    sshd.wait_until_empty()
    deployer.wait_until_empty()
